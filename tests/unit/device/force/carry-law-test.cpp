// SPDX-License-Identifier: LGPL-2.1-or-later
#include "force/carry-law.hpp"

#include "device-limits.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace carry_law_test {

using haptic::CarryLaw;
using haptic::HoldLaw;
using haptic::HoldState;
using haptic::SafetyChain;
using spidar::Vector3;

constexpr double kTick = 0.001; // s

class CarryLaws : public ::testing::TestWithParam<spidar::DeviceLimits> {
protected:
  // Two seconds of a thing that moves to the right, m/s, under a hand that stands or goes along.
  static CarryLaw carried(double speed, bool along = false) {
    CarryLaw law;
    Vector3 hand = Vector3::Zero();
    for (int i = 0; i < 2000; ++i) {
      const Vector3 moved(speed * kTick, 0, 0);
      if (along)
        hand += moved;
      law.step(HoldState::held, moved, hand, {.device = GetParam(), .energy = 1}, kTick);
    }
    return law;
  }
};
INSTANTIATE_TEST_SUITE_P(Devices, CarryLaws, testing::Values(test::kSpidar, test::kArm),
                         [](const auto &of) { return of.index == 0 ? "strings" : "arm"; });

// What becomes of a motion of 1 N that is certain.
SafetyChain::Input felt(const CarryLaw &law, HoldLaw choice = HoldLaw::carry) {
  SafetyChain::Input input;
  input.wanted.force = {1, 0, 0};
  input.measured = true;
  input.trust = 1;
  input.interval = 0.033;
  law.apply(choice, input);
  return input;
}

TEST_P(CarryLaws, AThingThatCarriesIsNotFeltAsMotion) {
  const SafetyChain::Input input = felt(carried(0.05));
  EXPECT_EQ(input.wanted.force.norm(), 0);
  EXPECT_GT(input.touch.force.x(), 0.5);
}

TEST_P(CarryLaws, ButBothAre) {
  EXPECT_EQ(felt(carried(0.05), HoldLaw::both).wanted.force.norm(), 1);
}

TEST_P(CarryLaws, WhatIsTooFastToCarryIsFeltAsMotion) {
  const SafetyChain::Input input = felt(carried(0.25));
  EXPECT_EQ(input.wanted.force.norm(), 1);
  EXPECT_EQ(input.touch.force.norm(), 0);
}

TEST_P(CarryLaws, WhatHardlyCarriesIsFeltAsMotionForTheRest) {
  for (const double speed : {0.11, 0.15, 0.19, 0.199}) {
    const double follows = 2 - speed / CarryLaw::kFastestThing;
    EXPECT_NEAR(felt(carried(speed)).wanted.force.norm(), 1 - follows, 1e-6) << speed;
  }
}

TEST_P(CarryLaws, ANumberThatIsNotFiniteEndsIt) {
  CarryLaw law = carried(0.05);
  law.step(HoldState::held, {std::numeric_limits<double>::quiet_NaN(), 0, 0}, Vector3::Zero(),
           {.device = GetParam()}, kTick);
  EXPECT_EQ(law.stiffness(), 0);
  EXPECT_EQ(felt(law).touch.force.norm(), 0);
  EXPECT_EQ(felt(law).wanted.force.norm(), 1);
}

TEST_P(CarryLaws, WithoutAForceTheSpringHasNone) {
  CarryLaw law;
  for (int i = 0; i < 200; ++i)
    law.step(HoldState::held, {0.0001, 0, 0}, Vector3::Zero(),
             {.device = GetParam(), .max_force = 0}, kTick);
  EXPECT_NEAR(felt(law).touch.force.x(), law.damping() * 0.1, 1e-9); // which the chain clamps
}

} // namespace carry_law_test
