// SPDX-License-Identifier: LGPL-2.1-or-later
#include "force/safety-chain.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

using spidar::Vector3;
using spidar::Wrench;

struct FadeTimes {
  std::uint32_t hold;
  double out; // s, from whatever the force is to zero
  double in;  // s, from zero to full
};

constexpr std::array kFadeTimes = {
    FadeTimes{kHoldClosed, 0, 0.05},      FadeTimes{kHoldPaused, 0.1, 0.05},
    FadeTimes{kHoldFlushing, 0.05, 0.2},  FadeTimes{kHoldEnded, 0.1, 0.2},
    FadeTimes{kHoldReleased, 0.05, 0.5},  FadeTimes{kHoldOverspeed, 0.05, 0.5},
    FadeTimes{kHoldFaulted, 0, 0.5},      FadeTimes{kHoldLate, 0.05, 0.2},
    FadeTimes{kHoldNoPose, 0.05, 0.2},    FadeTimes{kHoldGap, 0.1, 0.05},
    FadeTimes{kHoldStale, 0.1, 0.05},     FadeTimes{kHoldCut, 0.05, 0.05},
    FadeTimes{kHoldSuspended, 0.05, 0.5}, FadeTimes{kHoldDeadMan, 0.05, 0.2},
};

// These may last for one tick only; the fade must still reach zero.
constexpr std::uint32_t kUntilZero = kHoldFlushing | kHoldLate | kHoldCut;

constexpr double kGateRelease = 0.1;  // s, time constant
constexpr double kGateNothing = 1e-3; // an exponential never ends by itself
constexpr double kStaleIntervals = 3;
constexpr double kStaleShortest = 0.1; // s
constexpr double kStaleLongest = 2;    // s

// The force goes down over the last of the work, so that running out of it is no step.
constexpr double kWorkToFade = 0.25; // J

// A lowered maximum takes the force off at least so fast, whatever the slew rate: 5 N, the most
// that is offered, in 50 ms. A step would be felt as a blow.
constexpr double kMaximumFalls = 100; // N/s; for the torque at kTorqueArm
// The budget for continuous force spares motors and hand over a minute, and has time.
constexpr double kBudgetFalls = 20; // N/s

bool is_finite(const SafetyChain::Input &input) {
  return input.wanted.force.allFinite() && input.wanted.torque.allFinite() &&
         input.hand_velocity.allFinite() && input.hand_turning.allFinite() &&
         input.moved.allFinite() && input.turned.allFinite() && std::isfinite(input.confidence) &&
         std::isfinite(input.age) && std::isfinite(input.interval) &&
         std::isfinite(input.max_force) && std::isfinite(input.continuous_force) &&
         std::isfinite(input.max_torque) && std::isfinite(input.slew_rate) &&
         std::isfinite(input.damping) && std::isfinite(input.dt);
}

Vector3 clamp_norm(const Vector3 &v, double limit) {
  const double norm = v.norm();
  return norm > limit ? Vector3(v * (limit / norm)) : v;
}

// Returns a step of at most `most` towards the target, cut to the limit.
Vector3 approach(const Vector3 &from, const Vector3 &target, double most, double limit) {
  return clamp_norm(from + clamp_norm(target - from, most), limit);
}

// F' = F - min(b (|v| - v_0), |F|) v / |v| for |v| > v_0 = kUndamped. Never stronger than the force
// that it damps: without a force nothing runs away.
Vector3 damped(const Vector3 &force, const SafetyChain::Input &input) {
  const double speed = input.hand_velocity.norm();
  if (speed <= SafetyChain::kUndamped)
    return force;
  const double brake = std::min(input.damping * (speed - SafetyChain::kUndamped), force.norm());
  return force - brake / speed * input.hand_velocity;
}

// tau' = tau - min(b (|w| - w_0), |tau| + r |F|) w / |w| for |w| > w_0 = kUnbraked, with
// b = kTurnBrake and r = kTorqueArm: away from the centre a force turns the grip, too. It is not
// slew-limited: a free grip turns up within milliseconds.
Vector3 braked_torque(const Wrench &wrench, const SafetyChain::Input &input) {
  const double speed = input.hand_turning.norm();
  if (speed <= SafetyChain::kUnbraked)
    return wrench.torque;
  const double most = wrench.torque.norm() + SafetyChain::kTorqueArm * wrench.force.norm();
  const double brake = std::min(SafetyChain::kTurnBrake * (speed - SafetyChain::kUnbraked), most);
  return clamp_norm(wrench.torque - brake / speed * input.hand_turning,
                    std::max(input.max_torque, wrench.torque.norm()));
}

} // namespace

double stale_after(double interval) noexcept {
  return std::clamp(kStaleIntervals * interval, kStaleShortest, kStaleLongest);
}

