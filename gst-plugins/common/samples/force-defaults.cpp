// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/force-defaults.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptic {

double confidence_gate(double confidence) noexcept {
  return std::clamp((confidence - 0.2) / 0.3, 0.0, 1.0);
}

double arctan_gain(double v, double alpha, double maximum) noexcept {
  const double scale = 2 * maximum / std::numbers::pi;
  const double x = alpha * v;
  // Below 1e-4 the next term of the series is less than 1e-17.
  if (std::abs(x) < 1e-4)
    return scale * alpha * (1 - x * x / 3);
  return scale * std::atan(x) / v;
}

} // namespace haptic
