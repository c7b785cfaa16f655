// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "safety/safety-chain.hpp"

#include <cstdint>
#include <spidar/haptic-device.hpp>

namespace haptic {

/// Watches whether a hand holds the grip. One thread; real-time safe.
class GripWatch {
public:
  /// Returns kHoldDeadMan, kHoldNoPose, kHoldSlipped and kHoldOverspeed as the grip gives reason
  /// for them on this tick, `dt` s after the one before. `device`: null without a hand. `dead_man`:
  /// no force unless a button of the grip is pressed.
  std::uint32_t holds(const spidar::HapticDevice *device, const SafetyChain &chain, bool dead_man,
                      double dt) noexcept {
    std::uint32_t holds = dead_man && !(device && device->state().pressed) ? kHoldDeadMan : 0U;
    if (device && !device->state().valid)
      holds |= kHoldNoPose;
    else if (device && device->limits().grip_is_free && is_let_go(*device, chain, dt))
      holds |= kHoldOverspeed;
    if (device && (device->state().slipping || device->state().slipped))
      holds |= kHoldSlipped;
    return holds;
  }

private:
  static constexpr double kTurnsFor = 0.0045; // s, as the speed's low-pass of 35 Hz

  // Without a force the grip may move and turn as fast as the hand likes.
  bool is_let_go(const spidar::HapticDevice &device, const SafetyChain &chain, double dt) noexcept {
    const spidar::DeviceState &state = device.state();
    const spidar::DeviceLimits &limits = device.limits();
    const double turning = state.angular_velocity.norm();
    const bool turns = turning > limits.whirl ||
                       (turning > limits.let_go_turn && chain.drives(state.angular_velocity));
    turns_for_ = turns ? turns_for_ + dt : 0;
    return !chain.silent() &&
           (state.velocity.norm() > limits.let_go_speed || turns_for_ >= kTurnsFor);
  }

  double turns_for_ = 0; // s, faster than a hand that is in control of the grip
};

} // namespace haptic
