// SPDX-License-Identifier: LGPL-2.1-or-later
// The path of a hand over the frame.
#pragma once

#include "samples/pointer-position.hpp"

#include <algorithm>
#include <vector>

namespace haptic {

struct TimedPlace {
  double time = 0; ///< s
  float x = 0.5F;  ///< 0..1, fractions of the frame as of PointerPosition
  float y = 0.5F;
  float z = 0; ///< -1..1

  PointerPosition position() const { return {.x = x, .y = y, .z = z}; }
};

/// s, between what is felt along a path: 100 a second.
inline constexpr double kPathStep = 0.01;

/// Returns the place at a time; before the path begins, its first one. The path is not empty.
inline PointerPosition place_at(const std::vector<TimedPlace> &path, double time) {
  const auto after = std::ranges::upper_bound(path, time, {}, &TimedPlace::time);
  return (after == path.begin() ? after : after - 1)->position();
}

} // namespace haptic
