// SPDX-License-Identifier: LGPL-2.1-or-later
// Flat areas that are no background but things without texture: their borders move, and what lies
// beyond is at rest. Beyond the border of a sky, a leaf moves with it.
#pragma once

#include "layers/layer-maps.hpp"

#include <array>
#include <cstddef>

namespace haptic {

/// One instance serves one place of one stream.
class FlatThings {
public:
  FlatThings() { forget(); }
  void forget();
  void carry(const CropMove &move); ///< The crop went on.

  /// Finds the flat areas of the frame, and which of them are things. `rests` is that of CalmCells.
  void find(const LayerFrame &frame, const CellMap &rests, const LayerSize &size, float seconds);

  /// 1: a cell of a thing, else 0.
  const CellMap &cells() const { return things_; }

  /// Gives the cells of things, and those beside them, the displacement that fits their borders
  /// best. `flow` of the pixels and `structure` of the cells of what moves.
  void move(const VectorMap<HalfMap> &flow, const TensorMap<CellMap> &structure,
            const LayerSize &size, VectorMap<CellMap> &motion);

private:
  static constexpr std::size_t kCells =
      static_cast<std::size_t>(kLayerSide / kCellSide) * CellMap::kStride;
  static constexpr int kNone = -1;

  /// Neighbouring flat cells of about one luma.
  struct Area {
    int open = 0;   // sides of cells at the border of the crop
    int closed = 0; // sides of cells at what is not flat
    int moving = 0; // of the closed ones, those whose look speaks for a thing
    float votes = 0;
    float weight = 0;
    Tensor structure; // of the border
    Displacement moment;
    bool is_thing = false;
  };

  int area_of(int x, int y) const { return area_of_[tile_of(x, y)]; }
  Area &area(int i) { return areas_[static_cast<std::size_t>(i)]; }
  static std::size_t tile_of(int x, int y) {
    return static_cast<std::size_t>(y) * CellMap::kStride + static_cast<std::size_t>(x);
  }
  void fill(const LayerFrame &frame, const LayerSize &size, int x, int y, int number);
  float look(const CellMap &rests, const LayerSize &size, int x, int y, int right, int down) const;

  std::array<int, kCells> area_of_; // kNone: not flat
  std::array<Area, kCells> areas_;
  int count_ = 0; // of areas
  CellMap votes_; // of the borders beside each cell: for a thing, or against it
  CellMap weights_;
  CellMap things_;
};

} // namespace haptic
