// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/limited-device.hpp"

#include "fail.hpp"
#include "non-blocking.hpp"
#include "safety/grip-watch.hpp"
#include "safety/safety-chain.hpp"
#include "spidar/spidar.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>

namespace spidar {

namespace {

// Of a command that is not finite, zero is sent as any other zero.
constexpr std::uint32_t kHoldsThatRest = ~(haptic::kHoldSpent | haptic::kHoldNonFinite);

// What a program sees are the bits of the chain, which the log of hapticsink has too.
constexpr bool same(std::uint32_t of_program, std::uint32_t of_chain) {
  return of_program == of_chain;
}
static_assert(same(SPIDAR_HOLD_RELEASED, haptic::kHoldReleased));
static_assert(same(SPIDAR_HOLD_LET_GO, haptic::kHoldOverspeed));
static_assert(same(SPIDAR_HOLD_FAULTED, haptic::kHoldFaulted));
static_assert(same(SPIDAR_HOLD_LATE, haptic::kHoldLate));
static_assert(same(SPIDAR_HOLD_NO_POSE, haptic::kHoldNoPose));
static_assert(same(SPIDAR_HOLD_NOT_FINITE, haptic::kHoldNonFinite));
static_assert(same(SPIDAR_HOLD_SLIPPED, haptic::kHoldSlipped));
static_assert(same(SPIDAR_LIMIT_FADE, haptic::kLimitFade));
static_assert(same(SPIDAR_LIMIT_FORCE, haptic::kLimitForce));
static_assert(same(SPIDAR_LIMIT_TORQUE, haptic::kLimitTorque));
static_assert(same(SPIDAR_LIMIT_CONTINUOUS_FORCE, haptic::kLimitBudget));
static_assert(same(SPIDAR_LIMIT_SLEW, haptic::kLimitSlew));
static_assert(same(SPIDAR_LIMIT_WORK, haptic::kLimitWork));
static_assert(same(SPIDAR_SAFETY_SLEW, LimitedDevice::kSlew));
static_assert(same(SPIDAR_SAFETY_WORK, LimitedDevice::kWork));
static_assert(same(SPIDAR_SAFETY_LET_GO, LimitedDevice::kLetGo));
static_assert(same(SPIDAR_SAFETY_ALL, LimitedDevice::kAll));

// A C program has the defaults of the C++ class.
constexpr spidar_limits kDefaults = SPIDAR_LIMITS_INIT;
static_assert(kDefaults.force == ForceLimits().force);
static_assert(kDefaults.torque == ForceLimits().torque);
static_assert(kDefaults.continuous_force == ForceLimits().continuous_force);
static_assert(kDefaults.slew_rate == ForceLimits().slew_rate);
static_assert(kDefaults.damping == ForceLimits().damping);

// A signal handler may release the force.
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

double seconds(std::int64_t nanoseconds) noexcept {
  return static_cast<double>(nanoseconds) * 1e-9;
}

constexpr double kTooLate = std::chrono::duration<double>(kLongestSilence).count(); // s

} // namespace

struct LimitedDevice::Implementation {
  HapticDevice &device;
  const double period; // s
  ForceLimits limits;
  std::uint32_t switched_off = 0;
  std::optional<Wrench> wanted;
  Wrench sent;
  std::atomic<std::uint32_t> latches = 0;
  haptic::SafetyChain chain{device.limits()};
  haptic::GripWatch grip;
  std::optional<std::int64_t> exchanged_at; // ns
  double elapsed;                           // s, between the last two exchanges
  int failures = 0;                         // in a row

  Implementation(HapticDevice &of, double a_period)
      : device(of), period(a_period), elapsed(period) {}

  std::uint32_t holds(bool late) noexcept {
    std::uint32_t of_grip = grip.holds(&device, chain, false, elapsed);
    if (switched_off & kLetGo)
      of_grip &= ~haptic::kHoldOverspeed;
    latches |= of_grip & haptic::kHoldOverspeed;
    return of_grip | latches | (late ? haptic::kHoldLate : 0U);
  }

  double most_torque() const noexcept {
    return std::min(limits.torque, device.limits().strongest_torque());
  }

