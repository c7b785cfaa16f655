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

/// Returns a signal of zeros that lasts as long as the knots, whose times (s) rise.
template <typename Knot>
ForceSignal silence(std::span<const Knot> knots) {
  ForceSignal signal;
  if (knots.empty())
    return signal;
  const auto step_of = [](double time) {
    return static_cast<std::int64_t>(std::ceil(time / kForceStep - 1e-6));
  };
  signal.first = step_of(knots.front().time);
  const std::int64_t last = std::max(step_of(knots.back().time), signal.first);
  signal.forces.resize(static_cast<std::size_t>(last - signal.first + 1));
  return signal;
}

/// Reads knots at rising steps.
template <typename Knot>
class KnotReader {
public:
  /// `longest_gap`: s.
  KnotReader(std::span<const Knot> knots, double longest_gap)
      : knots_(knots), longest_gap_(longest_gap) {}

  /// Returns what `between(before, after, share)` makes of the knots around the step; nothing
  /// outside them and in gaps.
  template <typename Between>
  auto at(std::int64_t step, const Between &between) {
    const double time = static_cast<double>(step) * kForceStep;
    while (next_ < knots_.size() && knots_[next_].time <= time + 1e-6 * kForceStep)
      ++next_;
    using Value = decltype(between(knots_[0], knots_[0], 0.0));
    if (next_ == 0)
      return Value{};
    const Knot &before = knots_[next_ - 1];
    if (next_ == knots_.size())
      return time - before.time < kForceStep ? between(before, before, 0.0) : Value{};
    const double length = knots_[next_].time - before.time;
    if (length > longest_gap_)
      return Value{};
    return between(before, knots_[next_], std::clamp((time - before.time) / length, 0.0, 1.0));
  }

private:
  std::span<const Knot> knots_;
  double longest_gap_;
  std::size_t next_ = 0;
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
