// SPDX-License-Identifier: LGPL-2.1-or-later
// Hands that a held thing carries through the whole loop. How well, and how calm, is in the table
// of the closed loop (closed-loop-test.cpp); here is what happens around it.
#include "counted-allocations.hpp"
#include "loop-in-hand.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace carried_hand_test {

using haptic::HoldLaw;
using haptic::HoldState;
using spidar::Vector3;
using test::LoopInHand;

constexpr double kAway = 0.004; // m: 1 N and more

class CarriedHand : public ::testing::TestWithParam<const char *> {};
INSTANTIATE_TEST_SUITE_P(Devices, CarriedHand,
                         testing::Values(spidar::kDefaultGeometry, test::kArmName),
                         [](const auto &of) {
                           return of.param == std::string(test::kArmName) ? "arm" : "strings";
                         });

// N a tick: 1 N over the 0.05 s in which a spring ends, the fastest ramp; a stronger damper takes a
// thing's speed up in larger steps.
double smooth() {
  const bool on_arm = CarriedHand::GetParam() == std::string(test::kArmName);
  return 0.02 * (on_arm ? test::kArm : test::kSpidar).damping / test::kSpidar.damping;
}

LoopInHand::Setup setup_of(HoldLaw law) {
  LoopInHand::Setup setup{.geometry = CarriedHand::GetParam()};
  setup.settings.hold_law = law;
  setup.settings.continuous_force = 0;
  return setup;
}

class Carried : public LoopInHand {
public:
  explicit Carried(HoldLaw law = HoldLaw::carry) : LoopInHand(setup_of(law)) {
    hand().leads = true;
    thing = [this](double) { return place; };
    wait(0.3);
  }
  // A hand that is led away from the thing, which pulls it back.
  void lead_away() {
    lead({kAway, 0, 0}, 0.02);
    wait(0.1);
  }
  double stiffness() const { return loop.statistics().carry_stiffness; }
  // A slew rate that would hide no step of the law.
  void let_law_alone() {
    settings.slew_rate = 1000; // N/s
    set();
  }
  // The largest change of the force in a tick from now on for so long, N, that makes it stronger.
  double largest_step(double seconds) {
    double most = 0;
    for (const double end = time() + seconds; time() < end;) {
      const Vector3 before = force();
      tick();
      if (force().norm() > before.norm())
        most = std::max(most, (force() - before).norm());
    }
    return most;
  }
  double ms_to_zero() {
    const double begin = time();
    while (!force().isZero(0) && time() < begin + 5)
      tick();
    return 1e3 * (time() - begin);
  }

  Vector3 place = Vector3::Zero(); // m, of the thing
};

TEST_P(CarriedHand, IsPulledToWhereTheThingIsNow) {
  Carried held;
  EXPECT_LT(held.force().norm(), 0.01); // anchored where it was taken
  held.lead_away();
  EXPECT_LT(held.force().x(), -0.8);
  held.place = {kAway, 0, 0};
  held.wait(0.5);
  EXPECT_NEAR(held.force().norm(), 0, 0.1);
}

TEST_P(CarriedHand, WithoutAPressOrWithoutTheLawEverythingIsAsBefore) {
  const auto trace = [](HoldLaw law, bool pressed) {
    LoopInHand held(setup_of(law));
    held.film = {100, 40, 0};
    held.hand().leads = true;
    held.hand().goal = {0.01, 0, 0};
    held.hand().speed = 0.05;
    if (pressed)
      held.thing = [](double time) { return Vector3(0.01 * time, 0, 0); };
    std::vector<Vector3> forces;
    for (int i = 0; i < 500; ++i) {
      held.tick();
      forces.push_back(held.force());
    }
    return forces;
  };
  const auto usual = trace(HoldLaw::motion, false);
  EXPECT_GT(usual.back().norm(), 0.4);
  EXPECT_EQ(trace(HoldLaw::motion, true), usual);
  EXPECT_EQ(trace(HoldLaw::carry, false), usual);
  EXPECT_EQ(trace(HoldLaw::both, false), usual);
}

TEST_P(CarriedHand, FeelsTheSpringInsteadOfTheMotionOrBoth) {
  const auto force_of = [](HoldLaw law) {
    Carried held(law);
    held.film.y() = 100; // downwards, while the thing that is held stays
    held.lead_away();
    held.wait(0.5);
    return held.force();
  };
  const Vector3 carry = force_of(HoldLaw::carry);
  EXPECT_LT(carry.x(), -0.8);
  EXPECT_NEAR(carry.y(), 0, 0.05);
  const Vector3 both = force_of(HoldLaw::both);
  EXPECT_LT(both.x(), -0.6);
  EXPECT_LT(both.y(), -0.3);
  EXPECT_LE(both.norm(), 1 + 1e-9); // one max-force for the sum
}

TEST_P(CarriedHand, WhereItCannotBeToldWhichThingItIsTheMotionIsFelt) {
  Carried held;
  held.lead_away();
  held.hold = HoldState::about;
  held.film.y() = 100;
  held.wait(1);
  LoopInHand usual(setup_of(HoldLaw::motion));
  usual.film.y() = 100;
  usual.wait(1);
  EXPECT_NEAR(held.force().x(), 0, 1e-3);
  EXPECT_NEAR(held.force().y(), usual.force().y(), 1e-3);
  EXPECT_EQ(held.stiffness(), 0);
}

TEST_P(CarriedHand, IsFreeWithinATenthOfASecondWhenTheThingIsLetGo) {
  for (const HoldState state :
       {HoldState::none, HoldState::about, HoldState::lost, HoldState::refused}) {
    Carried held;
    held.lead_away();
    ASSERT_GT(held.force().norm(), 0.8);
    held.hold = state;
    EXPECT_LE(held.ms_to_zero(), 100);
    EXPECT_EQ(held.stiffness(), 0);
  }
}

