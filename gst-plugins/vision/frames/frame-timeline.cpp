// SPDX-License-Identifier: LGPL-2.1-or-later
#include "frames/frame-timeline.hpp"

#include <algorithm>

namespace haptic {
namespace {

// A pause is long for its own stream: some have a frame every 0.7 s.
constexpr std::uint64_t kShortestPause = 2'000'000'000;
constexpr std::uint64_t kPauseInIntervals = 10;

} // namespace

TimeStep FrameTimeline::advance(std::optional<std::uint64_t> pts, bool descending) {
  if (!pts) {
    forget();
    return {TimeStep::Kind::restarts, 0, "a frame has no time stamp"};
  }
  const std::optional<std::uint64_t> before = last_;
  last_ = pts;
  if (!before || !reference_)
    return {};
  if (*pts == *before)
    return {TimeStep::Kind::repeats, 0, "two frames have the same time stamp"};
  const bool falls = *pts < *before;
  if (falls != descending) {
    reference_.reset();
    return {TimeStep::Kind::restarts, 0, "a time stamp runs against the direction of play"};
  }
  const std::uint64_t step = falls ? *before - *pts : *pts - *before;
  const std::uint64_t longest = std::max(kShortestPause, kPauseInIntervals * usual_interval_);
  usual_interval_ = step;
  if (step > longest) {
    reference_.reset();
    return {};
  }
  return {TimeStep::Kind::follows, falls ? *reference_ - *pts : *pts - *reference_, nullptr};
}

} // namespace haptic
