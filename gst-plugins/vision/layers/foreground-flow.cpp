// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/foreground-flow.hpp"

#include "layers/layer-frame.hpp"
#include "layers/layer-kernels.hpp"

#include <algorithm>

namespace haptic {
namespace {

// (grey levels/px)^2. With a third of it, the flow along an edge, which shows nothing, feeds
// itself.
constexpr float kRidge = 0.3F;
// Trace of the structure that keeps half of the start, if it is the same in all directions. Without
// this damping, a wrong flow where there is little texture, or along an edge, feeds itself.
constexpr float kDamping = 30;

} // namespace

void ForegroundFlow::carry(const CropMove &move) {
  for (HalfMap *map : {&flow_.x, &flow_.y}) {
    const HalfMap before = *map;
    for (int y = 0; y < 2 * move.after.rows(); ++y) {
      const float *row = before.row(std::clamp(y + 2 * move.down, 0, 2 * move.before.rows() - 1));
      for (int x = 0; x < 2 * move.after.columns(); ++x)
        map->at(x, y) = row[std::clamp(x + 2 * move.right, 0, 2 * move.before.columns() - 1)];
    }
  }
}

// A thing that comes into the crop, or turns back at once, moves as the region does and not as
// these pixels did.
void ForegroundFlow::start_from_region(const LayerFrame &earlier, const LayerFrame &later,
                                       const ExplainedTranslation &region, float noise,
                                       const LayerSize &size) {
  constexpr float kExplains = 0.3F; // of the texture
  constexpr float kMoves2 = 0.2F * 0.2F;
  constexpr float kBetter = 0.7F;
  constexpr float kResidual = 2;
  if (region.share <= kExplains || norm2(region.displacement) <= kMoves2)
    return;
  compare_flow(earlier, later, flow_, size, before_);
  fit_translation(earlier, later, region.displacement, noise, size, region_energy_);
  for_cells(size, [&](int x, int y) {
    const float own = before_.at(x, y);
    if (own <= kResidual + 1.2F * noise || region_energy_.at(x, y) >= kBetter * own ||
        !comes_from_inside(x, y, region.displacement, size))
      return;
    for (int i = 0; i < 4; ++i) {
      flow_.x.at(2 * x + i % 2, 2 * y + i / 2) = region.displacement.x;
      flow_.y.at(2 * x + i % 2, 2 * y + i / 2) = region.displacement.y;
    }
  });
}

void ForegroundFlow::step(const LayerFrame &earlier, const LayerFrame &later,
                          const FlowPrior &prior, float noise, const LayerSize &size) {
  constexpr float kFar = 0.5F; // px, mean where there is texture
  constexpr float kArrived = 0.02F;
  constexpr int kMostWarm = 2;
  constexpr int kMostCold = 4;
  constexpr float kIsOne = 0.5F; // of the texture, for a region that starts as one
  const int most = is_cold_ ? kMostCold : kMostWarm;
  const float near = is_cold_ ? kArrived : kFar;
  // Of pixels that show little.
  const Displacement usual =
      is_cold_ && prior.region.share > kIsOne ? prior.region.displacement : prior.frame;
  if (is_cold_) {
    flow_.x.values.fill(usual.x);
    flow_.y.values.fill(usual.y);
    is_cold_ = false;
  } else {
    damp(later.structure, prior.frame, prior.change, kDamping, size, flow_);
  }
  start_from_region(earlier, later, prior.region, noise, size);
  CellMap *before = &before_;
  for (int i = 0; i < most; ++i) {
    const float moved =
        step_flow(earlier, later, foreground_window(), usual, kRidge, size, flow_, term_, *before);
    if (moved < near)
      break;
    before = &after_;
  }
  leftover(later, flow_, term_, size, after_);
}

} // namespace haptic
