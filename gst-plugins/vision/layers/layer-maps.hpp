// SPDX-License-Identifier: LGPL-2.1-or-later
// Values for each pixel, or each cell of 4x4 pixels, of a small crop. The size is fixed, so that
// nothing is allocated from frame to frame.
#pragma once

#include "pixels/luma-view.hpp"
#include "pixels/tensor.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace haptic {

inline constexpr int kCellSide = 4;    // px
inline constexpr int kLayerMargin = 8; // px that the layers want around the region
inline constexpr int kLargestLayerRegion = 64;
inline constexpr int kLayerSide = kLargestLayerRegion + 2 * kLayerMargin;
static_assert(kLayerSide % kCellSide == 0);

/// Of a crop, px. Multiples of kCellSide, at most kLayerSide.
struct LayerSize {
  int width = 0;
  int height = 0;

  int columns() const { return width / kCellSide; }
  int rows() const { return height / kCellSide; }
  bool operator==(const LayerSize &) const = default;
};

/// The smallest size that holds a crop, whose sides are at most kLayerSide.
inline LayerSize layer_size_of(int width, int height) {
  const auto up = [](int side) { return (side + kCellSide - 1) / kCellSide * kCellSide; };
  return {up(width), up(height)};
}

/// Of the widest vector that the kernels use.
inline constexpr int kVectorFloats = 16;

/// Rows of whole vectors, with room for kBeside values before and behind each.
template <int kSide, int kBeside>
struct alignas(64) LayerMap {
  static constexpr int kMargin = kBeside;
  static constexpr int kStride =
      (kSide + 2 * kBeside + kVectorFloats - 1) / kVectorFloats * kVectorFloats;
  std::array<float, static_cast<std::size_t>(kSide) * kStride> values; ///< not initialised

  float *row(int y) { return values.data() + static_cast<std::ptrdiff_t>(y) * kStride + kMargin; }
  const float *row(int y) const {
    return values.data() + static_cast<std::ptrdiff_t>(y) * kStride + kMargin;
  }
  float &at(int x, int y) { return row(y)[x]; }
  float at(int x, int y) const { return row(y)[x]; }
};

using PixelMap = LayerMap<kLayerSide, kVectorFloats>;
using HalfMap = LayerMap<kLayerSide / 2, kVectorFloats>; ///< of blocks of 2x2 pixels
using CellMap = LayerMap<kLayerSide / kCellSide, 0>;

template <typename Map>
struct VectorMap {
  Map x;
  Map y;
};

template <typename Map>
struct TensorMap {
  Map xx;
  Map xy;
  Map yy;
};

/// Calls body(column, row) for each cell.
template <typename Body>
void for_cells(const LayerSize &size, Body &&body) {
  for (int row = 0; row < size.rows(); ++row)
    for (int column = 0; column < size.columns(); ++column)
      body(column, row);
}

/// Whether all of a cell was inside an area of the crop, px, before it moved by so many px.
inline bool comes_from_inside(int column, int row, Displacement by, const Rectangle &area) {
  const auto fits = [](int cell, float moved, int corner, int side) {
    const float begin = static_cast<float>(cell * kCellSide - corner) - moved;
    return begin >= 0 && begin + kCellSide <= static_cast<float>(side);
  };
  return fits(column, by.x, area.x, area.width) && fits(row, by.y, area.y, area.height);
}

inline bool comes_from_inside(int column, int row, Displacement by, const LayerSize &size) {
  return comes_from_inside(column, row, by, Rectangle{0, 0, size.width, size.height});
}

/// The way of a crop over the frame. What is known belongs to places of the frame.
struct CropMove {
  int right = 0; ///< cells
  int down = 0;
  LayerSize before;
  LayerSize after;
};

/// Copies what both crops show. `kEach`: values of a map in a row or column of a cell.
template <int kEach, typename Map>
void copy_shared(const Map &before, const CropMove &move, Map &after) {
  const int right = kEach * move.right;
  const int down = kEach * move.down;
  const int begin = std::max(0, -right);
  const int end = std::min(kEach * move.after.columns(), kEach * move.before.columns() - right);
  const int last = std::min(kEach * move.after.rows(), kEach * move.before.rows() - down);
  for (int y = std::max(0, -down); y < last && begin < end; ++y)
    std::copy_n(before.row(y + down) + begin + right, end - begin, after.row(y) + begin);
}

/// `fresh`: of cells that the crop did not show before.
inline void carry(const CropMove &move, float fresh, CellMap &map) {
  const CellMap before = map;
  map.values.fill(fresh);
  copy_shared<1>(before, move, map);
}

/// One frame of the crop, as the layers need it.
struct LayerFrame {
  PixelMap luma;
  PixelMap smooth;                   ///< luma after a small blur
  PixelMap detail;                   ///< smooth without the slow changes of light
  VectorMap<PixelMap> slope;         ///< gradient of detail, grey levels/px
  TensorMap<HalfMap> structure;      ///< g g' of the slopes within a window
  TensorMap<CellMap> cell_structure; ///< means over the cells of g g'
  CellMap steepness;                 ///< mean squared gradient of smooth
  CellMap mean;                      ///< of luma
  CellMap flat;                      ///< 1 where there is neither edge nor texture, else 0
  float energy;                      ///< mean square of detail
};

} // namespace haptic
