// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/held-path.hpp"

#include "seconds.hpp"

#include <algorithm>

namespace haptic {

WayPoint middle_of_way(const HeldPlace &before, const HeldPlace &after,
                       std::int64_t interval) noexcept {
  const FramePoint place{after.x, after.y};
  if (interval <= 0 || before.state != HoldState::held || !is_same_thing(before, after))
    return {place, {}};
  const double time = seconds(interval);
  return {{(before.x + place.x) / 2, (before.y + place.y) / 2},
          {(place.x - before.x) / time, (place.y - before.y) / time}};
}

void HeldPath::begin(const WayPoint &there, std::int64_t now) noexcept {
  begun_ = true;
  stops_ = false;
  from_ = to_ = there;
  begin_ = end_ = now;
  last_ = there.place;
}

void HeldPath::head_for(const WayPoint &there, std::int64_t time, std::int64_t now) noexcept {
  from_ = point(now);
  to_ = there;
  begin_ = now;
  end_ = std::max(time, now + 1);
}

void HeldPath::lead_to(const WayPoint &there, std::int64_t time, std::int64_t now) noexcept {
  if (!stops_ && to_ == there && end_ == time)
    return;
  head_for(there, time, now);
  stops_ = false;
}

void HeldPath::stop_at(const FramePoint &place, std::int64_t interval, std::int64_t now) noexcept {
  const WayPoint rest{place, {}};
  if (stops_ && to_ == rest)
    return;
  head_for(rest, now + interval, now);
  stops_ = true;
}

// Cubic Hermite spline. Where the intervals are equal it is the quadratic B-spline of the places,
// whose speed runs in straight lines between the middles of the intervals, as the velocities do.
WayPoint HeldPath::point(std::int64_t now) const noexcept {
  if (now >= end_)
    return to_;
  const double length = seconds(end_ - begin_); // s
  const double s = std::clamp(seconds(now - begin_) / length, 0.0, 1.0);
  const auto along = [&](double from, double from_speed, double to, double to_speed) {
    const double way = to - from;
    const double early = from_speed * length;
    const double late = to_speed * length;
    const double square = 3 * way - 2 * early - late;
    const double cube = early + late - 2 * way;
    struct {
      double place, speed;
    } at{from + s * (early + s * (square + s * cube)),
         (early + s * (2 * square + s * 3 * cube)) / length};
    return at;
  };
  const auto x = along(from_.place.x, from_.speed.x, to_.place.x, to_.speed.x);
  const auto y = along(from_.place.y, from_.speed.y, to_.place.y, to_.speed.y);
  return {{x.place, y.place}, {x.speed, y.speed}};
}

HeldAt HeldPath::at(std::int64_t now) noexcept {
  const FramePoint place = point(now).place;
  const FramePoint moved{place.x - last_.x, place.y - last_.y};
  last_ = place;
  return {.place = place, .moved = moved};
}

} // namespace haptic
