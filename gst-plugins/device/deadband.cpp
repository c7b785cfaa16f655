// SPDX-License-Identifier: LGPL-2.1-or-later
#include "deadband.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kRelease = 0.1; // s

double share_kept(double speed) {
  if (speed <= kStillSpeed)
    return 0;
  if (speed >= kMovingSpeed)
    return 1;
  return kMovingSpeed / (kMovingSpeed - kStillSpeed) * (speed - kStillSpeed) / speed;
}

} // namespace

Motion Deadband::step(Motion motion, double dt) noexcept {
  const double speed = std::hypot(motion.velocity.x, motion.velocity.y);
  fastest_ = std::max(fastest_ * std::exp(-dt / kRelease), speed);
  const double keep = share_kept(fastest_);
  motion.velocity.x *= keep;
  motion.velocity.y *= keep;
  return motion;
}

} // namespace haptic
