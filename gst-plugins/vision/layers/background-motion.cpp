// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/background-motion.hpp"

#include "layers/layer-kernels.hpp"

#include <array>
#include <cmath>

namespace haptic {
namespace {

constexpr float kDriftMemory = 1;  // s
constexpr float kDriftRidge = 5;   // (grey levels/px)^2: what so little shows is not believed
constexpr float kFastest = 0.5F;   // px a frame; the drift of the whole crop, else it is no drift
constexpr float kForgotten = 0.5F; // of the memory, in each frame in which a cell has texture
constexpr float kFollowing = 0.2F; // of the memory, in each frame in which a cell moves with all
// Structure of the pixels at which the memory is not needed.
constexpr float kEnough = 200;

std::array<CellMap *, 5> maps_of(BackgroundCells &cells) {
  return {&cells.structure.xx, &cells.structure.xy, &cells.structure.yy, &cells.moment.x,
          &cells.moment.y};
}

void fill(BackgroundCells &cells, float value) {
  for (CellMap *map : maps_of(cells))
    map->values.fill(value);
}

void blur(std::span<const float> kernel, const LayerSize &size, const BackgroundCells &from,
          BackgroundCells &to) {
  haptic::blur(kernel, size, from.structure.xx, to.structure.xx);
  haptic::blur(kernel, size, from.structure.xy, to.structure.xy);
  haptic::blur(kernel, size, from.structure.yy, to.structure.yy);
  haptic::blur(kernel, size, from.moment.x, to.moment.x);
  haptic::blur(kernel, size, from.moment.y, to.moment.y);
}

} // namespace

void BackgroundMotion::forget() {
  fill(memory_, 0);
  fill(sums_, 0);
  motion_.x.values.fill(0);
  motion_.y.values.fill(0);
}

void BackgroundMotion::carry(const CropMove &move) {
  for (CellMap *map : maps_of(memory_))
    haptic::carry(move, 0, *map);
}

void BackgroundMotion::update(const LayerFrame &earlier, const LayerFrame &later,
                              const CellMap &luma, const CellMap &background,
                              const CellMap &follows, const LayerSize &size,
                              const BackgroundStep &step) {
  static const auto kNear = gaussian<3>(1.25F);
  static const auto kWide = gaussian<5>(2);
  const BackgroundLimits limits{15 + step.noise, 5 + 1.5F * std::sqrt(step.noise)};
  sum_background(earlier, later, luma, step.prior_counts * step.prior, limits, size, means_);
  blur(kNear, size, means_, instant_);
  // Nothing is left out of the sums as an outlier: the jumps of the coder are the drift.
  Tensor structure;
  Displacement moment;
  remember(earlier, later, instant_, background, follows,
           {.kept = std::exp(-step.seconds / kDriftMemory),
            .enough = kEnough,
            .following = kFollowing * step.prior_counts,
            .forgotten = kForgotten},
           size, memory_, structure, moment);
  const Displacement drift = solve(structure, moment, kDriftRidge);
  blur(kWide, size, memory_, sums_);
  solve_background(instant_, follows,
                   {.ridge = kDriftRidge,
                    .drift = norm2(drift) > kFastest * kFastest ? Displacement{} : drift,
                    .frame = step.prior,
                    .frame_counts = step.prior_counts},
                   size, sums_, motion_);
}

} // namespace haptic
