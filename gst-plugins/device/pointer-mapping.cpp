// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pointer-mapping.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {
constexpr double kChange = 0.001;
constexpr double kForceChange = 0.01;            // N
constexpr std::int64_t kKeepAlive = 200'000'000; // ns

bool differs(const PointerPosition &a, const PointerPosition &b) noexcept {
  if (std::abs(a.x - b.x) > kChange || std::abs(a.y - b.y) > kChange ||
      std::abs(a.z - b.z) > kChange || a.force.has_value() != b.force.has_value())
    return true;
  for (std::size_t i = 0; a.force && i < a.force->size(); ++i)
    if (std::abs((*a.force)[i] - (*b.force)[i]) > kForceChange)
      return true;
  return false;
}
} // namespace

PointerPosition map_pointer(const spidar::Vector3 &hand,
                            const spidar::Vector3 &workspace_half) noexcept {
  PointerPosition position;
  position.x = std::clamp(0.5 + hand.x() / (2 * workspace_half.x()), 0.0, 1.0);
  position.y = std::clamp(0.5 - hand.y() / (2 * workspace_half.y()), 0.0, 1.0);
  position.z = std::clamp(hand.z() / workspace_half.z(), -1.0, 1.0);
  return position;
}

bool PointerGate::pass(const PointerPosition &position, std::int64_t now) noexcept {
  if (last_ && now - last_time_ < kKeepAlive && !differs(position, *last_))
    return false;
  last_ = position;
  last_time_ = now;
  return true;
}

} // namespace haptic
