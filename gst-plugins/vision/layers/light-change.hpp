// SPDX-License-Identifier: LGPL-2.1-or-later
// The light that falls on a scene, which is no motion.
#pragma once

#include "layers/layer-maps.hpp"

namespace haptic {

/// Makes each frame of a crop as bright as the one before it if most of it became brighter or
/// darker by one factor. One instance serves one place of one stream.
class LightChange {
public:
  void forget() { factor_ = 1; }

  /// Changes luma and mean of a frame. `earlier_mean`: of the frame before, after the same.
  /// `is_looked_for`: false in a pan, which changes every cell, too.
  void take_out(const CellMap &earlier_mean, bool is_looked_for, const LayerSize &size,
                LayerFrame &frame);

private:
  float factor_ = 1; // by which the pixels are multiplied
};

} // namespace haptic
