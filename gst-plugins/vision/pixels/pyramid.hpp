// SPDX-License-Identifier: LGPL-2.1-or-later
// A frame at several sizes, and places in it.
#pragma once

#include "pixels/image-kernels.hpp"

#include <array>
#include <cstddef>

namespace haptic {

inline constexpr int kMostLevels = 5;
inline constexpr int kSmoothingRadius = 1; // px that a plane lacks on every side of the frame

/// A rectangle in pixels of some level; pixel i covers i..i+1.
struct Area {
  float x;
  float y;
  float width;
  float height;

  Area at_level(int level) const {
    const float scale = 1 / static_cast<float>(1 << level);
    return {x * scale, y * scale, width * scale, height * scale};
  }
  /// The same place in the smoothed plane of the frame, which begins kSmoothingRadius further in.
  Area in_plane() const { return {x - kSmoothingRadius, y - kSmoothingRadius, width, height}; }
};

/// One frame, from fine to coarse.
struct Pyramid {
  std::array<Plane, kMostLevels> levels;

  void build(const LumaView &view, std::size_t count) {
    smooth(view, levels[0]);
    for (std::size_t i = 1; i < count; ++i)
      halve(levels[i - 1], levels[i]);
  }
};

} // namespace haptic
