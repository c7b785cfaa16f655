// SPDX-License-Identifier: LGPL-2.1-or-later
// The other device of the tests: a strong, damped arm of three degrees of freedom, and a hand that
// holds it. It commands and measures as spidar::HapticDevice says, and has kArm's limits.
#pragma once

#include "device-limits.hpp"
#include "held-grip.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <spidar/haptic-device.hpp>
#include <string>
#include <utility>

namespace test {

class HandOnArm final : public spidar::HapticDevice, public HeldGrip {
public:
  HandOnArm(const Hand &of, const spidar::Vector3 &start, double period)
      : HeldGrip(of, start, 0.08), period_(period) {
    state_.pose.position = measured();
    state_.valid = true;
  }

  void intervene() noexcept override {
    force_.setZero();
    intervened_ = true;
  }
  spidar::Wrench wrench() const noexcept override { return {.force = force_}; }

  // The force of a command leaves with the next exchange, and acts until the one after that.
  bool exchange(std::int64_t now) noexcept override {
    const double elapsed = now_ ? static_cast<double>(now - *now_) * 1e-9 : period_;
    if (now_)
      advance(elapsed);
    now_ = now;
    since_valid_ += elapsed;
    state_.interrupted = std::exchange(intervened_, false);
    state_.acted.force = force_;
    state_.moved.setZero();
    state_.valid = answers && plugged_in;
    state_.pressed = state_.valid && presses;
    if (!state_.valid)
      return false;
    force_ = commanded_;
    const spidar::Vector3 position = measured();
    state_.moved = position - state_.pose.position;
    state_.velocity += (1 - std::exp(-2 * std::numbers::pi * kCutoff * since_valid_)) *
                       (state_.moved / since_valid_ - state_.velocity);
    state_.pose.position = position;
    since_valid_ = 0;
    return true;
  }
  bool connected() const noexcept override { return plugged_in; }
  void command(const spidar::Wrench &wrench) noexcept override {
    commanded_ = (wrench.force / kStep).array().round() * kStep;
    state_.realised.force = commanded_;
  }
  void calibrate() noexcept override {
    centre_ += state_.pose.position;
    state_.pose.position.setZero();
    state_.velocity.setZero();
    state_.moved.setZero();
  }
  const spidar::DeviceState &state() const noexcept override { return state_; }
  const spidar::Vector3 &workspace_half() const noexcept override { return half_; }
  const spidar::DeviceLimits &limits() const noexcept override { return kArm; }
  std::string description() const override { return "a hand on an arm"; }

private:
  static constexpr double kStep = 12.0 / 8192; // N, of the D/A
  static constexpr double kCutoff = 35;        // Hz

  spidar::Vector3 measured() const noexcept {
    const double count = kArm.metres_per_count;
    return (position() / count).array().round() * count - centre_.array();
  }

  // A hand weighs and damps with the lightest grip on strings; the arm has more of both.
  void advance(double elapsed) noexcept {
    in_steps(elapsed, [this](double dt) {
      const spidar::Vector3 before = position();
      move(dt, force_, kArm.mass - kSpidar.mass, kArm.physical_damping - kSpidar.physical_damping);
      work_ += force_.dot(position() - before);
    });
  }

  double period_; // s, before the first exchange
  spidar::DeviceState state_;
  spidar::Vector3 half_ = spidar::Vector3::Constant(0.025); // m
  spidar::Vector3 centre_ = spidar::Vector3::Zero();        // m
  spidar::Vector3 commanded_ = spidar::Vector3::Zero();     // N
  spidar::Vector3 force_ = spidar::Vector3::Zero();         // N, that acts
  std::optional<std::int64_t> now_;                         // ns
  double since_valid_ = 0;                                  // s
  bool intervened_ = false;                                 // not told yet
};

} // namespace test
