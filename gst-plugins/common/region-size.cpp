#include "region-size.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {
constexpr double kSide = 30; // px, in the picture of the paper
constexpr double kPictureWidth = 352;
constexpr double kDoubling = 0.5; // a quarter of the workspace, in z
} // namespace

int default_region_side(int picture_width) noexcept {
  return std::max(1, static_cast<int>(std::lround(picture_width * kSide / kPictureWidth)));
}

double region_growth(double z) noexcept {
  return std::exp2(z / kDoubling);
}

double region_side(double z, double base, double picture_width, double picture_height) noexcept {
  const double smallest = std::max<double>(
      kSmallestRegion, std::round(picture_width * kSmallestRegion / kPictureWidth));
  const double largest = std::max(smallest, std::min(picture_width, picture_height) / 2);
  return std::clamp(base * region_growth(z), smallest, largest);
}

} // namespace haptic
