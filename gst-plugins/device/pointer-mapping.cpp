#include "pointer-mapping.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {
constexpr double kChange = 0.001;
constexpr std::int64_t kKeepAlive = 200'000'000; // ns
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
  if (last_ && now - last_time_ < kKeepAlive && std::abs(position.x - last_->x) <= kChange &&
      std::abs(position.y - last_->y) <= kChange && std::abs(position.z - last_->z) <= kChange)
    return false;
  last_ = position;
  last_time_ = now;
  return true;
}

} // namespace haptic
