// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-force.hpp"

#include "samples/force-defaults.hpp"

#include <cmath>

namespace haptic {

bool is_felt(const MotionSample &sample) noexcept {
  return confidence_gate(sample.confidence) > 0;
}

ReferenceVelocity reference_velocity(const MotionSample &s) noexcept {
  const double scale = kReferenceWidth / s.frame_width;
  const double right = scale * s.velocity_x;
  const double up = -scale * s.velocity_y * s.pixel_aspect_d / s.pixel_aspect_n;
  return std::isfinite(std::hypot(right, up)) ? ReferenceVelocity{right, up} : ReferenceVelocity{};
}

CurveForce force_of_motion(const MotionSample &s) noexcept {
  const auto [right, up] = reference_velocity(s);
  const double gain =
      arctan_gain(std::hypot(right, up), kDefaultAlpha, 1) * confidence_gate(s.confidence);
  return {gain * right, gain * up};
}

} // namespace haptic
