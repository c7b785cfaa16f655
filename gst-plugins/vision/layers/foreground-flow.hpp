// SPDX-License-Identifier: LGPL-2.1-or-later
// The displacement of what moves (Lucas and Kanade), with the one of the frame before as the start.
// A window of 9 px makes it so smooth that it is solved for blocks of 2x2 pixels alone.
#pragma once

#include "layers/layer-maps.hpp"
#include "layers/region-translation.hpp"

namespace haptic {

/// What else is known of the motion.
struct FlowPrior {
  Displacement frame;  ///< of pixels that show nothing, px
  Displacement change; ///< of the region's translation since the frame before, px
  /// Cells that it explains better than their own start begin with it. `share` 0: not known.
  ExplainedTranslation region;
};

/// One instance serves one place of one stream.
class ForegroundFlow {
public:
  /// The flow that follows starts from rest.
  void forget() { is_cold_ = true; }

  /// The crop went on. What comes into it moves at first as what lies beside it.
  void carry(const CropMove &move);

  /// One damped step; more if the pixels moved far from their start, or the start is not known.
  void step(const LayerFrame &earlier, const LayerFrame &later, const FlowPrior &prior, float noise,
            const LayerSize &size);

  /// px, of blocks of 2x2 pixels.
  const VectorMap<HalfMap> &flow() const { return flow_; }

  /// earlier detail displaced by the start - later detail + slope * start, in the last step.
  const PixelMap &term() const { return term_; }

  /// Mean squared differences of the cells: at the start, and after the steps.
  const CellMap &energy_before() const { return before_; }
  const CellMap &energy_after() const { return after_; }

private:
  void start_from_region(const LayerFrame &earlier, const LayerFrame &later,
                         const ExplainedTranslation &region, float noise, const LayerSize &size);

  bool is_cold_ = true;
  VectorMap<HalfMap> flow_;
  PixelMap term_;
  CellMap before_;
  CellMap after_;
  CellMap region_energy_;
};

} // namespace haptic
