// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/playback-rate.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {
constexpr double kFastestPlayback = 2 * (1 + 1e-6); // twice is still felt, despite rounding
constexpr double kLargestFactor = 1e6;              // velocities stay finite
constexpr double kLongest = 1e18;                   // ns, within std::uint64_t
} // namespace

// As seen: v' = |rate| v. As filmed: v' = v / |applied_rate|. Interval: T' = T / |rate|.
bool apply_playback(TimedMotion &motion, const Playback &playback, RateLaw law) noexcept {
  const double rate = std::abs(playback.rate);
  const double applied = std::abs(playback.applied_rate);
  // Written so that NaN fails.
  if (playback.skips || !(rate > 0) || !(applied > 0) || !(rate * applied <= kFastestPlayback))
    return false;
  const double factor = law == RateLaw::as_seen ? rate : 1 / applied;
  if (!(factor <= kLargestFactor))
    return false;
  scale_velocities(motion, factor);
  set_interval(motion, static_cast<std::uint64_t>(
                           std::min(static_cast<double>(motion.sample.interval) / rate, kLongest)));
  return true;
}

} // namespace haptic
