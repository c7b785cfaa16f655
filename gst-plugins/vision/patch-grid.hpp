// SPDX-License-Identifier: LGPL-2.1-or-later
// Patches side by side over an area of a pyramid.
#pragma once

#include "lk-kernels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace haptic {

inline constexpr int kMostLevels = 5;
inline constexpr int kSmallPatch = 8;  // px
inline constexpr int kLargePatch = 16; // px
inline constexpr int kRim = 4;         // px around a patch, for gradients and interpolation
inline constexpr int kSmoothingRadius =
    1; // px by which planes are smaller than the frame on every side

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

/// Index into a table with so many columns.
inline std::size_t cell(int row, int columns, int column) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
         static_cast<std::size_t>(column);
}

inline bool fits_into(const Plane &plane, int side) {
  return std::min(plane.width(), plane.height()) >= side + kRim;
}

inline int parts_of(float length, float part, int most) {
  return std::clamp(static_cast<int>(std::lround(length / part)), 1, most);
}

struct PatchGrid {
  int columns = 0;
  int rows = 0;
  std::array<Template, kMaxPatches> patches;

  std::span<Template> view() { return {patches.data(), static_cast<std::size_t>(columns * rows)}; }

  /// Fills the grid with patches that are evenly spread over the area of the plane. `dither`: off
  /// the raster of the pixels.
  void cover(const Plane &plane, const Area &area, int wanted_columns, int wanted_rows, int side,
             bool dither);
};

} // namespace haptic
