// SPDX-License-Identifier: LGPL-2.1-or-later
// The paper's nonlinear gain controller, equation 5: F = (2 F_max / pi) atan(alpha v).
#include "force-law.hpp"

#include <cmath>

namespace haptic {

ForceLawInfo arctan_law() noexcept;
ForceLawInfo arctan_axis_law() noexcept;

namespace {

// On the speed: the force keeps the direction of the motion and never exceeds max_force.
class ArctanLaw final : public ForceLaw {
  PlanarForce force(const Motion &m, const PlanarVelocity &, const LawSettings &s,
                    double) noexcept override {
    const auto &v = m.velocity;
    const double k = arctan_gain(std::hypot(v.x, v.y), s.alpha, s.max_force);
    return {k * v.x, k * v.y};
  }
};

// As printed. It bends diagonal motions towards the diagonal, and its length reaches 1.41 max_force
// (the safety chain cuts that).
class ArctanAxisLaw final : public ForceLaw {
  PlanarForce force(const Motion &m, const PlanarVelocity &, const LawSettings &s,
                    double) noexcept override {
    const auto &v = m.velocity;
    return {arctan_gain(v.x, s.alpha, s.max_force) * v.x,
            arctan_gain(v.y, s.alpha, s.max_force) * v.y};
  }
};

} // namespace

ForceLawInfo arctan_law() noexcept {
  return {"arctan", "Equation 5 on the speed, along the motion",
          []() -> std::unique_ptr<ForceLaw> { return std::make_unique<ArctanLaw>(); }};
}

ForceLawInfo arctan_axis_law() noexcept {
  return {"arctan-axis", "Equation 5 on each axis, as printed",
          []() -> std::unique_ptr<ForceLaw> { return std::make_unique<ArctanAxisLaw>(); }};
}

} // namespace haptic
