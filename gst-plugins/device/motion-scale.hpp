// SPDX-License-Identifier: LGPL-2.1-or-later
// From the pixels of a sample's own frame to those of the reference width.
#pragma once

#include "motion-field.hpp"

#include <spidar/types.hpp>

namespace haptic {

/// In the plane of the frame: x to the right, y down.
struct PlanarVelocity {
  double x = 0; ///< px/s
  double y = 0; ///< px/s
};

struct PlanarForce {
  double x = 0; ///< N
  double y = 0; ///< N
};

/// Motion as the force laws see it: in pixels of a frame of the reference width, both axes in
/// units of its pixel width.
struct Motion {
  PlanarVelocity velocity;
  double spin = 0;       ///< rad/s, positive turns x towards y
  double divergence = 0; ///< 1/s
};

/// `reference_width` in px; 0 keeps the pixels of the frame itself. Real-time safe.
Motion scale_motion(const MotionSample &sample, double reference_width) noexcept;

/// The hand's velocity (m/s, y up) as that of its point in the frame, in the same unit: the
/// workspace is the frame (paper, equation 1). Real-time safe.
PlanarVelocity scale_hand(const spidar::Vector3 &velocity, const spidar::Vector3 &workspace_half,
                          const MotionSample &sample, double reference_width) noexcept;

/// False for motions that no tracker can measure: faster than 1e6 px/s, an 8K frame's width in a
/// hundredth of a second; or 1e4 turns or doublings a second. Such a sample is damaged.
bool is_plausible(const MotionSample &sample) noexcept;
bool is_plausible(const MotionField &field) noexcept;

} // namespace haptic
