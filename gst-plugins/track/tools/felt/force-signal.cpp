// SPDX-License-Identifier: LGPL-2.1-or-later
#include "felt/force-signal.hpp"

#include "samples/motion-force.hpp"

#include <cmath>

namespace haptic {
namespace {

constexpr double kLongestLogGap = 0.1; // s

Force force_between(const TimedForce &a, const TimedForce &b, double share) {
  const auto s = static_cast<float>(share);
  return {std::lerp(a.force.x, b.force.x, s), std::lerp(a.force.y, b.force.y, s),
          std::lerp(a.force.z, b.force.z, s)};
}

Force force_of(const FeltMotion &motion, const ForceLaw &law) {
  const double gain = arctan_gain(std::hypot(motion.right, motion.up), law.alpha, law.max_force) *
                      confidence_gate(motion.confidence);
  return {static_cast<float>(gain * motion.right), static_cast<float>(gain * motion.up), 0};
}

} // namespace

FeltMotion felt_motion(const MotionSample &sample, std::uint64_t time) noexcept {
  const auto velocity = reference_velocity(sample);
  const double middle = static_cast<double>(time) - 0.5 * static_cast<double>(sample.interval);
  return {middle * 1e-9, velocity.right, velocity.up, sample.confidence};
}

FeltMotion interpolated(const FeltMotion &a, const FeltMotion &b, double share) noexcept {
  const FeltMotion &from = a.confidence > 0 ? a : b;
  const FeltMotion &to = b.confidence > 0 ? b : a;
  return {std::lerp(a.time, b.time, share), std::lerp(from.right, to.right, share),
          std::lerp(from.up, to.up, share),
          std::lerp(a.confidence, b.confidence, static_cast<float>(share))};
}

ForceSignal signal_of_log(std::span<const TimedForce> rows) {
  return signal_over(rows, reader_of(rows, kLongestLogGap, force_between));
}

ForceSignal signal_of_motions(std::span<const FeltMotion> motions, const ForceLaw &law) {
  const auto between = [&](const FeltMotion &a, const FeltMotion &b, double share) {
    return force_of(interpolated(a, b, share), law);
  };
  return signal_over(motions, reader_of(motions, kLongestMotionGap, between));
}

} // namespace haptic
