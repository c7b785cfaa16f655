// SPDX-License-Identifier: LGPL-2.1-or-later
// The velocity of the background. A coder lets clouds stand and moves them in jumps: the sum over a
// second shows how fast they drift.
#pragma once

#include "layers/layer-kernels.hpp"
#include "layers/layer-maps.hpp"

namespace haptic {

/// What one pair of frames brings.
struct BackgroundStep {
  float seconds = 0;
  float noise = 0;        ///< variance of a pixel, grey levels squared
  Displacement prior;     ///< of the frame, px
  float prior_counts = 0; ///< 0..1
};

/// One instance serves one place of one stream.
class BackgroundMotion {
public:
  BackgroundMotion() { forget(); }
  void forget();
  void carry(const CropMove &move); ///< The crop went on.

  /// `luma`: of the background. `background` and `follows` are those of CalmCells.
  void update(const LayerFrame &earlier, const LayerFrame &later, const CellMap &luma,
              const CellMap &background, const CellMap &follows, const LayerSize &size,
              const BackgroundStep &step);

  /// Displacement of each cell, px.
  const VectorMap<CellMap> &motion() const { return motion_; }

  /// The normal equations behind it, per pixel, summed over the memory.
  const TensorMap<CellMap> &structure() const { return sums_.structure; }

private:
  BackgroundCells memory_;  // of cells without texture
  BackgroundCells means_;   // of all pixels that can be background
  BackgroundCells instant_; // the same, within a window
  BackgroundCells sums_;
  VectorMap<CellMap> motion_;
};

} // namespace haptic