Wrench SafetyChain::step(const Input &input) noexcept {
  follows_sample_ = false;
  non_finite_ = !is_finite(input);
  if (non_finite_)
    return silence();

  const double dt = std::max(input.dt, 0.0);
  std::uint32_t holds = input.holds;
  if (!input.measured)
    holds |= kHoldGap;
  else if (input.age > stale_after(input.interval))
    holds |= kHoldStale;
  if (!silent())
    holds |= holds_ & kUntilZero;
  follows_sample_ = !(holds & (kHoldGap | kHoldStale));

  const double target = input.measured ? confidence_gate(input.confidence) : 0;
  if (target >= gate_)
    gate_ = target;
  else
    gate_ = target + (gate_ - target) * std::exp(-dt / kGateRelease);
  if (gate_ < kGateNothing)
    gate_ = 0;

  account_for_work(input);
  acting_ = braked_;
  force_limit_ = continuous_force_.step(output_.force.norm(), input.continuous_force, dt);
  limited_ = false;
  braked_ = holds ? fade_out(holds, dt) : follow(input);
  braked_.torque = braked_torque(output_, input);
  return braked_;
}

Wrench SafetyChain::silence() noexcept {
  envelope_ = 0;
  gate_ = 0;
  accepted_ = {};
  output_ = {};
  braked_ = {};
  return output_;
}

void SafetyChain::restart() noexcept {
  silence();
  holds_ = kHoldGap;
  fade_left_ = 0;
  fade_in_ = std::max(fade_in_, SafetyChain().fade_in_);
}

void SafetyChain::begin_run(double acted) noexcept {
  SafetyChain anew;
  anew.work_left_ = work_left_;
  anew.continuous_force_ = continuous_force_;
  anew.continuous_force_.step(output_.force.norm(), acted);
  *this = anew;
}

void SafetyChain::rest(double seconds) noexcept {
  account_for_work({.dt = seconds});
  continuous_force_.step(0, seconds);
}

// F(t) = F(0) (1 - t / T): scales down the present command, so that the force falls in a straight
// line whatever the law and the samples do meanwhile, and reaches zero after T = fade_left_ also
// where the slew limit is slower.
Wrench SafetyChain::fade_out(std::uint32_t holds, double dt) noexcept {
  if (!holds_) {
    fade_left_ = kStaleLongest;
    if (envelope_ >= 1)
      fade_in_ = 0; // else an interrupted fade-in keeps its slowness
  }
  for (const auto &times : kFadeTimes) {
    if (!(holds & times.hold))
      continue;
    if (!(holds_ & times.hold))
      fade_left_ = std::min(fade_left_, times.out);
    fade_in_ = std::max(fade_in_, times.in);
  }
  holds_ = holds;

  // The tolerance keeps rounding from adding a step.
  if (fade_left_ <= dt * (1 + 1e-6)) {
    fade_left_ = 0;
    return silence();
  }
  const double factor = (fade_left_ - dt) / fade_left_;
  fade_left_ -= dt;
  envelope_ *= factor;
  output_.force *= factor;
  output_.torque *= factor;
  return output_;
}

// E += 0.3 W dt - max(F . dx + tau . dphi, 0), E <= 0.9 J, F and tau of the command before last:
// the device sends a command at the next exchange, and it acts until the one after that. A
// low-passed velocity lags by 5 ms and misses half of the work on a hand that goes round fast. Only
// work that the force did counts: a hand that pushes back does not add to the budget. What a late
// tick let the force do beyond it is a debt.
void SafetyChain::account_for_work(const Input &input) noexcept {
  const double work = acting_.force.dot(input.moved) + acting_.torque.dot(input.turned);
  work_left_ += kWorkRate * std::max(input.dt, 0.0) - std::max(work, 0.0);
  work_left_ = std::min(work_left_, kWorkAtOnce);
}

Wrench SafetyChain::follow(const Input &input) noexcept {
  holds_ = 0;
  const double dt = std::max(input.dt, 0.0);
  envelope_ = fade_in_ > 0 ? std::min(envelope_ + dt / fade_in_, 1.0) : 1.0;

  // A measurement not worth trusting must not turn the force on its way to zero.
  if (confidence_gate(input.confidence) > 0)
    accepted_ = input.wanted;
  const double share = gate_ * envelope_;
  const Vector3 wanted = clamp_norm(accepted_.force, input.max_force) * share;
  const Vector3 force = damped(clamp_norm(wanted, force_limit_), input);
  const Vector3 torque = clamp_norm(accepted_.torque, input.max_torque) * share;
  limited_ = wanted.norm() > force_limit_;

  const double step = input.slew_rate * dt;
  const double fall = std::max(input.slew_rate, kMaximumFalls) * dt;
  const double budget_fall = std::max(input.slew_rate, kBudgetFalls) * dt;
  const double before = output_.force.norm();
  output_.force = approach(output_.force, force, step,
                           std::min(std::max(input.max_force, before - fall),
                                    std::max(force_limit_, before - budget_fall)));
  output_.torque = approach(output_.torque, torque, step * kTorqueArm,
                            std::max(input.max_torque, output_.torque.norm() - fall * kTorqueArm));

  // The slew rate does not delay this limit: a carried hand uses up the work within milliseconds.
  const double left = std::clamp(work_left_ / kWorkToFade, 0.0, 1.0);
  output_.force = clamp_norm(output_.force, std::max(input.max_force, output_.force.norm()) * left);
  output_.torque =
      clamp_norm(output_.torque, std::max(input.max_torque, output_.torque.norm()) * left);
  return output_;
}

} // namespace haptic
