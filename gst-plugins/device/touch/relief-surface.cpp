// SPDX-License-Identifier: LGPL-2.1-or-later
#include "touch/relief-surface.hpp"

#include <algorithm>

namespace haptic {

ReliefSurface::ReliefSurface(const ReliefField &from, const ReliefField &to, double weight,
                             const spidar::Vector3 &half, const FrameShift &shift) noexcept
    : from_(from), to_(to), weight_(weight), half_(half), shift_(shift),
      cell_x_(2 * half.x() / std::max<int>(from.columns, to.columns)),
      cell_y_(2 * half.y() / std::max<int>(from.rows, to.rows)) {}

// Equation 1, as map_pointer() without its clamp.
SurfacePoint ReliefSurface::at(double x, double y) const noexcept {
  const double u = 0.5 + x / (2 * half_.x()) + shift_.x;
  const double v = 0.5 - y / (2 * half_.y()) + shift_.y;
  ReliefSums sums;
  if (weight_ < 1)
    sums.add(from_, u, v, 1 - weight_);
  if (weight_ > 0)
    sums.add(to_, u, v, weight_);
  return sums.point(half_.z());
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
