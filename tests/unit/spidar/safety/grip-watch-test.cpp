// SPDX-License-Identifier: LGPL-2.1-or-later
#include "safety/grip-watch.hpp"

#include "device-limits.hpp"

#include <gtest/gtest.h>

namespace grip_watch_test {

using haptic::GripWatch;
using haptic::SafetyChain;

constexpr double kTick = 0.001; // s

class Grip final : public spidar::HapticDevice {
public:
  bool exchange(std::int64_t) noexcept override { return true; }
  bool connected() const noexcept override { return true; }
  void command(const spidar::Wrench &) noexcept override {}
  void calibrate() noexcept override {}
  const spidar::DeviceState &state() const noexcept override { return now; }
  const spidar::Vector3 &workspace_half() const noexcept override { return half_; }
  const spidar::DeviceLimits &limits() const noexcept override { return of_grip; }
  std::string description() const override { return "a grip"; }

  spidar::DeviceState now;
  spidar::DeviceLimits of_grip{.grip_is_free = true};

private:
  spidar::Vector3 half_ = spidar::Vector3::Ones();
};

class Watch : public ::testing::Test {
protected:
  void SetUp() override { grip_.now.valid = true; }
  void exert_force() {
    SafetyChain::Input input;
    input.wanted.force.x() = 1;
    input.measured = true;
    input.trust = 1;
    input.max_force = 1;
    input.slew_rate = 1000;
    input.dt = kTick;
    for (int i = 0; i < 200; ++i)
      chain_.step(input);
    ASSERT_FALSE(chain_.silent());
  }
  std::uint32_t holds(bool dead_man = false) {
    return watch_.holds(&grip_, chain_, dead_man, kTick);
  }

  Grip grip_;
  SafetyChain chain_{test::kSpidar};
  GripWatch watch_;
};

TEST_F(Watch, ADeadManHoldsUntilTheButtonIsPressed) {
  EXPECT_EQ(holds(true), haptic::kHoldDeadMan);
  EXPECT_EQ(watch_.holds(nullptr, chain_, true, kTick), haptic::kHoldDeadMan);
  grip_.now.pressed = true;
  EXPECT_EQ(holds(true), 0U);
}

TEST_F(Watch, AnUnknownPoseHoldsButNotWithoutAHand) {
  grip_.now.valid = false;
  EXPECT_EQ(holds(), haptic::kHoldNoPose);
  EXPECT_EQ(watch_.holds(nullptr, chain_, false, kTick), 0U);
}

TEST_F(Watch, AFastGripWasLetGoOnlyWithAForceOnIt) {
  grip_.now.velocity.x() = 1.1; // m/s
  EXPECT_EQ(holds(), 0U);
  exert_force();
  EXPECT_EQ(holds(), haptic::kHoldOverspeed);
  grip_.of_grip.let_go_speed = 1.2;
  EXPECT_EQ(holds(), 0U);
  grip_.of_grip = {.grip_is_free = false};
  EXPECT_EQ(holds(), 0U);
}

TEST_F(Watch, AWhirlingGripWasLetGoAfterFiveTicks) {
  exert_force();
  grip_.now.angular_velocity.z() = 11; // rad/s
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(holds(), 0U);
  EXPECT_EQ(holds(), haptic::kHoldOverspeed);
}

} // namespace grip_watch_test
