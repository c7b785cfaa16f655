// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/evdev-device.hpp"

#include "drivers/evdev-list.hpp"
#include "eventually.hpp"
#include "virtual-joystick.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <gtest/gtest.h>
#include <spidar/error.hpp>
#include <sys/wait.h>

namespace evdev_device_test {

using namespace std::chrono_literals;
using haptic::open_evdev;
using spidar::Cause;
using test::eventually;
using test::VirtualJoystick;
using Told = VirtualJoystick::Told;

class Evdev : public ::testing::Test {
protected:
  void SetUp() override {
    if (!VirtualJoystick::possible())
      GTEST_SKIP()
          << "needs /dev/uinput; tests/hil/joystick-test.sh runs this in a virtual machine";
  }

  static void ticks(spidar::HapticDevice &device, const spidar::Vector3 &force, int ms) {
    for (int i = 0; i < ms; ++i, std::this_thread::sleep_for(1ms)) {
      device.command({.force = force});
      device.exchange(spidar::monotonic_time());
    }
  }
  static spidar::Error refusal(const std::string &path) {
    try {
      open_evdev(path);
    } catch (const spidar::Error &error) {
      return error;
    }
    ADD_FAILURE() << "opened";
    return {Cause::io, ""};
  }
  static void expect_words(const spidar::Error &error, Cause cause, const std::string &words) {
    EXPECT_EQ(error.cause(), cause) << error.what();
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
  static std::size_t count(const VirtualJoystick &stick, int what) {
    const auto told = stick.told();
    return static_cast<std::size_t>(
        std::ranges::count_if(told, [&](const Told &t) { return t.what == what; }));
  }
  /// Uploads of the same force as the one before.
  static int repeated_uploads(const VirtualJoystick &stick) {
    const Told *before = nullptr;
    int repeated = 0;
    const auto told = stick.told();
    for (const Told &t : told) {
      if (t.what != Told::upload)
        continue;
      repeated += before && before->effect.u.constant.level == t.effect.u.constant.level &&
                  before->effect.direction == t.effect.direction;
      before = &t;
    }
    return repeated;
  }
  static bool plays_at_the_end(const VirtualJoystick &stick) {
    bool plays = false;
    for (const Told &t : stick.told())
      plays = t.what == Told::play || (t.what == Told::upload && plays);
    return plays;
  }
};

TEST_F(Evdev, TheStickIsThePointer) {
  VirtualJoystick stick;
  const auto device = open_evdev(stick.path());
  EXPECT_TRUE(device->state().valid);
  EXPECT_FALSE(device->limits().knows_newtons());
  EXPECT_EQ(device->state().pose.position.norm(), 0);
  stick.move(0.5, 1); // right and towards the user, which is down on the screen
  ASSERT_TRUE(eventually([&] {
    device->exchange(spidar::monotonic_time());
    return device->state().pose.position.y() < -0.9 * device->workspace_half().y();
  }));
  EXPECT_NEAR(device->state().pose.position.x(), 0.5 * device->workspace_half().x(), 1e-6);
  EXPECT_EQ(device->state().pose.position.z(), 0);
  device->calibrate();
  device->exchange(spidar::monotonic_time());
  EXPECT_NEAR(device->state().pose.position.norm(), 0, 1e-9);
}

TEST_F(Evdev, AButtonOfTheStickIsPressedUntilItIsReleased) {
  VirtualJoystick stick;
  const auto device = open_evdev(stick.path(), true); // which it has
  EXPECT_FALSE(device->state().pressed);
  for (const bool pressed : {true, false, true}) {
    stick.press(pressed);
    EXPECT_TRUE(eventually([&] {
      device->exchange(spidar::monotonic_time());
      return device->state().pressed == pressed;
    }));
  }
}

TEST_F(Evdev, AForceIsPlayedInItsDirectionAndKeptAliveButSoonOverByItself) {
  VirtualJoystick stick;
  const auto device = open_evdev(stick.path());
  ticks(*device, {1, 0, 0}, 500);
  ff_effect last{};
  for (const Told &t : stick.told())
    if (t.what == Told::upload)
      last = t.effect;
  EXPECT_EQ(last.type, FF_CONSTANT);
  EXPECT_EQ(last.direction, 0xC000);
  EXPECT_NEAR(last.u.constant.level, 0x7fff / 5, 1);
  EXPECT_EQ(last.replay.length, 100);
  EXPECT_GE(count(stick, Told::play), 5U); // in half a second of effects of a tenth
  EXPECT_EQ(repeated_uploads(stick), 0); // where the loop stands still, it is taken off between two
  ticks(*device, {0, 0, 0}, 100);
  EXPECT_FALSE(plays_at_the_end(stick));
}

TEST_F(Evdev, AForceThatChangesAllTheTimeIsToldNoMoreOftenThanDriversCanBear) {
  VirtualJoystick stick;
  const auto device = open_evdev(stick.path());
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 500; ++i)
    ticks(*device, {std::sin(0.1 * i), std::cos(0.1 * i), 0}, 1);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(static_cast<double>(count(stick, Told::upload)), 130 * seconds.count() + 2);
  EXPECT_GE(count(stick, Told::upload), 10U);
}

TEST_F(Evdev, WhenTheLoopStandsStillTheForceIsTakenOff) {
  VirtualJoystick stick;
  const auto device = open_evdev(stick.path());
  ASSERT_TRUE(eventually([&] {
    ticks(*device, {1, 1, 0}, 1);
    return plays_at_the_end(stick);
  }));
  EXPECT_TRUE(eventually([&] { return !plays_at_the_end(stick); }));
  EXPECT_TRUE(device->exchange(spidar::monotonic_time()));
}

TEST_F(Evdev, ClosedItLeavesNoEffectBehind) {
  VirtualJoystick stick;
  auto device = open_evdev(stick.path());
  ticks(*device, {1, 0, 0}, 100);
  device.reset();
  EXPECT_FALSE(plays_at_the_end(stick));
  EXPECT_EQ(count(stick, Told::erase), 1U);
}

// Run by the tests below in a process of its own.
TEST_F(Evdev, DISABLED_Child) {
  const auto device = open_evdev(std::getenv("STICK"));
  ticks(*device, {1, 0, 0}, 20'000);
}

class EvdevChild : public Evdev {
protected:
  void start(const VirtualJoystick &stick) {
    setenv("STICK", stick.path().c_str(), 1);
    child_ = fork();
    if (child_ == 0) {
      execl("/proc/self/exe", "child", "--gtest_filter=Evdev.DISABLED_Child",
            "--gtest_also_run_disabled_tests", nullptr);
      _exit(1);
    }
    ASSERT_TRUE(eventually([&] { return plays_at_the_end(stick); }));
  }
  void TearDown() override {
    if (child_ > 0) {
      kill(child_, SIGKILL);
      waitpid(child_, nullptr, 0);
    }
  }
  pid_t child_ = 0;
};

TEST_F(EvdevChild, TheForceOfAKilledProgramIsErased) {
  VirtualJoystick stick;
  start(stick);
  kill(child_, SIGKILL);
  EXPECT_TRUE(eventually([&] { return count(stick, Told::erase) == 1; }));
}

TEST_F(EvdevChild, TheForceOfAStoppedProgramIsNotPlayedAgain) {
  VirtualJoystick stick;
  start(stick);
  kill(child_, SIGSTOP);
  std::this_thread::sleep_for(100ms);
  stick.take_told();
  std::this_thread::sleep_for(300ms);
  EXPECT_EQ(count(stick, Told::play), 0U);
}

TEST_F(Evdev, UnpluggedItIsGoneAndCanBeOpenedAgainOnceItIsBack) {
  auto stick = std::make_unique<VirtualJoystick>();
  auto device = open_evdev(stick->path());
  ticks(*device, {1, 0, 0}, 100);
  stick.reset();
  EXPECT_TRUE(eventually(
      [&] { return !device->exchange(spidar::monotonic_time()) && !device->connected(); }));
  EXPECT_FALSE(device->state().valid);
  device.reset();
  EXPECT_EQ(refusal("").cause(), Cause::not_found);
  stick = std::make_unique<VirtualJoystick>();
  EXPECT_TRUE(open_evdev("")->exchange(spidar::monotonic_time()));
}

TEST_F(Evdev, TheFirstWithForceFeedbackIsTaken) {
  VirtualJoystick none(VirtualJoystick::Force::none, "Plain stick");
  expect_words(refusal(""), Cause::not_found, "Plain stick");
  VirtualJoystick stick;
  EXPECT_NE(open_evdev("")->description().find("Test stick"), std::string::npos);
  const auto units = haptic::list_evdev();
  ASSERT_EQ(units.with_force.size(), 1U);
  EXPECT_EQ(units.with_force[0].path, stick.path());
}

TEST_F(Evdev, RumbleIsTheLastResort) {
  VirtualJoystick stick(VirtualJoystick::Force::rumble);
  const auto device = open_evdev(stick.path());
  ticks(*device, {0, 2.5, 0}, 100);
  const auto told = stick.told();
  EXPECT_TRUE(std::ranges::any_of(told, [](const Told &t) {
    return t.what == Told::upload && t.effect.type == FF_RUMBLE &&
           t.effect.u.rumble.strong_magnitude > 0x7000;
  }));
}

TEST_F(Evdev, WhatCannotBeUsedIsRefusedInWords) {
  VirtualJoystick none(VirtualJoystick::Force::none, "Plain stick");
  expect_words(refusal(none.path()), Cause::argument, "Plain stick");
  expect_words(refusal(none.path()), Cause::argument, "no force feedback");
  VirtualJoystick stick;
  const auto device = open_evdev(stick.path());
  expect_words(refusal(stick.path()), Cause::busy, "Another program");
}

TEST_F(Evdev, WhatMayNotBeOpenedSaysHowToAllowIt) {
  VirtualJoystick stick;
  ASSERT_EQ(seteuid(65534), 0);
  const auto error = refusal(stick.path());
  ASSERT_EQ(seteuid(0), 0);
  expect_words(error, Cause::permission, "usermod -aG input");
}

} // namespace evdev_device_test
