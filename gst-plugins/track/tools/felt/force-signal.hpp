// SPDX-License-Identifier: LGPL-2.1-or-later
// The force of a track or a log as a signal: a force each millisecond.
#pragma once

#include "samples/force-defaults.hpp"
#include "samples/motion-sample.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace haptic {

/// Time from one force of a signal to the next, s.
inline constexpr double kForceStep = 0.001;

/// N; x to the right, y up, z towards the user.
struct Force {
  float x = 0;
  float y = 0;
  float z = 0;

  bool operator==(const Force &) const = default;
};

/// Force i acts at (first + i) kForceStep. Before and after the signal the force is zero.
struct ForceSignal {
  std::int64_t first = 0;
  std::vector<Force> forces;

  std::int64_t end() const noexcept { return first + static_cast<std::int64_t>(forces.size()); }
  /// Returns the force at a step from time 0.
  Force at(std::int64_t step) const noexcept {
    return step < first || step >= end() ? Force{} : forces[static_cast<std::size_t>(step - first)];
  }
};

/// A row of a log.
struct TimedForce {
  double time = 0; ///< s
  Force force;
};

/// The motion of a sample or under a hand, without what the force does not depend on.
struct FeltMotion {
  double time = 0;  ///< s, the middle of the interval that it was measured over
  double right = 0; ///< px/s, in a frame kReferenceWidth wide
  double up = 0;    ///< px/s
  float confidence = 0;
};

FeltMotion felt_motion(const MotionSample &sample, std::uint64_t time) noexcept;

/// Returns the motion on the straight line from `a` to `b`. Where one of them was not measured the
/// other goes on, and the confidence falls.
FeltMotion interpolated(const FeltMotion &a, const FeltMotion &b, double share) noexcept;

/// Equation 5 of the paper, on the speed, times confidence_gate().
struct ForceLaw {
  double alpha = kDefaultAlpha; ///< s/px
  double max_force = 1;         ///< N
};

/// Between motions farther apart, s, the force is zero.
inline constexpr double kLongestMotionGap = 0.3;

/// Both return a signal that is linear between the rows, or in the motions between their times.
/// The times rise. Between rows more than 0.1 s apart the force is zero.
ForceSignal signal_of_log(std::span<const TimedForce> rows);
ForceSignal signal_of_motions(std::span<const FeltMotion> motions, const ForceLaw &law);

} // namespace haptic