TEST_P(CarriedHand, FeelsAHiddenThingFadeAndComeBackWithoutAStep) {
  Carried held;
  held.lead_away();
  held.hold = HoldState::hidden;
  held.confidence = 0;
  held.wait(0.12);
  EXPECT_GT(held.force().norm(), 0.3);
  EXPECT_LT(held.force().norm(), 0.9);
  held.wait(0.3);
  EXPECT_TRUE(held.force().isZero(0));
  held.hold = HoldState::held;
  held.confidence = 1;
  held.let_law_alone();
  EXPECT_LE(held.largest_step(1), smooth());
  EXPECT_NEAR(held.force().norm(), 0, 0.05); // it begins anew where the hand is
  held.lead({0, 0, 0}, 0.02);
  EXPECT_GT(held.force().x(), 0.5);
}

TEST_P(CarriedHand, FeelsNoStepWhenTheThingIsFoundElsewhere) {
  Carried held;
  held.lead_away();
  const Vector3 before = held.force();
  held.let_law_alone();
  held.place = {0.02, -0.02, 0}; // across half of the frame, in a frame
  EXPECT_LE(held.largest_step(0.5), smooth());
  EXPECT_LE((held.force() - before).norm(), 0.5); // nor does it drag the hand there
}

TEST_P(CarriedHand, FeelsNoBlowsWhenTheStateChangesWithEachFrame) {
  for (const HoldState state : {HoldState::none, HoldState::about, HoldState::hidden}) {
    Carried held;
    held.lead_away();
    held.let_law_alone();
    double step = 0;
    for (int frame = 0; frame < 60; ++frame) {
      held.hold = frame % 2 ? state : HoldState::held;
      held.confidence = frame % 2 && state == HoldState::hidden ? 0 : 1;
      step = std::max(step, held.largest_step(0.033));
    }
    EXPECT_LE(step, smooth());
  }
}

TEST_P(CarriedHand, IsHeldAsFirmlyAsBeforeSomeSecondsAfterALateTick) {
  for (const auto &[late, seconds] : {std::pair{9.0, 15}, {1000.0, 45}}) { // ms
    Carried hand;
    hand.lead_away();
    const double before = hand.stiffness();
    hand.tick(late);
    EXPECT_LT(hand.largest_step(seconds), smooth());
    EXPECT_GT(hand.stiffness(), 0.9 * before) << late << " ms";
  }
}

// The frames in which the thing before was let go were lost.
TEST_P(CarriedHand, IsNotPulledToAThingThatIsNoLongerTheOne) {
  Carried hand;
  hand.lead_away();
  EXPECT_GT(hand.force().norm(), 0.5);
  hand.take_anew();
  EXPECT_LT(hand.largest_step(0.5), smooth());
  EXPECT_LT(hand.force().norm(), 0.05);
  EXPECT_GT(hand.stiffness(), 0) << "the other one carries";
}

TEST_P(CarriedHand, IsFreeWhenTheSenderDies) {
  Carried held;
  held.lead_away();
  held.frame = 1000'000 * LoopInHand::kMs; // no sample comes any more
  EXPECT_LE(held.ms_to_zero(), 300);       // stale after three intervals, then 100 ms
  EXPECT_TRUE(held.loop.reasons() & haptic::kHoldStale);
  held.wait(0.1);
  EXPECT_EQ(held.stiffness(), 0);
}

// What was pulled when a hold began does not stand afterwards.
TEST_P(CarriedHand, BeginsAnewWhereItIsAfterAHold) {
  for (const std::uint32_t hold :
       {haptic::kHoldPaused, haptic::kHoldReleased, haptic::kHoldEnded, haptic::kHoldFlushing}) {
    SCOPED_TRACE(haptic::names_of_holds(hold));
    Carried held;
    held.lead_away();
    held.loop.hold(hold);
    EXPECT_LE(held.ms_to_zero(), 101);
    held.wait(0.1);
    EXPECT_EQ(held.stiffness(), 0);
    held.loop.unhold(hold);
    held.wait(1);
    EXPECT_GT(held.stiffness(), 0);
    EXPECT_LT(held.force().norm(), 0.05);
  }
}

TEST_P(CarriedHand, IsNotThrownByCalibrate) {
  Carried held;
  held.lead_away();
  const double before = held.force().norm();
  held.loop.calibrate();
  for (const double end = held.time() + 0.5; held.time() < end;) {
    held.tick();
    ASSERT_LE(held.force().norm(), before + 0.02);
  }
  EXPECT_LT(held.force().norm(), 0.05);
}

TEST_P(CarriedHand, APlaceThatIsNotFiniteSilencesAndLeavesNothing) {
  Carried held;
  held.lead_away();
  const Vector3 place =
      std::exchange(held.place, Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
  bool silent = false;
  for (int ms = 0; ms < 40; ++ms) {
    held.tick();
    ASSERT_TRUE(held.force().allFinite());
    silent = silent || held.force().isZero(0);
  }
  EXPECT_TRUE(silent);
  held.place = place;
  held.wait(1);
  EXPECT_TRUE(held.force().allFinite());
  EXPECT_GT(held.stiffness(), 0);
}

TEST_P(CarriedHand, TakesNothingFromTheHeap) {
  Carried held;
  held.lead_away();
  const long before = test::allocations;
  for (int i = 0; i < 200; ++i)
    held.tick();
  EXPECT_EQ(test::allocations, before);
}

} // namespace carried_hand_test
