// SPDX-License-Identifier: LGPL-2.1-or-later
#include "playback-rate.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {
constexpr double kFastest = 2 * (1 + 1e-6); // twice is still felt, whatever the rounding
constexpr double kMostFactor = 1e6;         // velocities stay finite
constexpr double kLongest = 1e18;           // ns, what its type can hold
// What velocities are multiplied with.
std::optional<double> factor_of(const Playback &playback, RateLaw law) noexcept {
  const double rate = std::abs(playback.rate);
  const double applied = std::abs(playback.applied_rate);
  // Written so that NaN is mute.
  if (playback.skips || !(rate > 0) || !(applied > 0) || !(rate * applied <= kFastest))
    return std::nullopt;
  const double factor = law == RateLaw::as_seen ? rate : 1 / applied;
  return factor <= kMostFactor ? std::optional(factor) : std::nullopt;
}

std::uint64_t lived_through(std::uint64_t interval, const Playback &playback) noexcept {
  return static_cast<std::uint64_t>(
      std::min(static_cast<double>(interval) / std::abs(playback.rate), kLongest));
}

} // namespace

std::optional<MotionSample> play(MotionSample sample, const Playback &playback,
                                 RateLaw law) noexcept {
  const auto factor = factor_of(playback, law);
  if (!factor)
    return std::nullopt;
  sample.interval = lived_through(sample.interval, playback);
  for (float *value : {&sample.velocity_x, &sample.velocity_y, &sample.spin, &sample.divergence})
    *value = static_cast<float>(*factor * *value);
  return sample;
}

bool play(MotionField &field, const Playback &playback, RateLaw law) noexcept {
  const auto factor = factor_of(playback, law);
  if (!factor)
    return false;
  field.interval = lived_through(field.interval, playback);
  for (FieldCell &cell : field.cells) {
    cell.velocity_x = static_cast<float>(*factor * cell.velocity_x);
    cell.velocity_y = static_cast<float>(*factor * cell.velocity_y);
  }
  return true;
}

} // namespace haptic
