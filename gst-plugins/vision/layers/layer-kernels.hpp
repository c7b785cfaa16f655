// SPDX-License-Identifier: LGPL-2.1-or-later
// The loops over the pixels of the layers, for every instruction set (Google Highway, dispatched at
// run time). Filters that follow one another share a pass over the rows, so that what they hand on
// stays in the nearest cache.
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

/// Of the window in which the pixels share a displacement, in blocks of 2x2 pixels.
inline constexpr int kWindowRadius = 2;

/// Fills in the luma and its means. The last column and row are repeated up to the size.
void load_luma(const LumaView &view, const LayerSize &size, LayerFrame &frame);

struct DescriptionKernels {
  HalfKernel<1> smooth;
  HalfKernel<kWindowRadius> window; ///< for the structure
};

/// Fills in the rest after load_luma(). `slow`: the changes of light. Cells are flat whose largest
/// steepness, after a binomial blur, is below `flat_limit`.
void describe(const CellMap &slow, const DescriptionKernels &kernels, float flat_limit,
              const LayerSize &size, LayerFrame &frame);

/// Convolves with a kernel of radius 1, 3, 4 or 5 in both directions; borders are repeated.
void blur(std::span<const float> half_kernel, const LayerSize &size, const CellMap &from,
          CellMap &to);

/// The mean squared difference of each cell.
void compare(const PixelMap &one, const PixelMap &other, const LayerSize &size, CellMap &energy);

/// The same between `later` and the earlier map displaced by `by`. Means nothing for cells that do
/// not come from inside.
void compare_displaced(const PixelMap &earlier, const PixelMap &later, Displacement by,
                       const LayerSize &size, CellMap &energy);

/// What a translation leaves of the cells that come from inside the crop.
struct TranslationFit {
  Tensor structure;    ///< weighted by how well the translation fits the cell
  Displacement moment; ///< of the differences, weighted so
  float explained = 0; ///< sum over the cells that it explains, weighted by their texture
  float all = 0;       ///< the same over all of them
};

/// The same as compare_displaced() of `detail`, with its fit. `noise`: variance of a pixel.
TranslationFit fit_translation(const LayerFrame &earlier, const LayerFrame &later, Displacement by,
                               float noise, const LayerSize &size, CellMap &energy);

/// The displacement by whole cells, at most `reach`, after which the cells differ least.
Displacement search_cells(const CellMap &before, const CellMap &after, int reach,
                          const LayerSize &size);

/// Limits for pixels of the background.
struct BackgroundLimits {
  float steepness = 0; ///< squared gradient
  float change = 0;    ///< grey levels, from frame to frame and from the background's luma
};

/// Normal equations of each cell.
struct BackgroundCells {
  TensorMap<CellMap> structure;
  VectorMap<CellMap> moment;
};

/// The means over the cells of g g' and g (earlier - later), with the gradient g of `smooth`. A
/// pixel beyond a limit counts as zero; it may also have changed as a motion by `by` makes it.
void sum_background(const LayerFrame &earlier, const LayerFrame &later, const CellMap &luma,
                    Displacement by, const BackgroundLimits &limits, const LayerSize &size,
                    BackgroundCells &means);

/// How a frame changes the memory of cells.
struct MemoryStep {
  float kept = 0;      ///< of cells that are flat in both frames
  float enough = 0;    ///< trace of the instant structure at which nothing is kept
  float following = 0; ///< what goes, too, where all of the cell follows the frame
  float forgotten = 0; ///< kept of other cells
};

/// Adds g g' and g (earlier - later) to the memory, with the gradient g between the means of cells
/// that are flat in both frames. `structure`, `moment`: the sums over the background.
void remember(const LayerFrame &earlier, const LayerFrame &later, const BackgroundCells &instant,
              const CellMap &background, const CellMap &follows, const MemoryStep &step,
              const LayerSize &size, BackgroundCells &memory, Tensor &structure,
              Displacement &moment);

/// What is known of the motion of the background without a cell's own pixels.
struct BackgroundPrior {
  float ridge = 0;        ///< how much `drift` counts, (grey levels/px)^2
  Displacement drift;     ///< of all of the background, px
  Displacement frame;     ///< px
  float frame_counts = 0; ///< 0..1, where all of a cell follows the frame
};

/// Adds `instant` to the sums and solves them for the motion of each cell.
void solve_background(const BackgroundCells &instant, const CellMap &follows,
                      const BackgroundPrior &prior, const LayerSize &size, BackgroundCells &sums,
                      VectorMap<CellMap> &motion);

/// The share of the background in each pixel, 0..1: 1 where its luma is near that of the
/// background, in units of the largest difference around it, and at least `least` grey levels; 0
/// where `known` is below `least_known`.
void share_background(const PixelMap &luma, const CellMap &background_luma, const CellMap &known,
                      float least_known, float least, const LayerSize &size, PixelMap &share);

/// flow <- prior + (structure + r)^-1 structure (flow + more - prior), with r = damping / 2: in
/// each direction as much is kept as it shows. Along an edge, nothing is.
void damp(const TensorMap<HalfMap> &structure, Displacement prior, Displacement more, float damping,
          const LayerSize &size, VectorMap<HalfMap> &flow);

/// Mean squared difference of each cell between the earlier detail displaced by the flow and the
/// later one.
void compare_flow(const LayerFrame &earlier, const LayerFrame &later,
                  const VectorMap<HalfMap> &flow, const LayerSize &size, CellMap &energy);

/// One step of least squares within a window, from the flow as it is:
/// flow <- (structure + ridge)^-1 (mean of slope * term + ridge * prior)
/// with term = earlier detail displaced by flow - later detail + slope * flow.
/// `energy`: mean squared differences of the cells before it. Returns the mean of |change of the
/// flow| where there is texture, px.
float step_flow(const LayerFrame &earlier, const LayerFrame &later, std::span<const float> window,
                Displacement prior, float ridge, const LayerSize &size, VectorMap<HalfMap> &flow,
                PixelMap &term, CellMap &energy);

/// Mean squared term - slope * flow of each cell.
void leftover(const LayerFrame &later, const VectorMap<HalfMap> &flow, const PixelMap &term,
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
  const VectorMap<HalfMap> &flow;
  const VectorMap<CellMap> &background;
  const PixelMap &share;
  const PixelMap &term; ///< of step_flow()
};

/// Tiles of equal size, columns x rows, that cover the region; row by row.
void sum_tiles(const LayerSum &layers, const LayerSize &size, const Rectangle &region, int columns,
               int rows, std::span<TileSums> tiles);

} // namespace haptic
