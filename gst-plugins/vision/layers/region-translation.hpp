// SPDX-License-Identifier: LGPL-2.1-or-later
// The translation of the crop, and how much of its texture it explains.
#pragma once

#include "layers/layer-maps.hpp"

namespace haptic {

struct ExplainedTranslation {
  Displacement displacement; ///< px
  float share = 0;           ///< of the texture, 0..1
};

/// One instance serves one place of one stream.
class RegionTranslation {
public:
  void forget() { found_ = {}; }

  /// Starts from the translation before and from rest; searches further if both explain little.
  /// `structure`: the means over the cells of g g' of the later frame.
  ExplainedTranslation find(const LayerFrame &earlier, const LayerFrame &later,
                            const TensorMap<CellMap> &structure, float noise,
                            const LayerSize &size);

private:
  ExplainedTranslation refine(const LayerFrame &earlier, const LayerFrame &later,
                              const TensorMap<CellMap> &structure, float noise,
                              const LayerSize &size, Displacement start, int steps);
  float explained(const TensorMap<CellMap> &structure, float noise, const LayerSize &size,
                  Displacement by) const;
  Displacement search(const LayerFrame &earlier, const LayerFrame &later, const LayerSize &size);

  ExplainedTranslation found_;
  CellMap energy_;
  VectorMap<CellMap> moment_;
};

} // namespace haptic
