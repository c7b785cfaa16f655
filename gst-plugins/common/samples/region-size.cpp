// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/region-size.hpp"

#include "samples/force-defaults.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {
constexpr double kSide = 30;      // px, in a frame kReferenceWidth wide
constexpr double kDoubling = 0.5; // a quarter of the workspace, in z
} // namespace

int default_region_side(int frame_width) noexcept {
  return std::max(1, static_cast<int>(std::lround(frame_width * kSide / kReferenceWidth)));
}

double region_growth(double z) noexcept {
  return std::exp2(z / kDoubling);
}

double region_side(double z, double base, double frame_width, double frame_height) noexcept {
  const double smallest = std::max<double>(
      kSmallestRegion, std::round(frame_width * kSmallestRegion / kReferenceWidth));
  const double largest = std::max(smallest, std::min(frame_width, frame_height) / 2);
  // A base beyond these bounds is its own: the hand makes it no smaller by pulling.
  return std::clamp(base * region_growth(z), std::min(smallest, base), std::max(largest, base));
}

} // namespace haptic
