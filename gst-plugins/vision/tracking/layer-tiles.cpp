// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracking/layer-tiles.hpp"

#include "tracking/noise-estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace haptic {
namespace {

constexpr float kUnseen = 1; // 1/px^2, of one tile

bool shows_little(const LayerTile &tile) {
  return tile.precision.xx + tile.precision.yy < kUnseen;
}

} // namespace

bool is_slow(Displacement motion, float noise) {
  constexpr float kSlow = 0.04F; // px, where only rounding disturbs: below 3 px/s nothing is felt
  return norm2(motion) <= std::max(1.0F, noise / kRoundingVariance) * kSlow * kSlow;
}

bool is_seen(const LayerTile &tile) {
  return !shows_little(tile) || tile.background >= 0.5F;
}

// Flat parts of the background are area that moves as the background does. Without them, the mean
// would be that of the leaf before them.
float add_tiles(const RegionLayers &layers, const Rectangle &region, int side,
                Measurement &measurement) {
  constexpr float kSeen = 4; // 1/px^2: a deviation of 0.5 px
  constexpr float kAllBackground = 0.9F;
  std::array<LayerTile, kMaxPatches> storage;
  const auto tiles = std::span(storage).first(tile_at(side, side, 0));
  layers.sum(region, side, side, tiles);
  Tensor all;
  float background = 0;
  for (const LayerTile &tile : tiles) {
    all += tile.precision;
    background += tile.background / static_cast<float>(tiles.size());
  }
  const auto [least, most] = eigenvalues(all);
  // Slopes of one direction show only a part of the drift of a sky.
  if (most < kSeen || (background > kAllBackground && least < kSeen))
    return background;
  const float wide = static_cast<float>(region.width) / static_cast<float>(side);
  const float high = static_cast<float>(region.height) / static_cast<float>(side);
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const LayerTile &tile = tiles[tile_at(row, side, column)];
      if (!is_seen(tile))
        continue;
      Tensor precision = tile.precision;
      if (shows_little(tile))
        precision += {kUnseen, 0, kUnseen};
      measurement.add({static_cast<float>(region.x) + (static_cast<float>(column) + 0.5F) * wide,
                       static_cast<float>(region.y) + (static_cast<float>(row) + 0.5F) * high, wide,
                       high, tile.displacement.x, tile.displacement.y, precision.xx, precision.xy,
                       precision.yy, std::sqrt(tile.residual2), 0});
    }
  measurement.candidates = measurement.count;
  measurement.flags = kTiled;
  return background;
}

} // namespace haptic
