// SPDX-License-Identifier: LGPL-2.1-or-later
// The drag of a wind: equation 5 of the motion relative to the hand. A hand that stays still feels
// what `arctan` gives; one that moves with the frame feels nothing, and one that overtakes it is
// braked, so that this law takes energy out of a hand that is faster than the frame.
#include "force-law.hpp"

#include <cmath>

namespace haptic {

ForceLawInfo drag_law() noexcept;

namespace {

class DragLaw final : public ForceLaw {
  PlanarForce force(const Motion &m, const PlanarVelocity &hand, const LawSettings &s,
                    double) noexcept override {
    const double x = m.velocity.x - hand.x;
    const double y = m.velocity.y - hand.y;
    const double k = arctan_gain(std::hypot(x, y), s.alpha, s.max_force);
    return {k * x, k * y};
  }
};

} // namespace

ForceLawInfo drag_law() noexcept {
  return {"drag", "Equation 5 on the motion relative to the hand, as wind does",
          []() -> std::unique_ptr<ForceLaw> { return std::make_unique<DragLaw>(); }};
}

} // namespace haptic
