// SPDX-License-Identifier: LGPL-2.1-or-later
// Converts between the tension of a string (N) and its D/A word. Real-time safe.
#pragma once

#include "spidar/geometry.hpp"

#include <algorithm>
#include <cmath>

namespace spidar {

/// Signed digits per newton.
inline double digits_per_newton(const Geometry &geometry, std::size_t string) noexcept {
  return geometry.digits_per_volt * geometry.volts_per_newton[string];
}

inline double tension_of_word(const Geometry &geometry, std::size_t string,
                              std::int16_t word) noexcept {
  return word / digits_per_newton(geometry, string);
}

/// The nearest word whose tension is within the geometry's limits; check_geometry() makes sure that
/// there is one. The last step before the wire.
inline std::int16_t word_of_tension(const Geometry &geometry, std::size_t string,
                                    double tension) noexcept {
  const double scale = digits_per_newton(geometry, string);
  const double size = std::abs(scale);
  const double smallest = std::ceil(geometry.tension_min * size);
  const double largest =
      std::min(std::floor(geometry.tension_max * size), static_cast<double>(geometry.dac_limit));
  const double digits = std::isfinite(tension) ? std::round(tension * size) : smallest;
  return static_cast<std::int16_t>(std::copysign(std::clamp(digits, smallest, largest), scale));
}

} // namespace spidar
