// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/background-motion.hpp"

#include "layers/layer-kernels.hpp"

#include <algorithm>
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

template <typename Map>
Displacement vector_at(const VectorMap<Map> &map, int x, int y) {
  return {map.x.at(x, y), map.y.at(x, y)};
}

template <typename Map>
Tensor tensor_at(const TensorMap<Map> &map, int x, int y) {
  return {map.xx.at(x, y), map.xy.at(x, y), map.yy.at(x, y)};
}

template <typename Map>
void put(VectorMap<Map> &map, int x, int y, Displacement value) {
  map.x.at(x, y) = value.x;
  map.y.at(x, y) = value.y;
}

template <typename Map>
void put(TensorMap<Map> &map, int x, int y, const Tensor &value) {
  map.xx.at(x, y) = value.xx;
  map.xy.at(x, y) = value.xy;
  map.yy.at(x, y) = value.yy;
}

} // namespace

void BackgroundMotion::forget() {
  for (CellMap *map : {&memory_.xx, &memory_.xy, &memory_.yy, &moment_.x, &moment_.y,
                       &structure_.xx, &structure_.xy, &structure_.yy, &motion_.x, &motion_.y})
    map->values.fill(0);
}

// Adds the pair to the memory. Returns the drift of all of the background. Nothing is left out of
// the sums as an outlier: the jumps of the coder are the drift.
Displacement BackgroundMotion::remember(const LayerFrame &earlier, const LayerFrame &later,
                                        const CellMap &background, const CellMap &follows,
                                        const LayerSize &size, const BackgroundStep &step) {
  const float kept = std::exp(-step.seconds / kDriftMemory);
  const auto is_flat = [&](int x, int y) {
    return earlier.flat.at(x, y) > 0 && later.flat.at(x, y) > 0;
  };
  const auto slope = [&](int x, int y, int next_x, int next_y, int cells) {
    if (!is_flat(x, y) || !is_flat(next_x, next_y))
      return 0.0F;
    const float rise = earlier.mean.at(next_x, next_y) - earlier.mean.at(x, y) +
                       later.mean.at(next_x, next_y) - later.mean.at(x, y);
    return rise / static_cast<float>(2 * std::max(cells, 1) * kCellSide);
  };
  Tensor all_structure;
  Displacement all_moment;
  for_cells(size, [&](int x, int y) {
    Tensor structure = tensor_at(memory_, x, y);
    Displacement moment = vector_at(moment_, x, y);
    if (is_flat(x, y)) {
      const int left = std::max(x - 1, 0);
      const int right = std::min(x + 1, size.columns() - 1);
      const int up = std::max(y - 1, 0);
      const int down = std::min(y + 1, size.rows() - 1);
      const Displacement g{slope(left, y, right, y, right - left),
                           slope(x, up, x, down, down - up)};
      const float change = earlier.mean.at(x, y) - later.mean.at(x, y);
      const float trace = instant_.xx.at(x, y) + instant_.yy.at(x, y);
      const float old = kept * std::clamp(1 - trace / kEnough, 0.0F, 1.0F);
      const float stays = 1 - kFollowing * follows.at(x, y) * step.prior_counts;
      structure = stays * (old * structure);
      structure += stays * Tensor{g.x * g.x, g.x * g.y, g.y * g.y};
      moment = stays * (old * moment + change * g);
    } else {
      structure = kForgotten * structure;
      moment = kForgotten * moment;
    }
    put(memory_, x, y, structure);
    put(moment_, x, y, moment);
    all_structure += background.at(x, y) * structure;
    all_moment += background.at(x, y) * moment;
  });
  const Displacement drift = solve(all_structure, all_moment, kDriftRidge);
  return norm2(drift) > kFastest * kFastest ? Displacement{} : drift;
}

void BackgroundMotion::update(const LayerFrame &earlier, const LayerFrame &later,
                              const CellMap &luma, const CellMap &background,
                              const CellMap &follows, const LayerSize &size,
                              const BackgroundStep &step) {
  static const auto kNear = gaussian<3>(1.25F);
  static const auto kWide = gaussian<5>(2);
  const BackgroundLimits limits{15 + step.noise, 5 + 1.5F * std::sqrt(step.noise)};
  sum_background(earlier, later, luma, step.prior_counts * step.prior, limits, size, instant_,
                 instant_moment_);
  for (CellMap *map :
       {&instant_.xx, &instant_.xy, &instant_.yy, &instant_moment_.x, &instant_moment_.y})
    blur(kNear, size, *map);
  const Displacement drift = remember(earlier, later, background, follows, size, step);
  structure_ = memory_;
  near_moment_ = moment_;
  for (CellMap *map :
       {&structure_.xx, &structure_.xy, &structure_.yy, &near_moment_.x, &near_moment_.y})
    blur(kWide, size, *map);
  for_cells(size, [&](int x, int y) {
    Tensor structure = tensor_at(structure_, x, y);
    structure += tensor_at(instant_, x, y);
    const Displacement moment =
        vector_at(near_moment_, x, y) + vector_at(instant_moment_, x, y) + kDriftRidge * drift;
    const Displacement own = solve(structure, moment, kDriftRidge);
    const float with_frame = follows.at(x, y) * step.prior_counts;
    put(motion_, x, y, own + with_frame * (step.prior - own));
    put(structure_, x, y, structure);
  });
}

} // namespace haptic
