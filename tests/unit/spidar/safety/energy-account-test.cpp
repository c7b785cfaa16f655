// SPDX-License-Identifier: LGPL-2.1-or-later
#include "safety/energy-account.hpp"

#include <gtest/gtest.h>
#include <spidar/device-limits.hpp>

namespace energy_account_test {

using haptic::EnergyAccount;
using spidar::Vector3;

constexpr double kTick = 0.001; // s
constexpr double kDelay = spidar::DeviceLimits{}.delay;

// A force of the hand's part, up, on a grip that moves up by so many mm.
EnergyAccount::Charge pushed(double force, double moved) {
  return {.acted = {.force = {0, 0, force}},
          .by_hand = true,
          .moved = {0, 0, 1e-3 * moved},
          .most = 1,
          .time = kTick};
}

EnergyAccount::Motion going(double speed) {
  return {.velocity = {0, 0, speed}, .time = kTick, .delay = kDelay * kTick};
}

double affordable(const EnergyAccount &account, double force, const EnergyAccount::Motion &hand) {
  return account.affordable({0, 0, force}, hand).z();
}

TEST(EnergyAccount, TheHandHasBackWhatItHasPutIn) {
  EnergyAccount account;
  account.charge(pushed(1, -3));
  EXPECT_DOUBLE_EQ(account.of_hand(), 3e-3);
  account.charge(pushed(1, 2));
  EXPECT_DOUBLE_EQ(account.of_hand(), 1e-3);
  EXPECT_EQ(affordable(account, 1, going(0.01)), 1);
  account.charge(pushed(1, 1));
  EXPECT_EQ(affordable(account, 1, going(0.01)), 0) << "nothing is left";
}

TEST(EnergyAccount, WhatTheFilmDoesIsNotTheHands) {
  EnergyAccount account;
  EnergyAccount::Charge charge = pushed(3, 1);
  charge.film.force.z() = 3;
  account.charge(charge);
  EXPECT_DOUBLE_EQ(account.of_hand(), 0);
}

TEST(EnergyAccount, ASurfaceThatMovesPaysForTheHand) {
  EnergyAccount account;
  EnergyAccount::Charge charge = pushed(0, 0);
  charge.surface_work = 2e-3;
  account.charge(charge);
  EXPECT_DOUBLE_EQ(account.of_hand(), 2e-3);
}

TEST(EnergyAccount, AThingThatCarriesPaysByItsOwnWayAndTakesBackWhatItComesBack) {
  EnergyAccount account;
  EnergyAccount::Charge charge = pushed(2, 0);
  charge.carried.z() = 1e-3;
  account.charge(charge);
  EXPECT_DOUBLE_EQ(account.of_hand(), 2e-3);
  charge.carried.z() = -1.5e-3;
  account.charge(charge);
  EXPECT_DOUBLE_EQ(account.of_hand(), -1e-3);
}

TEST(EnergyAccount, WhatCountsHideOfAThingsWorkPaysADebtAlone) {
  EnergyAccount account;
  EnergyAccount::Charge charge = pushed(2, 0);
  charge.carried.z() = -1e-3;
  account.charge(charge);
  EnergyAccount::Charge hidden = pushed(0, 0);
  hidden.hidden_work = 1.5e-3;
  account.charge(hidden);
  EXPECT_DOUBLE_EQ(account.of_hand(), -5e-4);
  account.charge(hidden);
  EXPECT_DOUBLE_EQ(account.of_hand(), 0);
}

TEST(EnergyAccount, APushTakesNoMoreThanItIsLent) {
  EnergyAccount account;
  EnergyAccount::Motion out = going(0.01);
  EXPECT_EQ(affordable(account, 1, out), 0);
  out.lent = 1e-3;
  EXPECT_EQ(affordable(account, 1, out), 1);
  account.charge(pushed(1, 1));
  EXPECT_EQ(affordable(account, 1, out), 0) << "nothing is left of it";
}

TEST(EnergyAccount, KeepsNoMoreThanTheTouchCanHoldAndForgetsNoDebt) {
  EnergyAccount account;
  EnergyAccount::Charge charge = pushed(1, -3);
  charge.most = 1e-3;
  account.charge(charge);
  EXPECT_DOUBLE_EQ(account.of_hand(), 1e-3);
  charge = pushed(1, 4);
  charge.most = 0;
  account.charge(charge);
  EXPECT_DOUBLE_EQ(account.of_hand(), -3e-3);
}

TEST(EnergyAccount, ADebtIsPaidByAHandThatPressesIn) {
  EnergyAccount account;
  account.charge(pushed(1, 1));
  EnergyAccount::Motion in = going(-0.01);
  in.credit = 5e-5;
  EXPECT_EQ(affordable(account, 1, in), 1);
  EXPECT_EQ(affordable(account, 1, going(0.01)), 0);
}

TEST(EnergyAccount, PaysInAdvanceUntilTheCommandHasActed) {
  EnergyAccount account;
  account.charge(pushed(1, -1)); // 1 mJ
  EXPECT_DOUBLE_EQ(affordable(account, 1, going(0.16)), 1);
  EXPECT_DOUBLE_EQ(affordable(account, 1, going(0.8)), 0.225) << "a tick may be 10 ms late";
  EnergyAccount::Motion slow_ticks = going(0.1);
  slow_ticks.delay = kDelay * 0.008;
  EXPECT_DOUBLE_EQ(affordable(account, 1, slow_ticks), 0.5) << "1 mJ in 2.5 ticks of 8 ms";
}

TEST(EnergyAccount, WhatIsOnItsWayToTheDeviceIsPaidFirst) {
  EnergyAccount account;
  account.charge(pushed(1, -0.1)); // 0.1 mJ
  EnergyAccount::Motion out = going(0.05);
  out.takes = kTick;
  out.on_its_way.z() = 1; // 0.05 mJ
  EXPECT_DOUBLE_EQ(affordable(account, 1, out), 0.05 / 0.075) << "what is left, in 1.5 ticks";
  out.on_its_way.z() = 2;
  EXPECT_NEAR(affordable(account, 1, out), 0, 1e-9);
  out.on_its_way.z() = -2;
  EXPECT_DOUBLE_EQ(affordable(account, 1, out), 1) << "what resists is not counted on";
}

// By a wrong pose 1 mJ in may be measured as 0.8 mJ out.
TEST(EnergyAccount, WhatWasPutInBeforeACalibrationIsNotAllGivenBack) {
  EnergyAccount account;
  account.charge(pushed(1, -1));
  account.calibrate();
  EXPECT_DOUBLE_EQ(account.of_hand(), 5e-4);
  account.charge(pushed(1, 1));
  account.calibrate();
  EXPECT_DOUBLE_EQ(account.of_hand(), -5e-4) << "a debt stays";
}

TEST(EnergyAccount, ByTheLastTickIfTheSpeedIsLate) {
  EnergyAccount account;
  account.charge(pushed(1, -1));
  EnergyAccount::Motion turned_round = going(0);
  turned_round.moved.z() = 0.8 * kTick;
  EXPECT_DOUBLE_EQ(affordable(account, 1, turned_round), 0.225);
}

TEST(EnergyAccount, AHandThatSlidesAlongPaysNothing) {
  EnergyAccount account;
  EXPECT_EQ(affordable(account, 1, {.velocity = {1, 0, 0}, .time = kTick, .delay = kDelay * kTick}),
            1);
}

} // namespace energy_account_test
