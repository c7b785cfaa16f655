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
  ExplainedTranslation find(const LayerFrame &earlier, const LayerFrame &later, float noise,
                            const LayerSize &size);

  /// How much of the texture one translation explains.
  ExplainedTranslation judge(const LayerFrame &earlier, const LayerFrame &later, float noise,
                             const LayerSize &size, Displacement by) {
    found_ = refine(earlier, later, noise, size, by, 0);
    return found_;
  }

private:
  ExplainedTranslation refine(const LayerFrame &earlier, const LayerFrame &later, float noise,
                              const LayerSize &size, Displacement start, int steps);
  Displacement search(const LayerFrame &earlier, const LayerFrame &later, const LayerSize &size);

  ExplainedTranslation found_;
  CellMap energy_;
};

} // namespace haptic
