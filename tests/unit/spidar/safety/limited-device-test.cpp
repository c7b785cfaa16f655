// SPDX-License-Identifier: LGPL-2.1-or-later
// The door for programs that command a device themselves: what it lets through, and what it says.
#include "device-limits.hpp"
#include "safety/safety-chain.hpp"
#include "spidar/limited-device.hpp"
#include "spidar/spidar.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <spidar/device.hpp>
#include <spidar/error.hpp>
#include <spidar/simulator.hpp>

namespace limited_device_test {

using spidar::DeviceState;
using spidar::LimitedDevice;
using spidar::Vector3;
using spidar::Wrench;

constexpr std::int64_t kTick = 1'000'000; // ns

Wrench push(double x) {
  return {.force = {x, 0, 0}};
}

/// A grip that does what the test says.
class Grip final : public spidar::HapticDevice {
public:
  Grip() { now.valid = true; }
  bool exchange(std::int64_t) noexcept override {
    sent = next;
    return answers;
  }
  bool connected() const noexcept override { return is_connected; }
  void command(const Wrench &wrench) noexcept override { next = wrench; }
  void rest() noexcept override { next.reset(); }
  void calibrate() noexcept override {}
  const DeviceState &state() const noexcept override { return now; }
  const Vector3 &workspace_half() const noexcept override { return half_; }
  const spidar::DeviceLimits &limits() const noexcept override { return test::kSpidar; }
  void limit_side_torque(double limit) noexcept override { side_torque = limit; }
  void let_rest(bool rests) noexcept override { is_at_rest = rests; }
  std::string description() const override { return "a grip"; }

  DeviceState now;
  std::optional<Wrench> sent; ///< none: minimum tension
  std::optional<Wrench> next;
  double side_torque = 0;
  bool is_at_rest = false;
  bool answers = true;
  bool is_connected = true;

private:
  Vector3 half_ = Vector3::Ones();
};

class Limited : public ::testing::Test {
protected:
  /// N, what was sent last.
  double after(int ticks, std::int64_t period = kTick) {
    for (int i = 0; i < ticks; ++i)
      device_.exchange(time_ += period);
    return grip_.sent ? grip_.sent->force.x() : 0;
  }

