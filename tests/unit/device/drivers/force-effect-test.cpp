// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/force-effect.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace force_effect_test {

using haptic::force_effect;
using haptic::ForceKind;
using spidar::Vector3;

ff_effect constant(const Vector3 &force) {
  return force_effect(force, ForceKind::constant, true, 3);
}

TEST(ForceEffect, PullsWhereTheForcePoints) {
  EXPECT_EQ(constant({0, -1, 0}).direction, 0x0000); // as linux/input.h has them
  EXPECT_EQ(constant({-1, 0, 0}).direction, 0x4000);
  EXPECT_EQ(constant({0, 1, 0}).direction, 0x8000);
  EXPECT_EQ(constant({1, 0, 0}).direction, 0xC000);
  EXPECT_EQ(constant({1, 1, 0}).direction, 0xA000);
}

TEST(ForceEffect, FiveNewtonsAreTheFullLevelAndNothingExceedsIt) {
  EXPECT_EQ(constant({0, 0, 0}).u.constant.level, 0);
  EXPECT_NEAR(constant({0.6, 0.8, 0}).u.constant.level, 0x7fff / 5, 1);
  EXPECT_EQ(constant({5, 0, 0}).u.constant.level, 0x7fff);
  EXPECT_EQ(constant({3000, 4000, 0}).u.constant.level, 0x7fff);
}

TEST(ForceEffect, IsOverAfterATenthOfASecondUnlessToldToGoOn) {
  const ff_effect effect = constant({1, 0, 0});
  EXPECT_EQ(effect.replay.length, 100);
  EXPECT_EQ(effect.replay.delay, 0);
  EXPECT_EQ(effect.id, 3);
  EXPECT_EQ(effect.type, FF_CONSTANT);
}

TEST(ForceEffect, AWheelFeelsOnlyWhatGoesSideways) {
  const auto wheel = [](const Vector3 &force) {
    return force_effect(force, ForceKind::constant, false, 0);
  };
  EXPECT_EQ(wheel({0, 1, 0}).u.constant.level, 0);
  EXPECT_NEAR(wheel({-1, 1, 0}).u.constant.level, 0x7fff / 5, 1);
  EXPECT_EQ(wheel({-1, 1, 0}).direction, 0x4000);
}

TEST(ForceEffect, RumbleHasOnlyAStrength) {
  const ff_effect effect = force_effect({0, -2.5, 0}, ForceKind::rumble, true, -1);
  EXPECT_EQ(effect.type, FF_RUMBLE);
  EXPECT_NEAR(effect.u.rumble.strong_magnitude, 0xffff / 2, 1);
}

TEST(ForceEffect, WhatIsNotFiniteIsNoForce) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(haptic::is_silent(constant({bad, 0, 0})));
    EXPECT_TRUE(haptic::is_silent(constant({0, bad, 0})));
  }
}

TEST(ForceEffect, TheDriverIsToldOnlyWhatCanBeFelt) {
  const ff_effect effect = constant({1, 0, 0});
  EXPECT_TRUE(haptic::feels_alike(effect, constant({1.005, 0, 0})));
  EXPECT_TRUE(haptic::feels_alike(constant({0.001, -1, 0}), constant({-0.001, -1, 0})));
  EXPECT_FALSE(haptic::feels_alike(effect, constant({1.05, 0, 0})));
  EXPECT_FALSE(haptic::feels_alike(effect, constant({1, 0.05, 0})));
  EXPECT_FALSE(haptic::feels_alike(effect, constant({-1, 0, 0})));
  EXPECT_FALSE(haptic::feels_alike(constant({0, 0, 0}), constant({0.005, 0, 0})));
}

} // namespace force_effect_test
