// SPDX-License-Identifier: LGPL-2.1-or-later
// The surface of a relief, or of two between which it changes, above one place.
#pragma once

#include "samples/relief-field.hpp"

namespace haptic {

/// The surface above one place.
struct SurfacePoint {
  bool exists = false;  ///< false: nothing is known here, and the rest is 0
  double height = 0;    ///< m, z
  double stiffness = 0; ///< N/m
  double friction = 0;  ///< Coulomb coefficient
};

/// Sums over cells, each of them weighted by its validity. Real-time safe.
class ReliefSums {
public:
  /// Adds `weight` (0..1; those of all calls are 1 together) of the surface at (u, v), shares of
  /// the frame from its top left: bilinear between the centres of the four cells around, and beyond
  /// the outer centres as there. The relief must be valid.
  void add(const ReliefField &relief, double u, double v, double weight) noexcept;

  /// Returns the means. There is a surface where the validity is at least a half, up to `highest`
  /// (m).
  SurfacePoint point(double highest) const noexcept;

private:
  void add(const ReliefCell &cell, double weight) noexcept;

  double validity_ = 0;
  double height_ = 0; // times validity, as the others
  double stiffness_ = 0;
  double friction_ = 0;
};

} // namespace haptic
