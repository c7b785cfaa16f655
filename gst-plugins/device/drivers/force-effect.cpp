// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/force-effect.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace haptic {
namespace {

constexpr double kFullLevel = 0x7fff;
constexpr double kFullMagnitude = 0xffff;
constexpr double kTurn = 0x10000;  // of ff_effect::direction
constexpr int kSameLevel = 0x40;   // 0.2 % of the full one
constexpr int kSameDirection = 64; // a third of a degree

int level_of(const ff_effect &effect) noexcept {
  return effect.type == FF_RUMBLE ? effect.u.rumble.strong_magnitude / 2 : effect.u.constant.level;
}

} // namespace

ff_effect force_effect(const spidar::Vector3 &force, ForceKind kind, bool has_y,
                       std::int16_t id) noexcept {
  const double x = force.x();
  const double y = has_y ? force.y() : 0;
  double share = std::hypot(x, y) / kFullForce;
  if (!std::isfinite(share))
    share = 0;
  share = std::min(share, 1.0);

  ff_effect effect{};
  effect.id = id;
  effect.replay.length = kEffectLength;
  if (kind == ForceKind::rumble) {
    effect.type = FF_RUMBLE;
    effect.u.rumble.strong_magnitude =
        static_cast<std::uint16_t>(std::lround(share * kFullMagnitude));
    return effect;
  }
  effect.type = FF_CONSTANT;
  effect.u.constant.level = static_cast<std::int16_t>(std::lround(share * kFullLevel));
  if (share > 0) {
    // The direction of the pull: 0 down, a quarter of a turn to the left, half of one up.
    const double turns = std::atan2(-x, -y) / (2 * std::numbers::pi);
    effect.direction = static_cast<std::uint16_t>(std::lround(turns * kTurn) & 0xffff);
  }
  return effect;
}

bool is_silent(const ff_effect &effect) noexcept {
  return level_of(effect) == 0;
}

bool feels_alike(const ff_effect &a, const ff_effect &b) noexcept {
  const auto turned = static_cast<std::int16_t>(a.direction - b.direction);
  return is_silent(a) == is_silent(b) && std::abs(level_of(a) - level_of(b)) <= kSameLevel &&
         std::abs(turned) <= kSameDirection;
}

} // namespace haptic
