// SPDX-License-Identifier: LGPL-2.1-or-later
// The force of a track or a log as a signal: a force each millisecond.
#pragma once

#include "samples/force-defaults.hpp"
#include "samples/motion-sample.hpp"

#include <algorithm>
#include <cmath>
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

/// Returns a function that is called with rising steps. It returns what `between(before, after,
/// share)` makes of the knots around the step, whose times (s) rise; nothing outside them and in
/// gaps longer than `longest_gap` (s).
template <typename Knot, typename Between>
auto reader_of(std::span<const Knot> knots, double longest_gap, Between between) {
  return [=, next = std::size_t{0}](std::int64_t step) mutable {
    using Value = decltype(between(knots[0], knots[0], 0.0));
    const double time = static_cast<double>(step) * kForceStep;
    while (next < knots.size() && knots[next].time <= time + 1e-6 * kForceStep)
      ++next;
    if (next == 0)
      return Value{};
    const Knot &before = knots[next - 1];
    if (next == knots.size())
      return time - before.time < kForceStep ? between(before, before, 0.0) : Value{};
    const double length = knots[next].time - before.time;
    if (length > longest_gap)
      return Value{};
    return between(before, knots[next], std::clamp((time - before.time) / length, 0.0, 1.0));
  };
}

/// Returns the signal of `force_at(step)` that lasts as long as the knots.
template <typename Knot, typename ForceAt>
ForceSignal signal_over(std::span<const Knot> knots, ForceAt force_at) {
  ForceSignal signal;
  if (knots.empty())
    return signal;
  const auto step_of = [](double time) {
    return static_cast<std::int64_t>(std::ceil(time / kForceStep - 1e-6));
  };
  signal.first = step_of(knots.front().time);
  const std::int64_t last = std::max(step_of(knots.back().time), signal.first);
  signal.forces.reserve(static_cast<std::size_t>(last - signal.first + 1));
  for (std::int64_t step = signal.first; step <= last; ++step)
    signal.forces.push_back(force_at(step));
  return signal;
}

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
