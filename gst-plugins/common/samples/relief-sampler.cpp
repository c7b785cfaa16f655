// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/relief-sampler.hpp"

#include <algorithm>
#include <cstddef>

namespace haptic {
namespace {

constexpr double kSurface = 0.5; // validity from which there is a surface

// The two cells between whose centres a place lies, clamped at the outer centres.
struct Between {
  std::size_t first;
  std::size_t second;
  double weight; // of the second

  Between(double place, std::size_t cells) noexcept {
    const double at =
        std::clamp(place * static_cast<double>(cells) - 0.5, 0.0, static_cast<double>(cells - 1));
    first = static_cast<std::size_t>(at);
    second = std::min(first + 1, cells - 1);
    weight = at - static_cast<double>(first);
  }
};

} // namespace

void ReliefSums::add(const ReliefCell &cell, double weight) noexcept {
  const double valid = weight * static_cast<double>(cell.validity);
  validity_ += valid;
  height_ += valid * static_cast<double>(cell.height);
  stiffness_ += valid * static_cast<double>(cell.stiffness);
  friction_ += valid * static_cast<double>(cell.friction);
}

void ReliefSums::add(const ReliefField &relief, double u, double v, double weight) noexcept {
  const Between column(u, relief.columns);
  const Between row(v, relief.rows);
  const auto add_cell = [&](std::size_t r, std::size_t c, double share) {
    add(relief.cells[r * relief.columns + c], weight * share);
  };
  add_cell(row.first, column.first, (1 - row.weight) * (1 - column.weight));
  add_cell(row.first, column.second, (1 - row.weight) * column.weight);
  add_cell(row.second, column.first, row.weight * (1 - column.weight));
  add_cell(row.second, column.second, row.weight * column.weight);
}

SurfacePoint ReliefSums::point(double highest) const noexcept {
  if (!(validity_ >= kSurface) || height_ > highest * validity_)
    return {};
  return {true, height_ / validity_, stiffness_ / validity_, friction_ / validity_};
}

} // namespace haptic
