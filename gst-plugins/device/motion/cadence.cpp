// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/cadence.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {
constexpr double kSame = 0.15; // of an interval; time stamps in ms are off by some percent
}

void Cadence::restart() noexcept {
  count_ = 0;
  repeated_ = false;
}

// Returns the mean interval in s, or 0 if the intervals have no such period or no frame was
// repeated (uneven time stamps are true then).
double Cadence::mean_of_pattern(std::size_t period) const noexcept {
  double sum = 0;
  bool repeated = false;
  for (std::size_t i = 0; i < period; ++i) {
    const Interval &now = interval(i);
    const Interval &before = interval(i + period);
    if (now.repeated != before.repeated ||
        std::abs(now.seconds - before.seconds) > kSame * now.seconds)
      return 0;
    sum += now.seconds;
    repeated = repeated || now.repeated;
  }
  return repeated ? sum / static_cast<double>(period) : 0;
}

double Cadence::correction(const MotionSample &sample) noexcept {
  if (sample.flags & kMotionDuplicate) {
    repeated_ = true;
    return 1;
  }
  if (sample.interval == 0) {
    restart();
    return 1;
  }
  newest_ = (newest_ + 1) % kMemory;
  intervals_[newest_] = {static_cast<double>(sample.interval) * 1e-9, repeated_};
  repeated_ = false;
  count_ = std::min(count_ + 1, kMemory);
  for (std::size_t period = 1; 2 * period <= count_; ++period)
    if (const double mean = mean_of_pattern(period); mean > 0)
      return interval(0).seconds / mean;
  return 1;
}

} // namespace haptic
