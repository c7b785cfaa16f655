// SPDX-License-Identifier: LGPL-2.1-or-later
// The surface that a hand touches: a relief, or a line between two of them in time, in metres of
// the device's workspace.
#pragma once

#include "motion/pointer-mapping.hpp"
#include "samples/relief-sampler.hpp"

#include <algorithm>
#include <spidar/types.hpp>

namespace haptic {

/// A view: the reliefs outlive it. Heights, stiffness and friction are means of the cells by
/// validity, bilinear in place and linear in time; there is a surface where the mean validity is at
/// least a half. Axes of types.hpp. Real-time safe.
class ReliefSurface {
public:
  /// `weight` 0..1: 0 is `from`, 1 is `to`, which may be the same. `half`: m, half extents of the
  /// workspace, which shows the whole frame (map_pointer()), shifted by `shift`.
  ReliefSurface(const ReliefField &from, const ReliefField &to, double weight,
                const spidar::Vector3 &half, const FrameShift &shift = {}) noexcept;

  /// `x` and `y` in m.
  SurfacePoint at(double x, double y) const noexcept;
  /// Unit normal, z > 0: of the slope between half a cell to each side, so that it has no step at
  /// the borders of cells. There must be a surface at (x, y).
  spidar::Vector3 normal(double x, double y) const noexcept;
  /// Smaller side of a cell, m.
  double cell() const noexcept { return std::min(cell_x_, cell_y_); }

private:
  double slope(double x, double y, double dx, double dy) const noexcept;

  const ReliefField &from_;
  const ReliefField &to_;
  double weight_;
  spidar::Vector3 half_;
  FrameShift shift_;
  double cell_x_; // m
  double cell_y_;
};

} // namespace haptic
