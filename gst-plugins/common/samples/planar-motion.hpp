// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion of a part of a frame in its plane: four rates, and arithmetic with them.
#pragma once

#include <cmath>

namespace haptic {

/// px/s; more is an error of the time stamps.
inline constexpr float kFastestMotion = 1e6F;

/// A motion field v(x, y) to first order without shear: its value at one place, and the
/// antisymmetric and the isotropic part of its gradient. Pixels of the frame, x to the right, y
/// down.
struct PlanarMotion {
  float velocity_x = 0; ///< px/s
  float velocity_y = 0; ///< px/s
  float spin = 0;       ///< rad/s, (dvy/dx - dvx/dy) / 2: positive turns x towards y, clockwise
  float divergence = 0; ///< 1/s, (dvx/dx + dvy/dy) / 2: mean relative rate of expansion

  bool operator==(const PlanarMotion &) const = default;

  friend PlanarMotion operator+(const PlanarMotion &a, const PlanarMotion &b) noexcept {
    return {a.velocity_x + b.velocity_x, a.velocity_y + b.velocity_y, a.spin + b.spin,
            a.divergence + b.divergence};
  }
  friend PlanarMotion operator-(const PlanarMotion &a, const PlanarMotion &b) noexcept {
    return {a.velocity_x - b.velocity_x, a.velocity_y - b.velocity_y, a.spin - b.spin,
            a.divergence - b.divergence};
  }
  /// Multiplies in double precision.
  friend PlanarMotion operator*(double factor, const PlanarMotion &m) noexcept {
    const auto times = [factor](float value) { return static_cast<float>(factor * value); };
    return {times(m.velocity_x), times(m.velocity_y), times(m.spin), times(m.divergence)};
  }
  PlanarMotion &operator*=(double factor) noexcept { return *this = factor * *this; }
};

/// Returns the motion on the straight line from `from` (share 0) to `to` (share 1).
inline PlanarMotion interpolated(const PlanarMotion &from, const PlanarMotion &to,
                                 double share) noexcept {
  return from + share * (to - from);
}

inline bool is_finite(const PlanarMotion &m) noexcept {
  return std::isfinite(m.velocity_x) && std::isfinite(m.velocity_y) && std::isfinite(m.spin) &&
         std::isfinite(m.divergence);
}

} // namespace haptic
