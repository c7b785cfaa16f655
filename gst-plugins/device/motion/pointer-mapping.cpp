// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/pointer-mapping.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {
constexpr double kChange = 0.001;
constexpr double kForceChange = 0.01;            // N
constexpr double kDepthChange = 1e-4;            // m
constexpr std::int64_t kKeepAlive = 200'000'000; // ns

// The begin and the end of a touch count, however light it is.
bool differs(const std::optional<ProxyPosition> &a,
             const std::optional<ProxyPosition> &b) noexcept {
  if (!a || !b)
    return a.has_value() != b.has_value();
  return std::abs(a->x - b->x) > kChange || std::abs(a->y - b->y) > kChange ||
         std::abs(a->depth - b->depth) > kDepthChange || (a->depth > 0) != (b->depth > 0);
}

bool differs(const PointerPosition &a, const PointerPosition &b) noexcept {
  if (std::abs(a.x - b.x) > kChange || std::abs(a.y - b.y) > kChange ||
      std::abs(a.z - b.z) > kChange || a.pressed != b.pressed ||
      a.force.has_value() != b.force.has_value())
    return true;
  for (std::size_t i = 0; a.force && i < a.force->size(); ++i)
    if (std::abs((*a.force)[i] - (*b.force)[i]) > kForceChange)
      return true;
  return differs(a.proxy, b.proxy);
}

// Equation 1 about the centre: parts of the frame, y down.
FrameShift from_centre(const spidar::Vector3 &hand,
                       const spidar::Vector3 &workspace_half) noexcept {
  return {hand.x() / (2 * workspace_half.x()), -hand.y() / (2 * workspace_half.y())};
}
} // namespace

PointerPosition map_pointer(const spidar::Vector3 &hand, const spidar::Vector3 &workspace_half,
                            const FrameShift &shift) noexcept {
  const FrameShift place = from_centre(hand, workspace_half);
  PointerPosition position;
  position.x = std::clamp(0.5 + place.x + shift.x, 0.0, 1.0);
  position.y = std::clamp(0.5 + place.y + shift.y, 0.0, 1.0);
  position.z = std::clamp(hand.z() / workspace_half.z(), -1.0, 1.0);
  return position;
}

// s' = d min(1, m (|u'| - u_0) / |d|) for |u'| > u_0: u is the hand in parts of the frame, d = k u
// the wash-out of first order of a motion platform with the rate k (or d = -s / 1 s when it is
// off), m = kMostDrift, u_0 = kResting.
void WashOut::step(const spidar::Vector3 &hand, const spidar::Vector3 &velocity,
                   const spidar::Vector3 &workspace_half, double rate, double dt) noexcept {
  const FrameShift speed = from_centre(velocity, workspace_half);
  const double moving = std::hypot(speed.x, speed.y) - kResting;
  const FrameShift place = from_centre(hand, workspace_half);
  const FrameShift drift =
      rate > 0 ? FrameShift{rate * place.x, rate * place.y} : FrameShift{-shift_.x, -shift_.y};
  const double length = std::hypot(drift.x, drift.y);
  if (!(length > 0) || !(moving > 0)) // also for NaN
    return;
  const double share = std::min(1.0, kMostDrift * moving / length) * dt;
  // At 0.5 the hand in the centre points at the border of the frame.
  shift_.x = std::clamp(shift_.x + share * drift.x, -0.5, 0.5);
  shift_.y = std::clamp(shift_.y + share * drift.y, -0.5, 0.5);
}

bool PointerGate::pass(const PointerPosition &position, std::int64_t now) noexcept {
  if (last_ && now - last_time_ < kKeepAlive && !differs(position, *last_))
    return false;
  last_ = position;
  last_time_ = now;
  return true;
}

} // namespace haptic
