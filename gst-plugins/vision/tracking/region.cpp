// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracking/region.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

struct Interval {
  int begin;
  int end;
};

// The callers bound side and centre, so that no sum overflows.
Interval interval_at(double centre, int side, int limit) {
  const int begin = static_cast<int>(std::lround(centre - side / 2.0));
  return {std::clamp(begin, 0, limit - 1), std::clamp(begin + side, 1, limit)};
}

} // namespace

int RegionSize::side(double z, int base, int frame_width, int frame_height) {
  constexpr double kHysteresis = 0.1;
  const double wanted = region_side(z, base, frame_width, frame_height);
  // A hand near the centre, and a pointer without a third dimension, choose the size that is set.
  if (std::abs(region_growth(z) - 1) <= kHysteresis)
    side_ = base;
  else if (side_ == 0 || std::abs(wanted - side_) > kHysteresis * side_)
    side_ = 2 * static_cast<int>(std::lround(wanted / 2));
  return side_;
}

Rectangle region_at(double pointer_x, double pointer_y, int side, int frame_width,
                    int frame_height) {
  const Interval x = interval_at(pointer_x * frame_width, side, frame_width);
  const Interval y = interval_at(pointer_y * frame_height, side, frame_height);
  return {x.begin, y.begin, x.end - x.begin, y.end - y.begin};
}

Rectangle crop_around(const Rectangle &region, int margin, int frame_width, int frame_height) {
  const int left = std::max(region.x - margin, 0);
  const int top = std::max(region.y - margin, 0);
  const int right = std::min(region.x + region.width + margin, frame_width);
  const int bottom = std::min(region.y + region.height + margin, frame_height);
  return {left, top, right - left, bottom - top};
}

bool is_measurable(const Rectangle &region) {
  return region.width >= kSmallestRegion && region.height >= kSmallestRegion;
}

} // namespace haptic
