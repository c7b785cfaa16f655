// SPDX-License-Identifier: LGPL-2.1-or-later
// Divides each pixel between the background and what moves before it, by luma: a window of pixels
// would carry the motion of a leaf into the sky.
#pragma once

#include "layers/layer-maps.hpp"

namespace haptic {

class Segmentation {
public:
  /// Spreads the luma of the background's cells over the crop.
  void find_luma(const LayerFrame &frame, const CellMap &background, const LayerSize &size);

  /// Finds the shares. Call find_luma() before. `noise`: variance of a pixel. `most`: the share of
  /// a pixel that is as bright as the background.
  void divide(const LayerFrame &frame, float noise, float most, const LayerSize &size);

  /// Of the background, grey levels.
  const CellMap &luma() const { return luma_; }

  /// Of the background in each pixel, 0..most; 0 far from any of it.
  const PixelMap &share() const { return share_; }

private:
  CellMap luma_;
  CellMap weights_;
  PixelMap share_;
};

} // namespace haptic