  Grip grip_;
  LimitedDevice device_{grip_};
  std::int64_t time_ = 0;
};

TEST_F(Limited, UntilTheFirstCommandTheDeviceIsLeftAsItIs) {
  after(100);
  EXPECT_FALSE(grip_.sent);
  EXPECT_EQ(device_.holds(), 0U);
  EXPECT_TRUE(device_.armed());
}

TEST_F(Limited, TheForceComesFromZeroAndStaysWithinItsLimit) {
  device_.command(push(3));
  double before = 0;
  for (int tick = 0; tick < 200; ++tick) {
    const double now = after(1);
    ASSERT_LE(now - before, 0.02 + 1e-12) << tick;
    before = now;
  }
  EXPECT_NEAR(before, 1, 1e-12);
  EXPECT_EQ(device_.limited_by(), unsigned{SPIDAR_LIMIT_FORCE});
  EXPECT_EQ(device_.wrench().force.x(), before);
  EXPECT_EQ(grip_.side_torque, 0.02);
  device_.set_limits({.force = 2, .continuous_force = 0});
  EXPECT_NEAR(after(200), 2, 1e-12);
}

TEST_F(Limited, LimitsOutOfRangeAreRefused) {
  for (const spidar::ForceLimits limits : {spidar::ForceLimits{.force = 5.1},
                                           {.torque = -0.01},
                                           {.continuous_force = 6},
                                           {.slew_rate = 0},
                                           {.damping = std::nan("")}})
    EXPECT_THROW(device_.set_limits(limits), spidar::Error);
  EXPECT_EQ(device_.limits().force, 1);
}

TEST_F(Limited, AGripThatIsLetGoIsLatchedUntilItIsArmed) {
  device_.command(push(0.5));
  ASSERT_NEAR(after(200), 0.5, 1e-12);
  grip_.now.velocity.x() = 1.1;
  EXPECT_EQ(after(60), 0);
  EXPECT_EQ(device_.holds(), unsigned{SPIDAR_HOLD_LET_GO});
  EXPECT_TRUE(grip_.is_at_rest);
  grip_.now.velocity.setZero();
  EXPECT_EQ(after(1000), 0);
  EXPECT_FALSE(device_.armed());
  device_.arm();
  EXPECT_LT(after(100), 0.2);
  EXPECT_NEAR(after(500), 0.5, 1e-12);
  EXPECT_EQ(device_.holds(), 0U);
}

TEST_F(Limited, AReleasedForceFadesIn50MillisecondsUntilItIsArmed) {
  device_.command(push(1));
  after(200);
  device_.release();
  EXPECT_FALSE(device_.armed());
  EXPECT_GT(after(25), 0.4);
  EXPECT_EQ(after(25), 0);
  EXPECT_EQ(device_.holds(), unsigned{SPIDAR_HOLD_RELEASED});
  device_.arm();
  EXPECT_NEAR(after(600), 1, 1e-12);
}

TEST_F(Limited, ThreeFailedExchangesInARowAreLatchedAndGiveMinimumTension) {
  device_.command(push(1));
  after(200);
  grip_.answers = false;
  after(2);
  grip_.answers = true;
  after(1);
  EXPECT_TRUE(device_.armed());
  grip_.answers = false;
  after(3);
  EXPECT_EQ(device_.holds() & SPIDAR_HOLD_FAULTED, unsigned{SPIDAR_HOLD_FAULTED});
  grip_.answers = true;
  after(1);
  EXPECT_FALSE(grip_.sent) << "minimum tension";
  device_.arm();
  EXPECT_NEAR(after(600), 1, 1e-12);
}

TEST_F(Limited, ADeviceThatIsGoneIsLatchedAtOnce) {
  device_.command(push(1));
  after(200);
  grip_.answers = grip_.is_connected = false;
  after(1);
  EXPECT_FALSE(device_.armed());
}

TEST_F(Limited, AnExchangeThatComes10MillisecondsLateBeginsFromZero) {
  device_.command(push(1));
  after(200);
  EXPECT_NEAR(after(1, 10 * kTick), 1, 1e-12);
  EXPECT_LT(after(1, 12 * kTick), 1);
  EXPECT_EQ(device_.holds(), unsigned{SPIDAR_HOLD_LATE});
  EXPECT_EQ(after(29), 0) << "50 ms later, and these 10 and 12 ms count";
  EXPECT_TRUE(device_.armed());
  EXPECT_NEAR(after(300), 1, 1e-12);
}

TEST(LimitedPeriod, BeyondThePatienceOfTheGuardianThereIsNoForceAndItSaysSo) {
  Grip grip;
  LimitedDevice device(grip, 0.02);
  device.command(push(1));
  for (int tick = 1; tick <= 100; ++tick) {
    device.exchange(tick * 20 * kTick);
    ASSERT_EQ(device.wrench().force.x(), 0) << tick;
    ASSERT_EQ(device.holds(), unsigned{SPIDAR_HOLD_LATE});
  }
}

TEST_F(Limited, WithoutAPoseTheForceFadesAndComesBackByItself) {
  device_.command(push(1));
  after(200);
  grip_.now.valid = false;
  EXPECT_EQ(after(50), 0);
  EXPECT_EQ(device_.holds(), unsigned{SPIDAR_HOLD_NO_POSE});
  grip_.now.valid = true;
  EXPECT_NEAR(after(300), 1, 1e-12);
}

TEST_F(Limited, WhatIsNotFiniteIsZeroOnTheSameExchange) {
  device_.command(push(1));
  after(200);
  device_.command(push(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(after(1), 0);
  EXPECT_EQ(device_.holds(), unsigned{SPIDAR_HOLD_NOT_FINITE});
  EXPECT_FALSE(grip_.is_at_rest) << "as under a command of zero";
  device_.command(push(1));
  EXPECT_LE(after(1), 0.02 + 1e-12);
}

TEST_F(Limited, AGuardianThatIntervenedMakesItBeginFromZero) {
  device_.command(push(1));
  after(200);
  grip_.now.interrupted = true;
  after(1);
  grip_.now.interrupted = false;
  EXPECT_LE(after(1), 0.02 + 1e-12);
}

TEST_F(Limited, EachPartIsSwitchedOffByItself) {
  device_.switch_off_safety(LimitedDevice::kSlew);
  device_.set_limits({.force = 5, .continuous_force = 0});
  device_.command(push(0));
  after(100); // no fade is left
  device_.command(push(4));
  EXPECT_NEAR(after(1), 4, 1e-12);
  device_.switch_off_safety(LimitedDevice::kLetGo);
  EXPECT_EQ(device_.switched_off(), LimitedDevice::kLetGo);
  grip_.now.velocity.x() = 2;
  after(100);
  EXPECT_TRUE(device_.armed());
  device_.switch_off_safety(0);
  after(1);
  EXPECT_FALSE(device_.armed());
}

TEST_F(Limited, TheWorkOnTheHandIsLimitedUnlessThatIsSwitchedOff) {
  device_.set_limits({.force = 5, .continuous_force = 0, .damping = 0});
  device_.command(push(5));
  const auto lead = [this](int ticks) { // at 0.5 m/s
    for (int i = 0; i < ticks; ++i) {
      grip_.now.acted = grip_.sent.value_or(Wrench{});
      grip_.now.moved.x() = 0.5e-3;
      after(1);
    }
    return grip_.sent->force.x() * 0.5; // W
  };
  EXPECT_LE(lead(3000), 0.3 + 0.01);
  EXPECT_EQ(device_.limited_by() & SPIDAR_LIMIT_WORK, unsigned{SPIDAR_LIMIT_WORK});
  device_.switch_off_safety(LimitedDevice::kWork);
  EXPECT_NEAR(lead(1000), 2.5, 1e-9);
}

TEST_F(Limited, WorkThatWasDoneWithoutItsLimitIsNoDebtLater) {
  device_.set_limits({.force = 5, .continuous_force = 0, .damping = 0});
  device_.switch_off_safety(LimitedDevice::kWork);
  device_.command(push(5));
  for (int i = 0; i < 10'000; ++i) { // 25 J
    grip_.now.acted = grip_.sent.value_or(Wrench{});
    grip_.now.moved.x() = 0.5e-3;
    after(1);
  }
  grip_.now.moved.setZero();
  device_.switch_off_safety(0);
  after(1000);
  EXPECT_NEAR(grip_.sent->force.x(), 5, 1e-9);
}

TEST_F(Limited, WithEverythingSwitchedOffALatchOfBeforeHoldsNothing) {
  device_.command(push(1));
  grip_.now.velocity.x() = 3;
  after(100);
  ASSERT_FALSE(device_.armed());
  device_.switch_off_safety(LimitedDevice::kAll);
  EXPECT_EQ(after(1), 1);
  EXPECT_TRUE(device_.armed());
}

TEST_F(Limited, WithEverythingSwitchedOffTheDeviceGetsTheCommandAsItIs) {
  device_.switch_off_safety(LimitedDevice::kAll);
  device_.command(push(7));
  grip_.now.velocity.x() = 3;
  EXPECT_EQ(after(1), 7);
  EXPECT_EQ(device_.holds(), 0U);
  EXPECT_EQ(device_.limited_by(), 0U);
  EXPECT_TRUE(device_.armed());
  device_.release();
  EXPECT_EQ(after(1), 0);
  EXPECT_EQ(device_.holds(), unsigned{SPIDAR_HOLD_RELEASED});
  EXPECT_FALSE(device_.armed());
  device_.arm();
  grip_.now.velocity.setZero();
  after(1);
  device_.switch_off_safety(0);
  EXPECT_LE(after(1), 0.02 + 1e-12) << "it begins from zero";
}

// What hapticsink sends for the same wish: its chain, stepped by what the device says.
TEST(LimitedSimulator, SendsWhatTheSafetyChainSays) {
  const spidar::Geometry geometry = spidar::load_geometry(spidar::kDefaultGeometry);
  spidar::Device simulated(
      std::make_unique<spidar::Simulator>(geometry, spidar::parse_hand_script("circle:0.8,0.25")),
      geometry);
  LimitedDevice device(simulated);
  device.set_limits({.force = 5});
  haptic::SafetyChain chain{simulated.limits()};
  for (std::int64_t tick = 1; tick <= 5000; ++tick) {
    const DeviceState &state = simulated.state();
    const Wrench wanted{5 * state.velocity.stableNormalized(), {0, 0, 0.01}};
    const Wrench expected = chain.step({.wanted = wanted,
                                        .measured = true,
                                        .trust = 1,
                                        .hand_velocity = state.velocity,
                                        .hand_turning = state.angular_velocity,
                                        .acted = state.acted,
                                        .moved = state.moved,
                                        .turned = state.turned,
                                        .max_force = 5,
                                        .continuous_force = 1,
                                        .max_torque = 0.02,
                                        .slew_rate = 20,
                                        .damping = 1,
                                        .dt = 0.001,
                                        .longest_dt = 0.001});
    device.command(wanted);
    device.exchange(tick * kTick);
    ASSERT_EQ(device.wrench().force, expected.force) << tick;
    ASSERT_EQ(device.wrench().torque, expected.torque) << tick;
  }
  EXPECT_TRUE(device.armed());
}

} // namespace limited_device_test
