// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/held-trail.hpp"

#include <cstddef>

namespace haptic {
namespace {

constexpr std::uint64_t kLength = 1'000'000'000; // ns
// A second at 240 frames per second. Times that stand still must not make it longer.
constexpr std::size_t kMostPoints = 240;

} // namespace

void HeldTrail::add(const HeldPlace &held) {
  if (held.state == HoldState::none || held.time < time_)
    forget();
  time_ = held.time;
  std::erase_if(points_, [&](const Point &point) { return time_ - point.time > kLength; });
  const bool seen = is_followed(held.state);
  if (seen) {
    if (points_.size() == kMostPoints)
      points_.erase(points_.begin());
    points_.push_back({held.x, held.y, held.time, seen_});
  }
  seen_ = seen;
}

} // namespace haptic
