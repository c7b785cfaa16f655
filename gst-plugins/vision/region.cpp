#include "region.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

struct Interval {
  int begin;
  int end;
};

// Side and centre are bounded by the callers, so that the sums stay far from an int's limits.
Interval interval_at(double centre, int side, int limit) {
  const int begin = static_cast<int>(std::lround(centre - side / 2.0));
  return {std::clamp(begin, 0, limit - 1), std::clamp(begin + side, 1, limit)};
}

} // namespace

int RegionSize::side(double z, int base, int picture_width, int picture_height) {
  constexpr double kHysteresis = 0.1;
  const double wanted = region_side(z, base, picture_width, picture_height);
  // A hand about the centre, and a pointer without a third dimension, mean the size as it is set.
  if (std::abs(region_growth(z) - 1) <= kHysteresis)
    side_ = base;
  else if (side_ == 0 || std::abs(wanted - side_) > kHysteresis * side_)
    side_ = 2 * static_cast<int>(std::lround(wanted / 2));
  return side_;
}

Rectangle region_at(double pointer_x, double pointer_y, int side, int picture_width,
                    int picture_height) {
  const Interval x = interval_at(pointer_x * picture_width, side, picture_width);
  const Interval y = interval_at(pointer_y * picture_height, side, picture_height);
  return {x.begin, y.begin, x.end - x.begin, y.end - y.begin};
}

Rectangle crop_around(const Rectangle &region, int margin, int picture_width, int picture_height) {
  const int left = std::max(region.x - margin, 0);
  const int top = std::max(region.y - margin, 0);
  const int right = std::min(region.x + region.width + margin, picture_width);
  const int bottom = std::min(region.y + region.height + margin, picture_height);
  return {left, top, right - left, bottom - top};
}

bool is_measurable(const Rectangle &region) {
  return region.width >= kSmallestRegion && region.height >= kSmallestRegion;
}

} // namespace haptic
