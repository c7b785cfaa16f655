// SPDX-License-Identifier: LGPL-2.1-or-later
#include "force-law.hpp"

#include <array>
#include <cmath>
#include <numbers>

// A new law is a file of its own that defines NAME_law(), and a line here.
#define FORCE_LAWS(LAW)                                                                            \
  LAW(arctan_law)                                                                                  \
  LAW(arctan_axis_law)                                                                             \
  LAW(linear_law)                                                                                  \
  LAW(drag_law)                                                                                    \
  LAW(inertial_law)

namespace haptic {

#define DECLARE(law) ForceLawInfo law() noexcept;
FORCE_LAWS(DECLARE)
#undef DECLARE

namespace {
constexpr double kDivergenceHalf = 0.5; // 1/s that give half of max_push
}

std::span<const ForceLawInfo> force_laws() noexcept {
#define CALL(law) law(),
  static const std::array laws = {FORCE_LAWS(CALL)};
#undef CALL
  return laws;
}

spidar::Wrench ForceLaw::wrench(const Motion &motion, const PlanarVelocity &hand,
                                const LawSettings &settings, double dt) noexcept {
  const PlanarForce planar = force(motion, hand, settings, dt);
  const double push =
      arctan_gain(motion.divergence, 1 / kDivergenceHalf, settings.max_push) * motion.divergence;
  const double turn =
      arctan_gain(motion.spin, 1 / settings.spin_half, settings.max_torque) * motion.spin;
  // Frame y points down: what turns clockwise on the screen turns negatively about z.
  return {.force = {planar.x, -planar.y, push}, .torque = {0, 0, -turn}};
}

} // namespace haptic
