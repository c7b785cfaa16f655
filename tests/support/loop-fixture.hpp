// SPDX-License-Identifier: LGPL-2.1-or-later
// The loop driven by hand, so that a test takes no time and knows every tick.
#pragma once

#include "hand-on-arm.hpp"
#include "loop/haptic-loop.hpp"

#include <atomic>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <spidar/device.hpp>
#include <spidar/simulator.hpp>
#include <string>
#include <utility>

namespace test {

using haptic::HapticLoop;
using haptic::MotionSample;

constexpr std::int64_t kMs = 1'000'000; // ns

// What befalls a device.
struct Mishaps {
  bool cut = false;        // the wire
  bool gone = false;       // for good
  bool let_go = false;     // the guardian has put the motors at rest, once
  double thrown_speed = 0; // m/s to the right, from the centre
  bool is_led = false;     // the arm, whatever its force; the strings always are
  int exchanges = 0;       // so far
  haptic::LoopClock *clock = &haptic::machine_clock();
  std::atomic<std::int64_t> stall = 0; // ns, of `clock`; once

  void stay() noexcept {
    ++exchanges;
    if (const std::int64_t held_up = stall.exchange(0))
      clock->sleep_until(clock->now() + held_up);
  }
};

// The simulated device behind a wire that can be cut, and whose grip can be thrown.
class Wire final : public spidar::Controller, public Mishaps {
public:
  explicit Wire(const std::string &hand)
      : geometry_(spidar::load_geometry(spidar::kDefaultGeometry)),
        simulator_(geometry_, spidar::parse_hand_script(hand)) {}

  void set_time(std::int64_t now) noexcept override {
    dt_ = now_ ? static_cast<double>(now - *now_) * 1e-9 : 0.001;
    now_ = now;
    simulator_.set_time(now);
  }
  bool exchange(const spidar::DacWords &words, spidar::Counts &counts) noexcept override {
    stay();
    last_words = words;
    if (cut || gone)
      return false;
    if (thrown_speed == 0) {
      const bool answered = simulator_.exchange(words, counts);
      counts[0] += slip;
      return answered;
    }
    thrown_.position.x() += thrown_speed * dt_;
    const spidar::StringLengths change =
        string_lengths(geometry_, thrown_) - string_lengths(geometry_, {});
    home(counts);
    for (std::size_t i = 0; i < counts.size(); ++i)
      counts[i] += static_cast<std::int32_t>(
          std::lround(change[static_cast<Eigen::Index>(i)] / geometry_.metres_per_count[i]));
    return true;
  }
  bool home(spidar::Counts &counts) const noexcept override { return simulator_.home(counts); }
  bool connected() const noexcept override { return !gone; }
  bool interrupted() noexcept override { return std::exchange(let_go, false); }
  std::string description() const override { return "a wire"; }

  std::int32_t slip = 0; // counts by which the first string has slipped
  spidar::DacWords last_words{};

private:
  spidar::Geometry geometry_;
  spidar::Simulator simulator_;
  spidar::Pose thrown_;
  std::optional<std::int64_t> now_; // ns
  double dt_ = 0.001;               // s
};

// The arm behind such a wire, with the hand of the simulated device.
class ArmOnWire final : public spidar::HapticDevice, public Mishaps {
public:
  explicit ArmOnWire(const std::string &hand)
      : script_(spidar::parse_hand_script(hand)), arm_(held(), first_target(), 0.001) {}

  bool exchange(std::int64_t now) noexcept override {
    stay();
    arm_.answers = !cut;
    arm_.plugged_in = !gone;
    if (std::exchange(let_go, false))
      arm_.intervene();
    begun_ = begun_.value_or(now);
    const double time = static_cast<double>(now - *begun_) * 1e-9;
    const bool is_held = script_->target(time, arm_.workspace_half(), arm_.target);
    arm_.goal = arm_.target;
    arm_.hand = is_held ? held() : Hand{0.1, 0.5, 0};
    arm_.leads = is_led || thrown_speed != 0;
    if (thrown_speed != 0) {
      arm_.target = arm_.position();
      arm_.goal = {1, 0, 0};
      arm_.speed = thrown_speed;
    }
    return arm_.exchange(now);
  }
  bool connected() const noexcept override { return !gone; }
  void command(const spidar::Wrench &wrench) noexcept override { arm_.command(wrench); }
  void calibrate() noexcept override { arm_.calibrate(); }
  const spidar::DeviceState &state() const noexcept override { return arm_.state(); }
  const spidar::Vector3 &workspace_half() const noexcept override { return arm_.workspace_half(); }
  const spidar::DeviceLimits &limits() const noexcept override { return arm_.limits(); }
  std::string description() const override { return "an arm on a wire"; }

private:
  static Hand held() { return {0.4, 40, 1000}; }
  spidar::Vector3 first_target() const {
    spidar::Vector3 target = spidar::Vector3::Zero();
    script_->target(0, spidar::Vector3::Constant(0.025), target);
    return target;
  }

  std::unique_ptr<spidar::HandScript> script_;
  HandOnArm arm_;
  std::optional<std::int64_t> begun_; // ns
};

inline MotionSample moving(float vx, float vy) {
  MotionSample sample;
  sample.velocity_x = vx;
  sample.velocity_y = vy;
  sample.confidence = 1;
  sample.interval = 33 * kMs;
  sample.frame_width = 352;
  sample.frame_height = 288;
  return sample;
}

// Drives the ticks by hand, so that a test takes no time and knows every tick.
class Loop : public ::testing::Test {
protected:
  void make_device(const std::string &hand = "hold:0,0,0") {
    if (on_arm_) {
      auto arm = std::make_unique<ArmOnWire>(hand);
      mishaps_ = arm.get();
      device_ = std::move(arm);
      return;
    }
    auto wire = std::make_unique<Wire>(hand);
    mishaps_ = wire_ = wire.get();
    device_ = std::make_unique<spidar::Device>(std::move(wire),
                                               spidar::load_geometry(spidar::kDefaultGeometry));
  }
  void open(const std::string &hand = "hold:0,0,0") {
    make_device(hand);
    loop_.prepare({.device = device_.get()});
    loop_.unhold(haptic::kHoldClosed);
  }
  void play() { loop_.unhold(haptic::kHoldPaused); }

  void ticks(int n, std::int64_t lateness = 0) {
    for (int i = 0; i < n; ++i) {
      now_ += kMs;
      loop_.tick(now_ - lateness, now_);
    }
  }
  // A source of 100 samples/s for so long.
  void play_motion(float vx, float vy, int ms) {
    for (int i = 0; i < ms; i += 10) {
      loop_.submit(moving(vx, vy), now_);
      ticks(10);
    }
  }
  double force_max() const { return loop_.statistics().force_max; }
  bool is_held(std::uint32_t hold) const { return loop_.holds() & hold; }
  spidar::Vector3 realised() const { return device_->state().realised.force; }

  std::int64_t now_ = 1000 * kMs;
  bool on_arm_ = false;
  Mishaps *mishaps_ = nullptr; // of the device
  Wire *wire_ = nullptr;       // the same; null on the arm
  std::unique_ptr<spidar::HapticDevice> device_;
  HapticLoop loop_;
};

// The same on each device.
inline const char *const kLoopDevices[] = {"strings", "arm"};
template <typename Fixture>
class OnEachDevice : public Fixture, public ::testing::WithParamInterface<const char *> {
protected:
  OnEachDevice() { this->on_arm_ = this->GetParam() == std::string("arm"); }
  const spidar::DeviceLimits &limits() const { return this->on_arm_ ? kArm : kSpidar; }
};

} // namespace test
