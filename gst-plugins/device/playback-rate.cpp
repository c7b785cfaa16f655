#include "playback-rate.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {
constexpr double kFastest = 2 * (1 + 1e-6); // twice is still felt, whatever the rounding
constexpr double kLongest = 1e18;           // ns, what its type can hold
} // namespace

std::optional<MotionSample> play(MotionSample sample, const Playback &playback,
                                 RateLaw law) noexcept {
  const double rate = std::abs(playback.rate);
  const double applied = std::abs(playback.applied_rate);
  // Written so that NaN is mute.
  if (playback.skips || !(rate > 0) || !(applied > 0) || !(rate * applied <= kFastest))
    return std::nullopt;
  sample.interval =
      static_cast<std::uint64_t>(std::min(static_cast<double>(sample.interval) / rate, kLongest));
  const double factor = law == RateLaw::as_seen ? rate : 1 / applied;
  for (float *value : {&sample.velocity_x, &sample.velocity_y, &sample.spin, &sample.divergence})
    *value = static_cast<float>(factor * *value);
  return sample;
}

} // namespace haptic