  haptic::SafetyChain::Input input(bool late) noexcept {
    const DeviceState &state = device.state();
    const DeviceLimits &most = device.limits();
    haptic::SafetyChain::Input input;
    input.wanted = *wanted;
    input.measured = true;
    input.trust = 1;
    input.holds = holds(late);
    input.hand_velocity = state.velocity;
    input.hand_turning = state.angular_velocity;
    input.acted = state.acted;
    input.moved = state.moved;
    input.turned = state.turned;
    input.max_force = std::min(limits.force, most.force);
    input.max_torque = most_torque();
    input.continuous_force = limits.continuous_force;
    input.slew_rate = switched_off & kSlew ? kNoSlewLimit : limits.slew_rate;
    input.damping = most.knows_newtons() ? limits.damping : 0;
    input.limits_work = !(switched_off & kWork);
    input.dt = elapsed;
    input.longest_dt = std::max(elapsed, period);
    return input;
  }

  void command_within_limits(bool late) noexcept {
    sent = chain.step(input(late));
    if (latches & haptic::kHoldFaulted)
      return device.rest(); // it may accept that even if it does not answer
    device.let_rest(chain.silent() && (chain.holds() & kHoldsThatRest));
    device.limit_side_torque(chain.most_side_torque(sent.force, most_torque()));
    device.command(sent);
  }

  void command_as_it_is() noexcept {
    sent = latches & haptic::kHoldReleased ? Wrench{} : *wanted;
    device.let_rest(false);
    device.limit_side_torque(ForceLimits().torque);
    device.command(sent);
  }

  bool exchange(std::int64_t now) noexcept HAPTIC_NONBLOCKING {
    const double since = exchanged_at ? std::max(seconds(now - *exchanged_at), 0.0) : period;
    if (wanted && switched_off == kAll)
      command_as_it_is();
    else if (wanted)
      command_within_limits(since > kTooLate); // by then the guardian acts
    exchanged_at = now;
    elapsed = since;
    const bool answered = device.exchange(now);
    failures = answered ? 0 : failures + 1;
    if (switched_off != kAll && (failures >= haptic::kFailuresToFault || !device.connected()))
      latches |= haptic::kHoldFaulted;
    if (device.state().interrupted)
      chain.restart(); // the motors are at rest
    return answered;
  }

  static constexpr double kNoSlewLimit = 1e6; // N/s: any force within a tick
};

LimitedDevice::LimitedDevice(HapticDevice &device, double period)
    : implementation_(std::make_unique<Implementation>(device, period)) {}

LimitedDevice::~LimitedDevice() = default;

void LimitedDevice::command(const Wrench &wrench) noexcept {
  implementation_->wanted = wrench;
}

bool LimitedDevice::exchange(std::int64_t now) noexcept {
  return implementation_->exchange(now);
}

void LimitedDevice::arm() noexcept {
  implementation_->latches = 0;
}

void LimitedDevice::release() noexcept {
  implementation_->latches |= haptic::kHoldReleased;
}

bool LimitedDevice::armed() const noexcept {
  const std::uint32_t obeyed =
      implementation_->switched_off == kAll ? std::uint32_t{haptic::kHoldReleased} : ~0U;
  return !(implementation_->latches & obeyed);
}

void LimitedDevice::set_limits(const ForceLimits &limits) {
  if (!limits.are_possible())
    fail(Cause::argument, messages::kForceLimits);
  implementation_->limits = limits;
}

const ForceLimits &LimitedDevice::limits() const noexcept {
  return implementation_->limits;
}

void LimitedDevice::switch_off_safety(std::uint32_t parts) noexcept {
  if (implementation_->switched_off == kAll && parts != kAll)
    implementation_->chain.restart(); // it did not see what acted
  implementation_->switched_off = parts;
}

std::uint32_t LimitedDevice::switched_off() const noexcept {
  return implementation_->switched_off;
}

std::uint32_t LimitedDevice::holds() const noexcept {
  const Implementation &state = *implementation_;
  if (state.switched_off == kAll)
    return state.latches & haptic::kHoldReleased;
  const std::uint32_t of_tick = state.wanted ? state.chain.holds() : 0;
  return (of_tick & ~(haptic::kLatches | haptic::kHoldSpent | haptic::kHoldGap)) | state.latches;
}

std::uint32_t LimitedDevice::limited_by() const noexcept {
  return implementation_->switched_off == kAll ? 0 : implementation_->chain.limits();
}

const Wrench &LimitedDevice::wrench() const noexcept {
  return implementation_->sent;
}

} // namespace spidar
