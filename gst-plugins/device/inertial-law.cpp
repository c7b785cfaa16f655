// SPDX-License-Identifier: LGPL-2.1-or-later
// Newton's second law on the acceleration of the frame relative to the hand (Dindar, Tekalp and
// Basdogan's dynamic force), the acceleration taken over 0.1 s: a raw second difference of 0.1 px
// of tracking noise at 30 frames/s is 220 px/s². What remains is equation 5 of the velocity that
// came within that time.
#include "force-law.hpp"

#include <cmath>

namespace haptic {

ForceLawInfo inertial_law() noexcept;

namespace {

constexpr double kResponse = 0.1; // s

class InertialLaw final : public ForceLaw {
  PlanarForce force(const Motion &m, const PlanarVelocity &hand, const LawSettings &s,
                    double dt) noexcept override {
    const double x = m.velocity.x - hand.x;
    const double y = m.velocity.y - hand.y;
    // What is not finite must not stay in the memory.
    if (!std::isfinite(x + y + usual_.x + usual_.y))
      usual_ = {};
    const double share = 1 - std::exp(-dt / kResponse);
    usual_.x += share * (x - usual_.x);
    usual_.y += share * (y - usual_.y);
    const double gained_x = x - usual_.x; // acceleration times kResponse
    const double gained_y = y - usual_.y;
    const double k = arctan_gain(std::hypot(gained_x, gained_y), s.alpha, s.max_force);
    return {k * gained_x, k * gained_y};
  }

  PlanarVelocity usual_; // low-passed
};

} // namespace

ForceLawInfo inertial_law() noexcept {
  return {"inertial", "Equation 5 on the acceleration relative to the hand, times 0.1 s",
          []() -> std::unique_ptr<ForceLaw> { return std::make_unique<InertialLaw>(); }};
}

} // namespace haptic
