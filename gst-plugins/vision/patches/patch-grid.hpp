// SPDX-License-Identifier: LGPL-2.1-or-later
// Patches side by side over an area of a pyramid.
#pragma once

#include "patches/lk-kernels.hpp"
#include "patches/measurement.hpp"
#include "pixels/pyramid.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace haptic {

inline constexpr int kSmallPatch = 8;  // px
inline constexpr int kLargePatch = 16; // px
inline constexpr int kRim = 4;         // px around a patch, for gradients and interpolation
inline constexpr int kMostAlong = 8;   // patches along one side of a grid
static_assert(kMostAlong * kMostAlong <= kMaxPatches);

/// Index into a table with so many columns.
inline std::size_t cell(int row, int columns, int column) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
         static_cast<std::size_t>(column);
}

/// Calls body(row, column) for every place of a grid (anything with `rows` and `columns`).
template <typename Grid, typename Body>
void for_places(const Grid &grid, Body &&body) {
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column)
      body(row, column);
}

/// Calls test(row, column) for the neighbours of a place, diagonal ones too, and for itself, until
/// it returns false. Returns whether it never did.
template <typename Grid, typename Test>
bool all_neighbours(const Grid &grid, int row, int column, Test &&test) {
  for (int y = std::max(0, row - 1); y <= std::min(grid.rows - 1, row + 1); ++y)
    for (int x = std::max(0, column - 1); x <= std::min(grid.columns - 1, column + 1); ++x)
      if (!test(y, x))
        return false;
  return true;
}

/// Calls body(row, column) for the same places.
template <typename Grid, typename Body>
void for_neighbours(const Grid &grid, int row, int column, Body &&body) {
  all_neighbours(grid, row, column, [&](int y, int x) {
    body(y, x);
    return true;
  });
}

/// Index of the nearest part where the same length is divided into `other_parts`.
inline int nearest_part(int index, int parts, int other_parts) {
  return (2 * index + 1) * other_parts / (2 * parts);
}

inline bool fits_into(const Plane &plane, int side) {
  return std::min(plane.width(), plane.height()) >= side + kRim;
}

/// Parts of about this length, 1..kMostAlong.
inline int parts_of(float length, float part) {
  return std::clamp(static_cast<int>(std::lround(length / part)), 1, kMostAlong);
}

struct PatchGrid {
  int columns = 0;
  int rows = 0;
  std::vector<Template> patches; ///< as many as the largest cover() wanted

  std::size_t count() const { return cell(rows, columns, 0); }
  std::span<Template> view() { return {patches.data(), count()}; }

  /// Spreads patches evenly over the area of the plane, at most kMostAlong in each direction.
  /// `dither`: off the raster of the pixels. Keeps its memory unless it has to grow.
  void cover(const Plane &plane, const Area &area, int wanted_columns, int wanted_rows, int side,
             bool dither);
};

} // namespace haptic
