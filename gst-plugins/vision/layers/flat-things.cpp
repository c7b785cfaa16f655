// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/flat-things.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr std::array kSides = {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1},
                               std::pair{0, -1}};

bool is_inside(int x, int y, const LayerSize &size) {
  return x >= 0 && y >= 0 && x < size.columns() && y < size.rows();
}

float mean_of(const HalfMap &map, int x, int y) {
  return 0.25F * (map.at(2 * x, 2 * y) + map.at(2 * x + 1, 2 * y) + map.at(2 * x, 2 * y + 1) +
                  map.at(2 * x + 1, 2 * y + 1));
}

} // namespace

void FlatThings::forget() {
  for (CellMap *map : {&votes_, &weights_, &things_})
    map->values.fill(0);
}

void FlatThings::carry(const CropMove &move) {
  haptic::carry(move, 0, votes_);
  haptic::carry(move, 0, weights_);
}

// Numbers the cells of an area.
void FlatThings::fill(const LayerFrame &frame, const LayerSize &size, int x, int y, int number) {
  constexpr float kAlike = 12; // grey levels, between neighbours
  struct Cell {
    int x, y;
  };
  std::array<Cell, kCells> found;
  std::size_t count = 0;
  const auto add = [&](Cell cell) {
    area_of_[tile_of(cell.x, cell.y)] = number;
    found[count++] = cell;
  };
  area(number) = {};
  add({x, y});
  for (std::size_t i = 0; i < count; ++i)
    for (const auto &[right, down] : kSides) {
      const int next_x = found[i].x + right;
      const int next_y = found[i].y + down;
      if (!is_inside(next_x, next_y, size)) {
        ++area(number).open;
        continue;
      }
      const float step = frame.mean.at(next_x, next_y) - frame.mean.at(found[i].x, found[i].y);
      if (!(frame.flat.at(next_x, next_y) > 0))
        ++area(number).closed;
      else if (area_of(next_x, next_y) == kNone && std::abs(step) <= kAlike)
        add({next_x, next_y});
    }
}

// Looks from a cell across the border of its area. 1: something moves before a rest, so that the
// area does; -1: texture moves with the border; half as much where there is no texture beyond the
// border, and where the border is at rest.
float FlatThings::look(const CellMap &rests, const LayerSize &size, int x, int y, int right,
                       int down) const {
  constexpr int kReach = 5;  // cells
  constexpr int kBorder = 3; // cells: the width that an edge can have
  constexpr int kBeside = 2; // cells
  int moving = 0;
  for (int i = 1; i <= kReach && is_inside(x + i * right, y + i * down, size); ++i) {
    const float rest = rests.at(x + i * right, y + i * down);
    if (rest < 0 && ++moving > kBorder)
      return -1;
    if (rest > 0)
      return moving > 0 ? 1 : i <= kBeside ? -0.5F : 0;
    if (rest == 0 && area_of(x + i * right, y + i * down) != kNone)
      break;
  }
  return moving > 0 ? 0.5F : 0;
}

void FlatThings::find(const LayerFrame &frame, const CellMap &rests, const LayerSize &size,
                      float seconds) {
  constexpr float kMemory = 0.3F; // s
  constexpr int kSeen = 2;        // sides of cells
  constexpr float kFew = 1;       // votes
  constexpr float kMost = 0.2F;   // of the votes
  const float kept = std::exp(-seconds / kMemory);
  area_of_.fill(kNone);
  count_ = 0;
  for_cells(size, [&](int x, int y) {
    if (frame.flat.at(x, y) > 0 && area_of(x, y) == kNone)
      fill(frame, size, x, y, count_++);
  });
  CellMap votes;
  CellMap weights;
  for_cells(size, [&](int x, int y) {
    if (area_of(x, y) == kNone)
      return;
    float sum = 0;
    float weight = 0;
    for (const auto &[right, down] : kSides) {
      if (!is_inside(x + right, y + down, size) || area_of(x + right, y + down) != kNone)
        continue;
      const float vote = look(rests, size, x, y, right, down);
      area(area_of(x, y)).moving += vote > 0;
      sum += vote;
      weight += std::abs(vote);
    }
    votes.at(x, y) = sum;
    weights.at(x, y) = weight;
  });
  for_cells(size, [&](int x, int y) {
    if (area_of(x, y) == kNone)
      return;
    Area &of = area(area_of(x, y));
    // Nothing is learned, nor forgotten, while a thing rests at the turn of its sway.
    if (of.moving >= kSeen) {
      votes_.at(x, y) = kept * votes_.at(x, y) + votes.at(x, y);
      weights_.at(x, y) = kept * weights_.at(x, y) + weights.at(x, y);
    }
    of.votes += votes_.at(x, y);
    of.weight += weights_.at(x, y);
  });
  // What leaves the crop on most of its sides is what is behind.
  for (int i = 0; i < count_; ++i)
    area(i).is_thing =
        area(i).open < area(i).closed && area(i).votes > kMost * (area(i).weight + kFew);
  for_cells(size, [&](int x, int y) {
    things_.at(x, y) = area_of(x, y) != kNone && area(area_of(x, y)).is_thing ? 1 : 0;
  });
}

void FlatThings::move(const VectorMap<HalfMap> &flow, const TensorMap<CellMap> &structure,
                      const LayerSize &size, VectorMap<CellMap> &motion) {
  constexpr float kTexture = 20; // trace of a cell that shows its motion
  constexpr float kRidge = 1;    // (grey levels/px)^2
  if (std::none_of(areas_.begin(), areas_.begin() + count_,
                   [](const Area &one) { return one.is_thing; }))
    return;
  for_cells(size, [&](int x, int y) {
    const Tensor at{structure.xx.at(x, y), structure.xy.at(x, y), structure.yy.at(x, y)};
    if (area_of(x, y) != kNone || at.xx + at.yy <= kTexture)
      return;
    const Displacement by{mean_of(flow.x, x, y), mean_of(flow.y, x, y)};
    for (const auto &[right, down] : kSides) {
      if (!is_inside(x + right, y + down, size) || area_of(x + right, y + down) == kNone)
        continue;
      Area &beside = area(area_of(x + right, y + down));
      beside.structure += at;
      beside.moment += {at.xx * by.x + at.xy * by.y, at.xy * by.x + at.yy * by.y};
    }
  });
  for_cells(size, [&](int x, int y) {
    const int number = area_of(x, y);
    if (number == kNone || !area(number).is_thing)
      return;
    const Displacement by = solve(area(number).structure, area(number).moment, kRidge);
    for (int near_y = std::max(y - 1, 0); near_y <= std::min(y + 1, size.rows() - 1); ++near_y)
      for (int near_x = std::max(x - 1, 0); near_x <= std::min(x + 1, size.columns() - 1); ++near_x)
        if (area_of(near_x, near_y) == kNone || area_of(near_x, near_y) == number) {
          motion.x.at(near_x, near_y) = by.x;
          motion.y.at(near_x, near_y) = by.y;
        }
  });
}

} // namespace haptic
