// SPDX-License-Identifier: LGPL-2.1-or-later
// The loops over the pixels of the layers. Plain loops that the compiler vectorises, for every
// instruction set (Google Highway, dispatched at run time).
#pragma once

#include "layers/layer-maps.hpp"

#include <array>
#include <cmath>
#include <span>

namespace haptic {

/// Weights of a symmetric kernel, from its middle outwards. Their sum over both sides is 1.
template <std::size_t kRadius>
using HalfKernel = std::array<float, kRadius + 1>;

template <std::size_t kRadius>
HalfKernel<kRadius> gaussian(float sigma) {
  HalfKernel<kRadius> kernel;
  float sum = 0;
  for (std::size_t i = 0; i <= kRadius; ++i) {
    const float distance = static_cast<float>(i) / sigma;
    kernel[i] = std::exp(-distance * distance / 2);
    sum += i == 0 ? kernel[i] : 2 * kernel[i];
  }
  for (float &weight : kernel)
    weight /= sum;
  return kernel;
}

inline constexpr HalfKernel<1> kBinomial = {0.5F, 0.25F};

/// Luma as floats. The last column and row are repeated up to the size.
void load_luma(const LumaView &view, const LayerSize &size, PixelMap &luma);

/// Convolves with a kernel of radius 1, 3, 4 or 5 in both directions; borders are repeated.
void blur(std::span<const float> half_kernel, const LayerSize &size, PixelMap &map);
void blur(std::span<const float> half_kernel, const LayerSize &size, CellMap &map);

/// The mean of each cell.
void pool(const PixelMap &map, const LayerSize &size, CellMap &cells);

/// Bilinear interpolation between the middles of the cells.
void widen(const CellMap &cells, const LayerSize &size, PixelMap &map);

/// detail = smooth - slow with its energy, and its gradient, (1 -8 0 8 -1)/12.
void find_slope(const PixelMap &slow, const LayerSize &size, LayerFrame &frame);

/// The squared gradient of `smooth` by central differences; and the cells whose largest, after a
/// binomial blur, is below `limit`.
void find_flat_cells(float limit, const LayerSize &size, LayerFrame &frame);

/// The mean squared difference of each cell.
void compare(const PixelMap &one, const PixelMap &other, const LayerSize &size, CellMap &energy);

/// The same between `later` and the earlier map displaced by `by`; borders are repeated.
void compare_displaced(const PixelMap &earlier, const PixelMap &later, Displacement by,
                       const LayerSize &size, CellMap &energy);

/// The same of `detail`, with the means of slope * (earlier displaced - later).
void compare_details(const LayerFrame &earlier, const LayerFrame &later, Displacement by,
                     const LayerSize &size, CellMap &energy, VectorMap<CellMap> &moment);

/// Limits for pixels of the background.
struct BackgroundLimits {
  float steepness = 0; ///< squared gradient
  float change = 0;    ///< grey levels, from frame to frame and from the background's luma
};

/// The means over the cells of g g' and g (earlier - later), with the gradient g of `smooth`. A
/// pixel beyond a limit counts as zero; it may also have changed as a motion by `by` makes it.
void sum_background(const LayerFrame &earlier, const LayerFrame &later,
                    const PixelMap &background_luma, Displacement by,
                    const BackgroundLimits &limits, const LayerSize &size,
                    TensorMap<CellMap> &structure, VectorMap<CellMap> &moment);

/// The share of the background in each pixel, 0..1: 1 where its luma is near that of the
/// background, in units of the largest difference around it, and at least `least` grey levels; 0
/// where `known` is below `least_known`.
void share_background(const PixelMap &luma, const PixelMap &background_luma, const PixelMap &known,
                      float least_known, float least, const LayerSize &size, PixelMap &share);

/// g g' of each pixel.
void multiply_slope(const LayerFrame &frame, const LayerSize &size, TensorMap<PixelMap> &structure);

/// flow <- prior + (flow + more - prior) * t / (t + damping), with the trace t of the structure.
void damp(const TensorMap<PixelMap> &structure, Displacement prior, Displacement more,
          float damping, const LayerSize &size, VectorMap<PixelMap> &flow);

/// term = earlier detail displaced by flow - later detail + slope * flow, and slope * term.
/// `energy`: mean squared difference of each cell before the step.
void linearise(const LayerFrame &earlier, const LayerFrame &later, const VectorMap<PixelMap> &flow,
               const LayerSize &size, PixelMap &term, VectorMap<PixelMap> &moment, CellMap &energy);

/// flow = (structure + ridge)^-1 (moment + ridge * prior). Returns the mean of |change of the flow|
/// where there is texture, px.
float solve_flow(const TensorMap<PixelMap> &structure, const VectorMap<PixelMap> &moment,
                 Displacement prior, float ridge, const LayerSize &size, VectorMap<PixelMap> &flow);

/// Mean squared term - slope * flow of each cell.
void leftover(const PixelMap &term, const LayerFrame &later, const VectorMap<PixelMap> &flow,
              const LayerSize &size, CellMap &energy);

/// Index of a tile where tiles lie row after row.
inline std::size_t tile_at(int row, int columns, int column) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
         static_cast<std::size_t>(column);
}

/// Sums over a tile, each pixel weighted by its part in the tile.
struct TileSums {
  float pixels = 0;
  Displacement motion; ///< sum of (1 - share) flow + share * background
  Tensor structure;    ///< sum of (1 - share) g g'
  float share = 0;     ///< sum of the background's shares
  float leftover = 0;  ///< sum of the squared residuals
};

/// What the tiles add up.
struct LayerSum {
  const LayerFrame &frame;
  const VectorMap<PixelMap> &flow;
  const VectorMap<PixelMap> &background;
  const PixelMap &share;
  const PixelMap &term; ///< of linearise
};

/// Tiles of equal size, columns x rows, that cover the region; row by row.
void sum_tiles(const LayerSum &layers, const Rectangle &region, int columns, int rows,
               std::span<TileSums> tiles);

} // namespace haptic
