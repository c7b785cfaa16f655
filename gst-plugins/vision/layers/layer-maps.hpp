// SPDX-License-Identifier: LGPL-2.1-or-later
// Values for each pixel, or each cell of 4x4 pixels, of a small crop. The size is fixed, so that
// nothing is allocated from frame to frame.
#pragma once

#include "pixels/luma-view.hpp"
#include "pixels/tensor.hpp"

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

/// Whether all of a cell was inside the crop before it moved by so many px.
inline bool comes_from_inside(int column, int row, Displacement by, const LayerSize &size) {
  const auto fits = [](int cell, float moved, int side) {
    const float begin = static_cast<float>(cell * kCellSide) - moved;
    return begin >= 0 && begin + kCellSide <= static_cast<float>(side);
  };
  return fits(column, by.x, size.width) && fits(row, by.y, size.height);
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
