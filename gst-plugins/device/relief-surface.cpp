// SPDX-License-Identifier: LGPL-2.1-or-later
#include "relief-surface.hpp"

#include <array>
#include <cmath>
#include <cstddef>

namespace haptic {
namespace {

constexpr double kSurface = 0.5; // validity from which there is a surface

struct Sums {
  double validity = 0;
  double height = 0;
  double stiffness = 0;
  double friction = 0;

  void add(const ReliefCell &cell, double weight) noexcept {
    const double valid = weight * static_cast<double>(cell.validity);
    validity += valid;
    height += valid * static_cast<double>(cell.height);
    stiffness += valid * static_cast<double>(cell.stiffness);
    friction += valid * static_cast<double>(cell.friction);
  }
};

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

// Sum over the four cells around (u, v), parts of the frame.
void add_field(const ReliefField &field, double u, double v, double weight, Sums &sums) noexcept {
  const Between column(u, field.columns);
  const Between row(v, field.rows);
  const auto add = [&](std::size_t r, std::size_t c, double share) {
    sums.add(field.cells[r * field.columns + c], weight * share);
  };
  add(row.first, column.first, (1 - row.weight) * (1 - column.weight));
  add(row.first, column.second, (1 - row.weight) * column.weight);
  add(row.second, column.first, row.weight * (1 - column.weight));
  add(row.second, column.second, row.weight * column.weight);
}

} // namespace

ReliefSurface::ReliefSurface(const ReliefField &from, const ReliefField &to, double weight,
                             const spidar::Vector3 &half, const FrameShift &shift) noexcept
    : from_(from), to_(to), weight_(weight), half_(half), shift_(shift),
      cell_x_(2 * half.x() / std::max<int>(from.columns, to.columns)),
      cell_y_(2 * half.y() / std::max<int>(from.rows, to.rows)) {}

// Equation 1, as map_pointer() without its clamp.
SurfacePoint ReliefSurface::at(double x, double y) const noexcept {
  const double u = 0.5 + x / (2 * half_.x()) + shift_.x;
  const double v = 0.5 - y / (2 * half_.y()) + shift_.y;
  Sums sums;
  if (weight_ < 1)
    add_field(from_, u, v, 1 - weight_, sums);
  if (weight_ > 0)
    add_field(to_, u, v, weight_, sums);
  if (!(sums.validity >= kSurface) || sums.height > half_.z() * sums.validity)
    return {};
  return {true, sums.height / sums.validity, sums.stiffness / sums.validity,
          sums.friction / sums.validity};
}

// Of the sides that exist.
double ReliefSurface::slope(double x, double y, double dx, double dy) const noexcept {
  const SurfacePoint here = at(x, y);
  const SurfacePoint before = at(x - dx, y - dy);
  const SurfacePoint after = at(x + dx, y + dy);
  const double run = (dx + dy) * (int{before.exists} + int{after.exists});
  const double rise = (after.exists ? after : here).height - (before.exists ? before : here).height;
  return run > 0 ? rise / run : 0;
}

spidar::Vector3 ReliefSurface::normal(double x, double y) const noexcept {
  return spidar::Vector3(-slope(x, y, cell_x_ / 2, 0), -slope(x, y, 0, cell_y_ / 2), 1)
      .normalized();
}

} // namespace haptic
