// SPDX-License-Identifier: LGPL-2.1-or-later
// The force of a motion as files and pictures hold it: a fraction of the full force, by the paper's
// law.
#pragma once

#include "samples/motion-sample.hpp"

namespace haptic {

struct CurveForce {
  double x = 0; ///< fraction of the full force, to the right
  double y = 0; ///< up

  bool operator==(const CurveForce &) const = default;
};

/// px/s in a frame kReferenceWidth wide; both axes in units of its pixel width.
struct ReferenceVelocity {
  double right = 0;
  double up = 0;
};

/// Returns zero if the numbers of the sample give none that is finite.
ReferenceVelocity reference_velocity(const MotionSample &sample) noexcept;

/// Returns the force of a motion by the paper's law (equation 5) with kDefaultAlpha, in a frame
/// kReferenceWidth wide, times confidence_gate() (force-defaults.hpp).
CurveForce force_of_motion(const MotionSample &sample) noexcept;

/// Returns whether confidence_gate() lets anything through.
bool is_felt(const MotionSample &sample) noexcept;

} // namespace haptic
