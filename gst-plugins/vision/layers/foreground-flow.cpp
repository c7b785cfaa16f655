// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/foreground-flow.hpp"

#include "layers/layer-kernels.hpp"

#include <algorithm>

namespace haptic {
namespace {

// (grey levels/px)^2. With a third of it, the flow along an edge, which shows nothing, feeds
// itself.
constexpr float kRidge = 0.3F;
// Trace of the structure that keeps half of the start. Without this damping, a wrong flow where
// there is little texture feeds itself.
constexpr float kDamping = 30;

} // namespace

void ForegroundFlow::prepare(const LayerFrame &later, const LayerSize &size) {
  static const auto kWindow = gaussian<4>(1.9F);
  multiply_slope(later, size, structure_);
  pool(structure_.xx, size, cells_.xx);
  pool(structure_.xy, size, cells_.xy);
  pool(structure_.yy, size, cells_.yy);
  for (PixelMap *map : {&structure_.xx, &structure_.xy, &structure_.yy})
    blur(kWindow, size, *map);
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
  compare_details(earlier, later, region.displacement, size, region_energy_, region_moment_);
  bool is_any = false;
  for_cells(size, [&](int x, int y) {
    const float own = before_.at(x, y);
    if (own <= kResidual + 1.2F * noise || region_energy_.at(x, y) >= kBetter * own ||
        !comes_from_inside(x, y, region.displacement, size))
      return;
    is_any = true;
    const std::ptrdiff_t left = std::ptrdiff_t{x} * kCellSide;
    for (int row = y * kCellSide; row < (y + 1) * kCellSide; ++row) {
      std::fill_n(flow_.x.row(row) + left, kCellSide, region.displacement.x);
      std::fill_n(flow_.y.row(row) + left, kCellSide, region.displacement.y);
    }
  });
  if (is_any)
    linearise(earlier, later, flow_, size, term_, moment_, before_);
}

void ForegroundFlow::step(const LayerFrame &earlier, const LayerFrame &later,
                          const FlowPrior &prior, float noise, const LayerSize &size) {
  constexpr float kFar = 0.5F; // px, mean where there is texture
  constexpr float kArrived = 0.02F;
  constexpr int kMostWarm = 2;
  constexpr int kMostCold = 4;
  constexpr float kIsOne = 0.5F; // of the texture, for a region that starts as one
  static const auto kWindow = gaussian<4>(1.9F);
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
    damp(structure_, prior.frame, prior.change, kDamping, size, flow_);
  }
  linearise(earlier, later, flow_, size, term_, moment_, before_);
  start_from_region(earlier, later, prior.region, noise, size);
  for (int i = 0;; ++i) {
    blur(kWindow, size, moment_.x);
    blur(kWindow, size, moment_.y);
    const float moved = solve_flow(structure_, moment_, usual, kRidge, size, flow_);
    if (moved < near || i + 1 >= most)
      break;
    linearise(earlier, later, flow_, size, term_, moment_, after_);
  }
  leftover(term_, later, flow_, size, after_);
}

} // namespace haptic
