// SPDX-License-Identifier: LGPL-2.1-or-later
// The loop driven by hand, so that a test takes no time and knows every tick.
#pragma once

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

// The simulated device behind a wire that can be cut, and whose grip can be thrown.
class Wire final : public spidar::Controller {
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
    ++exchanges;
    last_words = words;
    if (const std::int64_t held_up = stall.exchange(0))
      clock->sleep_until(clock->now() + held_up);
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

  bool cut = false;
  bool gone = false;     // for good
  bool let_go = false;   // the guardian has put the motors at rest, once
  std::int32_t slip = 0; // counts by which the first string has slipped
  haptic::LoopClock *clock = &haptic::machine_clock();
  std::atomic<std::int64_t> stall = 0; // ns, of `clock`; once
  double thrown_speed = 0;             // m/s to the right, from the centre
  int exchanges = 0;
  spidar::DacWords last_words{};

private:
  spidar::Geometry geometry_;
  spidar::Simulator simulator_;
  spidar::Pose thrown_;
  std::optional<std::int64_t> now_; // ns
  double dt_ = 0.001;               // s
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
    auto wire = std::make_unique<Wire>(hand);
    wire_ = wire.get();
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
  Wire *wire_ = nullptr;
  std::unique_ptr<spidar::Device> device_;
  HapticLoop loop_;
};

} // namespace test
