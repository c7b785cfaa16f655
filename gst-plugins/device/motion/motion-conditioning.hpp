// SPDX-License-Identifier: LGPL-2.1-or-later
// From a measured motion to the motion that a force law gets: scaled to the reference width, free
// of noise at standstill, and low-passed on request.
#pragma once

#include "samples/motion-field.hpp"

#include <spidar/types.hpp>

namespace haptic {

/// In the plane of the frame: x to the right, y down.
struct PlanarVelocity {
  double x = 0; ///< px/s
  double y = 0; ///< px/s
};

/// Motion as the force laws get it: in pixels of a frame of the reference width, both axes in units
/// of its pixel width.
struct Motion {
  PlanarVelocity velocity;
  double spin = 0;       ///< rad/s, positive turns x towards y
  double divergence = 0; ///< 1/s
};

/// Returns v' = v * reference_width / frame_width, the vertical part also divided by the pixel
/// aspect ratio. `reference_width` in px; 0 keeps the pixels of the frame itself. Real-time safe.
Motion scale_motion(const MotionSample &sample, double reference_width) noexcept;

/// Returns the hand's velocity (m/s, y up) as that of the point in the frame, in the same unit: the
/// workspace is the frame (paper, equation 1). Real-time safe.
PlanarVelocity scale_hand(const spidar::Vector3 &velocity, const spidar::Vector3 &workspace_half,
                          const MotionSample &sample, double reference_width) noexcept;

/// Returns false for motions that no tracker can measure: faster than 1e6 px/s (the width of an 8K
/// frame in a hundredth of a second), or more than 1e4 rad/s or 1e4 1/s. Such a sample is damaged.
bool is_plausible(const MotionSample &sample) noexcept;
bool is_plausible(const MotionField &field) noexcept;

/// Speeds of the deadband, px/s of the reference width: no motion up to the first, the motion as it
/// is from the second on, linear between, so that the force does not chatter around standstill.
inline constexpr double kStillSpeed = 3;
inline constexpr double kMovingSpeed = 6;

/// Deadband, then low-pass. One thread; real-time safe.
class MotionConditioner {
public:
  /// `cutoff` of the first-order low-pass in Hz, 0: off. `dt` in s since the call before. A motion
  /// that turns round passes through zero without standing still: the deadband uses the fastest
  /// speed of the last moments (release 0.1 s).
  const Motion &step(const Motion &scaled, double cutoff, double dt) noexcept;

  /// The low-pass begins anew with the next motion.
  void restart_low_pass() noexcept;

private:
  Motion output_;
  double fastest_ = 0; // px/s
  bool begun_ = false;
};

} // namespace haptic
