// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track-clock.hpp"

#include <algorithm>

namespace haptic {
namespace {

constexpr std::uint64_t kLongestWait = 2 * kSecond; // ns

} // namespace

std::uint64_t TrackClock::recovered(std::uint64_t time, std::uint64_t start) const noexcept {
  if (pts_ == kNoTime)
    return start;
  const std::uint64_t forward = time - time_;
  const std::uint64_t back = time_ - time;
  if (time_ != kNoTime && forward <= kLargestTimeStep)
    return pts_ + forward;
  if (time_ != kNoTime && back <= std::min(kLargestTimeStep, pts_))
    return pts_ - back;
  return pts_ + duration_; // the sender was started anew
}

bool TrackClock::wait_for_tie(std::uint64_t time) noexcept {
  first_untied_ = std::min(first_untied_, time);
  return time - first_untied_ >= kLongestWait;
}

void TrackClock::remember(std::uint64_t pts, std::uint64_t time, std::uint64_t duration) noexcept {
  if (pts == kNoTime)
    return;
  pts_ = pts;
  time_ = time;
  duration_ = duration == kNoTime ? 0 : std::min(duration, kSecond);
}

void TrackClock::forget() noexcept {
  *this = {};
}

} // namespace haptic
