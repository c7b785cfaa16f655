#include "safety-chain.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

using spidar::Vector3;

struct FadeTimes {
  std::uint32_t hold;
  double out; // s, from whatever the force is to zero
  double in;  // s, from zero to full
};

constexpr std::array kFadeTimes = {
    FadeTimes{kHoldClosed, 0, 0.05},     FadeTimes{kHoldPaused, 0.1, 0.05},
    FadeTimes{kHoldFlushing, 0.05, 0.2}, FadeTimes{kHoldEnded, 0.1, 0.2},
    FadeTimes{kHoldReleased, 0.05, 0.5}, FadeTimes{kHoldOverspeed, 0.05, 0.5},
    FadeTimes{kHoldFaulted, 0, 0.5},     FadeTimes{kHoldLate, 0.05, 0.2},
    FadeTimes{kHoldNoPose, 0.05, 0.2},   FadeTimes{kHoldGap, 0.1, 0.05},
    FadeTimes{kHoldStale, 0.1, 0.05},
};

// Over within a tick, but what came before must not go on as if nothing had been.
constexpr std::uint32_t kUntilZero = kHoldFlushing | kHoldLate;

constexpr double kGateRelease = 0.1;  // s, time constant
constexpr double kGateNothing = 1e-3; // an exponential never ends by itself
constexpr double kStaleIntervals = 3;
constexpr double kStaleShortest = 0.1; // s
constexpr double kStaleLongest = 2;    // s

bool is_finite(const SafetyChain::Input &input) {
  return input.wanted.allFinite() && std::isfinite(input.confidence) && std::isfinite(input.age) &&
         std::isfinite(input.interval) && std::isfinite(input.max_force) &&
         std::isfinite(input.slew_rate) && std::isfinite(input.dt);
}

Vector3 clamp_norm(const Vector3 &v, double limit) {
  const double norm = v.norm();
  return norm > limit ? Vector3(v * (limit / norm)) : v;
}

} // namespace

double stale_after(double interval) noexcept {
  return std::clamp(kStaleIntervals * interval, kStaleShortest, kStaleLongest);
}

double confidence_gate(double confidence) noexcept {
  return std::clamp((confidence - 0.2) / 0.3, 0.0, 1.0);
}

Vector3 SafetyChain::step(const Input &input) noexcept {
  listening_ = false;
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
  listening_ = !(holds & (kHoldGap | kHoldStale));

  const double target = input.measured ? confidence_gate(input.confidence) : 0;
  if (target >= gate_)
    gate_ = target;
  else
    gate_ = target + (gate_ - target) * std::exp(-dt / kGateRelease);
  if (gate_ < kGateNothing)
    gate_ = 0;

  if (holds)
    return fade_out(holds, dt);
  return follow(input);
}

Vector3 SafetyChain::silence() noexcept {
  envelope_ = 0;
  gate_ = 0;
  accepted_.setZero();
  output_.setZero();
  return output_;
}

// Scales down what is commanded now, so that the force falls in a straight line whatever the law
// and the samples do meanwhile, and reaches zero in time also where the slew limit would not let
// it.
Vector3 SafetyChain::fade_out(std::uint32_t holds, double dt) noexcept {
  if (!holds_) {
    fade_left_ = kStaleLongest;
    if (envelope_ >= 1)
      fade_in_ = 0; // else the fade-in that is cut short stays as slow as it was
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
  output_ *= factor;
  return output_;
}

Vector3 SafetyChain::follow(const Input &input) noexcept {
  holds_ = 0;
  const double dt = std::max(input.dt, 0.0);
  envelope_ = fade_in_ > 0 ? std::min(envelope_ + dt / fade_in_, 1.0) : 1.0;

  // A measurement not worth trusting must not turn the force on its way to zero.
  if (confidence_gate(input.confidence) > 0)
    accepted_ = input.wanted;
  const Vector3 target = clamp_norm(accepted_, input.max_force) * (gate_ * envelope_);

  const double step = input.slew_rate * dt;
  const double before = output_.norm();
  const Vector3 change = target - output_;
  output_ = change.norm() <= step ? target : Vector3(output_ + clamp_norm(change, step));
  output_ = clamp_norm(output_, std::max(input.max_force, before - step));
  return output_;
}

} // namespace haptic
