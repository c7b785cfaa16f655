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

int default_region_side(int picture_width) {
  constexpr double kSide = 30;
  constexpr double kPictureWidth = 352;
  return std::max(1, static_cast<int>(std::lround(picture_width * kSide / kPictureWidth)));
}

int RegionSize::side(double z, int base, int picture_width, int picture_height) {
  constexpr double kDoubling = 0.5; // a quarter of the workspace, in z
  constexpr double kHysteresis = 0.1;
  const double smallest =
      std::max<double>(kSmallestRegion, std::round(picture_width * kSmallestRegion / 352.0));
  const double largest = std::max(smallest, std::min(picture_width, picture_height) / 2.0);
  const double wanted = std::clamp(base * std::exp2(z / kDoubling), smallest, largest);
  // A hand about the centre, and a pointer without a third dimension, mean the size as it is set.
  if (std::abs(std::exp2(z / kDoubling) - 1) <= kHysteresis)
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
