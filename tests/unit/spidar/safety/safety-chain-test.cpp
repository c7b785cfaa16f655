// SPDX-License-Identifier: LGPL-2.1-or-later
#include "safety/safety-chain.hpp"

#include "device-limits.hpp"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <random>
#include <string>
#include <utility>

namespace safety_chain_test {

using haptic::EnergyAccount;
using haptic::SafetyChain;
using spidar::Vector3;

constexpr double kTick = 0.001; // s

SafetyChain::Input push(double fx, double fy = 0) {
  SafetyChain::Input input;
  input.wanted.force = {fx, fy, 0};
  input.measured = true;
  input.trust = 1;
  input.interval = 1.0 / 30;
  input.max_force = 1;
  input.max_torque = 0.02;
  input.slew_rate = 20;
  input.damping = 1;
  input.dt = kTick;
  return input;
}

Vector3 steps(SafetyChain &chain, const SafetyChain::Input &input, int n) {
  Vector3 force = Vector3::Zero();
  for (int i = 0; i < n; ++i)
    force = chain.step(input).force;
  return force;
}

SafetyChain settled(const SafetyChain::Input &input) {
  SafetyChain chain{test::kSpidar};
  steps(chain, input, 2000);
  return chain;
}

// A chain whose commands act on a hand that moves: from the step after the next one on.
class Acting {
public:
  const spidar::Wrench &step(SafetyChain::Input input) {
    input.acted = std::exchange(acting_, sent_);
    sent_ = chain.step(input);
    return sent_;
  }
  spidar::Wrench steps(const SafetyChain::Input &input, int n) {
    for (int i = 0; i < n; ++i)
      step(input);
    return sent_;
  }
  /// N and N·m, until the next step.
  const spidar::Wrench &acting() const { return acting_; }

  SafetyChain chain{test::kSpidar};

private:
  spidar::Wrench sent_;
  spidar::Wrench acting_;
};

// Steps until silent; the force must never grow on the way. s.
double time_to_silence(SafetyChain &chain, const SafetyChain::Input &input, double force) {
  for (int n = 1; n < 10'000; ++n) {
    const double now = chain.step(input).force.norm();
    EXPECT_LE(now, force) << "after " << n << " ms";
    force = now;
    if (chain.silent())
      return n * kTick;
  }
  return std::numeric_limits<double>::infinity();
}

SafetyChain::Input held(SafetyChain::Input input, std::uint32_t holds) {
  input.holds = holds;
  return input;
}

// A time on the page of hapticsink, ms: the first number of a cell, or 0 for "At once". Nothing if
// there is neither.
std::optional<int> time_on_page(const std::string &row, int column) {
  std::ifstream page(SOURCE_ROOT "/docs/elements/hapticsink.md");
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("| " + row))
      continue;
    std::size_t begin = 0;
    for (int i = 0; i <= column; ++i)
      begin = line.find('|', begin) + 1;
    const std::string cell = line.substr(begin, line.find('|', begin) - begin);
    const std::size_t digit = cell.find_first_of("0123456789");
    if (digit != std::string::npos)
      return std::atoi(cell.c_str() + digit);
    return cell.find("At once") != std::string::npos ? std::optional(0) : std::nullopt;
  }
  ADD_FAILURE() << "docs/elements/hapticsink.md has no row " << row;
  return std::nullopt;
}

TEST(SafetyChain, FadesInTheTimesOnThePageOfHapticsink) {
  const std::pair<const char *, std::uint32_t> rows[] = {
      {"PLAYING→PAUSED", haptic::kHoldPaused},
      {"No new sample", haptic::kHoldStale},
      {"A frame without a measurement", haptic::kHoldGap},
      {"Another scene", haptic::kHoldCut},
      {"End of stream", haptic::kHoldEnded},
      {"A seek", haptic::kHoldFlushing},
      {"A tick more than 10 ms late", haptic::kHoldLate},
      {"A string", haptic::kHoldSlipped},
      {"`release`, or the machine", haptic::kHoldReleased},
      {"`dead-man=button`", haptic::kHoldDeadMan},
      {"A law [shakes]", haptic::kHoldShaking},
      {"Three failed exchanges", haptic::kHoldFaulted},
  };
  auto input = push(1);
  input.slew_rate = 1000; // N/s: it is not what takes the time
  for (const auto &[row, hold] : rows) {
    SCOPED_TRACE(row);
    SafetyChain chain = settled(input);
    const auto to_zero = time_on_page(row, 1);
    ASSERT_TRUE(to_zero);
    EXPECT_NEAR(time_to_silence(chain, held(input, hold), 1), *to_zero * kTick, 2 * kTick);
    int returned = 0; // ms
    while (chain.step(input).force.norm() < 1 && returned < 10'000)
      ++returned;
    if (const auto to_full = time_on_page(row, 2)) {
      EXPECT_NEAR(returned, *to_full, 2);
    }
  }
}

TEST(SafetyChain, LetsATrustedForceThroughExactly) {
  SafetyChain chain{test::kSpidar};
  EXPECT_EQ(steps(chain, push(0.3, -0.4), 1000), Vector3(0.3, -0.4, 0));
  EXPECT_TRUE(chain.follows_sample());
}

TEST(SafetyChain, ChangesNoFasterThanTheSlewRate) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> force(-3, 3);
  SafetyChain chain = settled(push(0));
  Vector3 before = Vector3::Zero();
  for (int i = 0; i < 20'000; ++i) {
    static SafetyChain::Input input = push(0);
    if (i % 33 == 0)
      input = push(force(random), force(random));
    const Vector3 now = chain.step(input).force;
    ASSERT_LE((now - before).norm(), 20 * kTick + 1e-12);
    before = now;
  }
}

TEST(SafetyChain, AReversalOfTheFullForceTakesTheSlewRatesTime) {
  SafetyChain chain = settled(push(1));
  EXPECT_NEAR(steps(chain, push(-1), 50).x(), 0, 1e-9);
  EXPECT_NEAR(steps(chain, push(-1), 50).x(), -1, 1e-9);
}

TEST(SafetyChain, NeverExceedsTheMaximumForce) {
  SafetyChain chain{test::kSpidar};
  EXPECT_NEAR(steps(chain, push(4, 3), 1000).norm(), 1, 1e-12);
  EXPECT_NEAR(chain.step(push(4, 3)).force.x(), 0.8, 1e-12); // the direction is kept
}

TEST(SafetyChain, TellsWhichLimitActed) {
  using namespace haptic;
  EXPECT_EQ(settled(push(0.5)).limits(), 0U) << "none";
  EXPECT_EQ(settled(push(2)).limits(), kLimitForce);
  SafetyChain::Input input = push(0.5);
  input.trust = 0.5;
  EXPECT_EQ(settled(input).limits(), kLimitConfidence);
  input = push(0.5);
  input.wanted.torque = {0, 0, 0.05};
  EXPECT_EQ(settled(input).limits(), kLimitTorque);
  input = push(0.5);
  input.continuous_force = 0.1;
  SafetyChain spent{test::kSpidar};
  steps(spent, input, 120'000);
  EXPECT_EQ(spent.limits(), kLimitBudget);
  SafetyChain chain = settled(push(0.5));
  chain.step(push(-0.5));
  EXPECT_EQ(chain.limits(), kLimitSlew);
  chain.step({.holds = kHoldReleased, .dt = kTick});
  EXPECT_EQ(chain.limits(), kLimitFade);
}

TEST(SafetyChain, ALoweredMaximumTakesTheForceOffIn50MillisecondsWithoutAStep) {
  for (const double slew_rate : {0.1, 20.0}) {
    SCOPED_TRACE(slew_rate);
    auto input = push(5);
    input.max_force = 5;
    input.wanted.torque = {0, 0, 0.1};
    input.max_torque = 0.1;
    input.slew_rate = slew_rate;
    SafetyChain chain{test::kSpidar};
    steps(chain, input, 51'000);
    ASSERT_NEAR(chain.wrench().force.norm(), 5, 1e-9);
    input.max_force = 0;
    input.max_torque = 0;
    EXPECT_NEAR(steps(chain, input, 1).norm(), 4.9, 1e-9);
    steps(chain, input, 49);
    EXPECT_NEAR(chain.wrench().force.norm(), 0, 1e-9);
    EXPECT_NEAR(chain.wrench().torque.norm(), 0, 1e-9);
  }
}

TEST(SafetyChain, EveryReasonForSilenceHasItsTime) {
  const struct {
    std::uint32_t hold;
    double seconds;
  } kTimes[] = {
      {haptic::kHoldPaused, 0.1},    {haptic::kHoldEnded, 0.1},   {haptic::kHoldFlushing, 0.05},
      {haptic::kHoldReleased, 0.05}, {haptic::kHoldLate, 0.05},   {haptic::kHoldOverspeed, 0.05},
      {haptic::kHoldNoPose, 0.05},   {haptic::kHoldCut, 0.05},    {haptic::kHoldSuspended, 0.05},
      {haptic::kHoldFaulted, 0.001}, {haptic::kHoldClosed, 0.001}};
  for (const auto &[hold, seconds] : kTimes) {
    SafetyChain chain = settled(push(1));
    EXPECT_NEAR(time_to_silence(chain, held(push(1), hold), 1), seconds, kTick / 2) << hold;
  }
}

TEST(SafetyChain, AFadeReachesZeroInTimeWhateverTheSlewRateAndTheTicks) {
  auto input = push(4);
  input.max_force = 4;
  input.slew_rate = 0.5;
  SafetyChain chain = settled(input);
  for (int i = 0; i < 20'000; ++i)
    chain.step(input);
  EXPECT_NEAR(time_to_silence(chain, held(input, haptic::kHoldFlushing), 4), 0.05, kTick / 2);

  chain = settled(push(1));
  auto slow = held(push(1), haptic::kHoldPaused);
  slow.dt = 0.04;
  steps(chain, slow, 3);
  EXPECT_TRUE(chain.silent());
}

TEST(SafetyChain, WhileItFadesNothingTheLawSaysCountsAnyMore) {
  SafetyChain chain = settled(push(0.5));
  const auto pause = held(push(-5, 5), haptic::kHoldPaused);
  const Vector3 halfway = steps(chain, pause, 50);
  EXPECT_NEAR(halfway.x(), 0.25, 1e-9);
  EXPECT_EQ(halfway.y(), 0);
}

TEST(SafetyChain, AMoreUrgentReasonShortensAFade) {
  SafetyChain chain = settled(push(1));
  steps(chain, held(push(1), haptic::kHoldPaused), 20); // 80 ms to go
  EXPECT_NEAR(
      time_to_silence(chain, held(push(1), haptic::kHoldPaused | haptic::kHoldFlushing), 0.81),
      0.05, kTick / 2);
}

TEST(SafetyChain, FadesInAsSlowlyAsTheReasonDemands) {
  const struct {
    std::uint32_t hold;
    int milliseconds;
  } kTimes[] = {{haptic::kHoldPaused, 50},
                {haptic::kHoldFlushing, 200},
                {haptic::kHoldReleased, 500},
                {haptic::kHoldReleased | haptic::kHoldPaused, 500}};
  for (const auto &[hold, milliseconds] : kTimes) {
    SafetyChain chain = settled(push(0.2));
    steps(chain, held(push(0.2), hold), 200);
    ASSERT_TRUE(chain.silent());
    EXPECT_NEAR(steps(chain, push(0.2), milliseconds / 2).x(), 0.1, 1e-9) << hold;
    EXPECT_NEAR(steps(chain, push(0.2), milliseconds / 2).x(), 0.2, 1e-9) << hold;
  }
}

TEST(SafetyChain, AGapDuringTheFadeInAfterArmDoesNotHurryIt) {
  SafetyChain chain = settled(push(0.2));
  steps(chain, held(push(0.2), haptic::kHoldReleased), 200);
  steps(chain, push(0.2), 10);
  auto gap = push(0.2);
  gap.measured = false;
  steps(chain, gap, 100);
  EXPECT_NEAR(steps(chain, push(0.2), 250).x(), 0.1, 1e-9);
}

TEST(SafetyChain, AFadeThatIsTakenBackGoesOnWithoutAStep) {
  SafetyChain chain = settled(push(1));
  const double before = steps(chain, held(push(1), haptic::kHoldPaused), 50).x();
  const double after = chain.step(push(1)).force.x();
  EXPECT_NEAR(before, 0.5, 1e-9);
  EXPECT_GE(after, before);
  EXPECT_LE(after - before, 20 * kTick + 1e-12);
}

TEST(SafetyChain, WithoutAMeasurementItFadesIn100Milliseconds) {
  SafetyChain chain = settled(push(1));
  auto gap = push(1);
  gap.measured = false;
  gap.trust = 0;
  EXPECT_NEAR(time_to_silence(chain, gap, 1), 0.1, kTick / 2);
  EXPECT_FALSE(chain.follows_sample());
}

TEST(SafetyChain, ASampleIsStaleAfterThreeOfItsIntervals) {
  EXPECT_NEAR(haptic::stale_after(0.4), 1.2, 1e-12); // tree.avi
  EXPECT_EQ(haptic::stale_after(1.0 / 60), 0.1);
  EXPECT_EQ(haptic::stale_after(0), 0.1);
  EXPECT_EQ(haptic::stale_after(1e9), 2); // no claim keeps a force standing
}

TEST(SafetyChain, AStalledSourceIsSilentWithin250MillisecondsAndAnInterval) {
  SafetyChain chain = settled(push(1));
  auto input = push(1);
  double silent_at = 0;
  for (int n = 1; n < 1000 && !silent_at; ++n) {
    input.age = n * kTick;
    if (chain.step(input); chain.silent())
      silent_at = input.age;
  }
  EXPECT_NEAR(silent_at, 0.2, 2 * kTick);
}

TEST(SafetyChain, TrustOpensAtOnceAndClosesSlowly) {
  SafetyChain chain = settled(push(0.01));
  auto doubtful = push(0.01);
  doubtful.trust = 0;
  EXPECT_NEAR(steps(chain, doubtful, 100).x(), 0.01 * std::exp(-1), 1e-5);
  EXPECT_NEAR(chain.step(push(0.01)).force.x(), 0.01, 1e-12);
  steps(chain, doubtful, 1000);
  EXPECT_TRUE(chain.silent());
}

TEST(SafetyChain, ADoubtfulMeasurementDecaysTheForceAndDoesNotTurnIt) {
  SafetyChain chain = settled(push(0.5));
  auto doubtful = push(-1, 1);
  doubtful.trust = 0;
  double before = 0.5;
  for (int i = 0; i < 500; ++i) {
    const Vector3 now = chain.step(doubtful).force;
    ASSERT_GE(now.x(), 0);
    ASSERT_LE(now.x(), before);
    ASSERT_EQ(now.y(), 0);
    before = now.x();
  }
}

TEST(SafetyChain, WhatIsNotFiniteIsZeroOnTheSameTick) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (double bad : {nan, infinity, -infinity}) {
    for (auto spoil : {+[](SafetyChain::Input &i, double b) { i.wanted.force.y() = b; },
                       +[](SafetyChain::Input &i, double b) { i.trust = b; },
                       +[](SafetyChain::Input &i, double b) { i.wanted.torque.z() = b; },
                       +[](SafetyChain::Input &i, double b) { i.hand_velocity.x() = b; },
                       +[](SafetyChain::Input &i, double b) { i.hand_turning.z() = b; },
                       +[](SafetyChain::Input &i, double b) { i.acted.force.x() = b; },
                       +[](SafetyChain::Input &i, double b) { i.touch.force.x() = b; },
                       +[](SafetyChain::Input &i, double b) { i.touch.energy = b; },
                       +[](SafetyChain::Input &i, double b) { i.longest_dt = b; },
                       +[](SafetyChain::Input &i, double b) { i.moved.y() = b; },
                       +[](SafetyChain::Input &i, double b) { i.turned.x() = b; },
                       +[](SafetyChain::Input &i, double b) { i.max_torque = b; },
                       +[](SafetyChain::Input &i, double b) { i.continuous_force = b; },
                       +[](SafetyChain::Input &i, double b) { i.damping = b; },
                       +[](SafetyChain::Input &i, double b) { i.age = b; },
                       +[](SafetyChain::Input &i, double b) { i.interval = b; },
                       +[](SafetyChain::Input &i, double b) { i.max_force = b; },
                       +[](SafetyChain::Input &i, double b) { i.slew_rate = b; },
                       +[](SafetyChain::Input &i, double b) { i.dt = b; }}) {
      SafetyChain chain = settled(push(1));
      auto input = push(1);
      spoil(input, bad);
      EXPECT_TRUE(chain.step(input).force.isZero(0));
      EXPECT_TRUE(chain.found_non_finite());
      EXPECT_LE(chain.step(push(1)).force.norm(), 20 * kTick + 1e-12);
      EXPECT_FALSE(chain.found_non_finite());
    }
  }
}

TEST(SafetyChain, ALateTickFadesToZeroBeforeTheForceComesBack) {
  SafetyChain chain = settled(push(1));
  chain.step(held(push(1), haptic::kHoldLate));
  double before = 1;
  int n = 0;
  while (!chain.silent() && n < 100) {
    const double now = chain.step(push(1)).force.norm();
    ASSERT_LE(now, before);
    before = now;
    ++n;
  }
  EXPECT_NEAR(n, 49, 1);
  EXPECT_NEAR(steps(chain, push(1), 100).x(), 0.5, 0.011); // 200 ms back
}

TEST(SafetyChain, RandomHoldsAndSamplesNeverBreakALimit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-2, 2);
  SafetyChain chain{test::kSpidar};
  Vector3 before = Vector3::Zero();
  auto input = push(0);
  for (int i = 0; i < 200'000; ++i) {
    if (i % 17 == 0) {
      input = push(number(random), number(random));
      input.trust = std::clamp(number(random), 0.0, 1.0);
      input.measured = random() % 8 != 0;
    }
    if (i % 41 == 0)
      input.holds = random() % 3 ? 0 : (1U << (random() % 13));
    const Vector3 now = chain.step(input).force;
    ASSERT_TRUE(now.allFinite());
    ASSERT_LE(now.norm(), 1 + 1e-12);
    if (input.holds || !input.measured)
      ASSERT_LE(now.norm(), before.norm());
    else
      ASSERT_LE((now - before).norm(), 20 * kTick + 1e-12);
    before = now;
  }
}

// The hand moves at so many m/s to the right.
void carry(SafetyChain::Input &input, double speed) {
  input.hand_velocity = {speed, 0, 0};
  input.moved = speed * input.dt * Vector3::UnitX();
}

// A hand that a strong force carries along, undamped.
SafetyChain::Input carried_off() {
  auto input = push(4);
  input.max_force = 4;
  input.damping = 0;
  carry(input, 0.9);
  return input;
}

// ---- torque, cut, work and damping --------------------------------------------------------------

SafetyChain::Input turn(double torque) {
  auto input = push(0);
  input.wanted.torque.z() = torque;
  return input;
}

TEST(SafetyChain, ATorqueHasTheSameLimitsAsAForce) {
  SafetyChain chain = settled(turn(0));
  EXPECT_NEAR(chain.step(turn(1)).torque.z(), 20 * kTick * SafetyChain::kTorqueArm, 1e-12);
  steps(chain, turn(1), 100);
  EXPECT_NEAR(chain.wrench().torque.z(), 0.02, 1e-12); // max_torque
  steps(chain, held(turn(1), haptic::kHoldPaused), 50);
  EXPECT_NEAR(chain.wrench().torque.z(), 0.01, 1e-9);
  steps(chain, held(turn(1), haptic::kHoldPaused), 50);
  EXPECT_TRUE(chain.silent());
}

TEST(SafetyChain, ACutIsZeroInTwoFramesAndStartsAnew) {
  SafetyChain chain = settled(push(1));
  chain.step(held(push(1), haptic::kHoldCut));
  double before = 1;
  for (int i = 1; i < 50; ++i) {
    const double now = chain.step(push(-1)).force.x();
    ASSERT_LE(now, before);
    ASSERT_GE(now, 0);
    before = now;
  }
  EXPECT_LT(before, 0.03);
}

TEST(SafetyChain, AHandThatIsCarriedAlongIsBrakedAndAHandThatPointsIsNot) {
  auto input = push(0.5);
  input.hand_velocity = {0.1, 0, 0}; // pointing
  EXPECT_EQ(settled(input).step(input).force.x(), 0.5);
  input.hand_velocity = {0.4, 0, 0};
  SafetyChain chain = settled(push(0.5));
  EXPECT_NEAR(steps(chain, input, 50).x(), 0.2, 1e-9); // 1 N·s/m of the 0.3 m/s beyond
}

TEST(SafetyChain, WithoutAForceThereIsNoDamping) {
  auto input = push(0);
  input.hand_velocity = {0.9, -0.9, 0};
  SafetyChain chain{test::kSpidar};
  EXPECT_TRUE(steps(chain, input, 1000).isZero(0));
}

TEST(SafetyChain, DampingTakesAtMostTheWholeForce) {
  auto input = push(0.3);
  input.damping = 10;
  input.hand_velocity = {0.9, 0, 0};
  SafetyChain chain = settled(push(0.3));
  EXPECT_NEAR(steps(chain, input, 100).norm(), 0, 1e-9);
}

TEST(SafetyChain, InFiveSecondsTheForceDoesAtMostTwoAndAHalfJoules) {
  const auto input = carried_off();
  Acting chain;
  double work = 0;
  Vector3 before = Vector3::Zero();
  for (int i = 0; i < 5000; ++i) {
    work += before.x() * 0.9 * kTick;
    const Vector3 now = chain.step(input).force;
    // Only the last of the work takes it off faster than the slew rate.
    ASSERT_LE(now.norm() - before.norm(), 20 * kTick + 1e-12);
    ASSERT_LE((now - before).norm(), (work < 0.65 ? 20 : 100) * kTick + 1e-12) << i << " ms";
    before = now;
  }
  EXPECT_LE(work, 2.5);
  EXPECT_NEAR(before.x() * 0.9, EnergyAccount::kWorkRate, 0.01); // what remains for ever
}

// The largest work of any 5 s, J, that the force does on a hand that is carried off at `speed`
// after 50 s at rest. The device exerts a command from the step after the next one on.
double most_work_in_five_seconds(SafetyChain::Input input, double speed) {
  Acting chain;
  chain.steps(input, 50'000);
  carry(input, speed);
  double work = 0;
  for (int i = 0; i < 5000; ++i) {
    work += chain.acting().force.x() * speed * kTick;
    chain.step(input);
  }
  return work;
}

TEST(SafetyChain, NeitherSlewRateNorForceNorSpeedAddsToTheWorkOfFiveSeconds) {
  for (const double slew_rate : {0.1, 1.0, 20.0, 1000.0})
    for (const double force : {1.0, 5.0})
      for (const double speed : {0.1, 0.3, 0.9, 3.0}) {
        auto input = push(force);
        input.max_force = force;
        input.slew_rate = slew_rate;
        input.damping = 0;
        EXPECT_LE(most_work_in_five_seconds(input, speed), 2.5)
            << slew_rate << " N/s, " << force << " N, " << speed << " m/s";
      }
}

TEST(SafetyChain, WorkThatALateTickLetTheForceDoIsPaidBackFirst) {
  auto input = push(5);
  input.max_force = 5;
  input.damping = 0;
  Acting chain;
  chain.steps(input, 1000);
  input.dt = 0.5; // s: 2.5 J, and 0.9 J were left
  carry(input, 1);
  chain.step(input);
  input.dt = kTick;
  carry(input, 0);
  chain.step(input);
  EXPECT_TRUE(chain.chain.silent());
  // 1.45 J at 0.3 W
  EXPECT_TRUE(chain.steps(input, 4800).force.isZero(0));
  EXPECT_GT(chain.steps(input, 200).force.x(), 0);
}

TEST(SafetyChain, AGripThatTurnsIsBrakedAtOnceAndAHandThatTurnsItSlowlyIsNot) {
  auto input = turn(0.02);
  input.hand_turning = {0, 0, 1};
  SafetyChain chain = settled(input);
  EXPECT_EQ(chain.step(input).torque.z(), 0.02);
  input.hand_turning = {0, 0, 3};
  EXPECT_NEAR(chain.step(input).torque.z(), 0.02 - 2 * test::kSpidar.turn_brake, 1e-12);
  input.hand_turning = {0, 0, 100};
  EXPECT_NEAR(chain.step(input).torque.z(), 0, 1e-12); // it takes the torque, and no more
  input.hand_turning.setZero();
  EXPECT_NEAR(chain.step(input).torque.z(), 0.02, 1e-12);
}

TEST(SafetyChain, WithoutATorqueOrAForceThereIsNoBrake) {
  auto input = turn(0);
  input.hand_turning = {9, -9, 9};
  SafetyChain chain{test::kSpidar};
  for (int i = 0; i < 100; ++i)
    ASSERT_TRUE(chain.step(input).torque.isZero(0));
}

TEST(SafetyChain, TheBrakeNeverExceedsTheMaximumTorque) {
  auto input = push(1);
  input.hand_turning = {0, 0, 50};
  SafetyChain chain = settled(push(1));
  EXPECT_NEAR(chain.step(input).torque.z(), -0.02, 1e-12);
  input.max_torque = 0;
  EXPECT_TRUE(chain.step(input).torque.isZero(0));
}

TEST(SafetyChain, TheTorqueDoesNoMoreWorkThanTheForceMay) {
  auto input = turn(0.1);
  input.max_torque = 0.1;
  input.hand_turning = {0, 0, 6};
  input.turned = input.hand_turning * kTick;
  Acting chain;
  EXPECT_GT(chain.steps(input, 1000).torque.z() * 6, 1.1 * EnergyAccount::kWorkRate);
  EXPECT_NEAR(chain.steps(input, 60'000).torque.z() * 6, EnergyAccount::kWorkRate, 0.01);
}

TEST(SafetyChain, ARestartBeginsFromZeroAndGivesNoWorkBack) {
  const auto input = carried_off();
  Acting chain;
  double work = 0;
  for (int i = 0; i < 5000; ++i) {
    if (i % 500 == 0) {
      chain.chain.restart();
      ASSERT_TRUE(chain.chain.silent());
    }
    work += chain.step(input).force.x() * 0.9 * kTick;
  }
  EXPECT_LE(work, 2.5);
}

TEST(SafetyChain, AHandThatHoldsStillGetsTheWholeForceForEver) {
  SafetyChain chain{test::kSpidar};
  EXPECT_EQ(steps(chain, push(0.8), 100'000).x(), 0.8);
}

// The spring of a touch holds no more than the chain says; else it would be cut off on the hand's
// way out and felt on its way in.
TEST(SafetyChain, PaysWhatItSaysThatTheHandMayHaveBack) {
  constexpr double kForce = 0.2; // N
  constexpr double kWay = 1e-5;  // m, in a tick
  auto input = push(0);
  input.slew_rate = 1000;
  input.touch.force.z() = kForce;
  input.touch.energy = kForce * kForce / (2 * 200);
  Acting acting;
  acting.steps(input, 60); // fades in
  input.moved.z() = -kWay;
  acting.steps(input, 15);
  input.moved.z() = kWay;
  const double price = kForce * kWay * (1 + test::kSpidar.delay); // of this tick, and in advance
  int paid = 0;
  for (; acting.chain.energy_of_hand() > price; ++paid)
    ASSERT_DOUBLE_EQ(acting.step(input).force.z(), kForce) << paid;
  EXPECT_GT(paid, 10);
  const double trickle = test::kSpidar.flicker * input.max_force; // W
  EXPECT_NEAR(acting.steps(input, 20).force.z(), trickle / (kWay / kTick), 1e-6);
}

// A tick that comes soon after a late one is short, and a command acts as long as the late one
// took.
TEST(SafetyChain, ACountThatFlickersSoonAfterALateTickIsNoSpeed) {
  auto input = push(0);
  input.slew_rate = 1000;
  input.touch.force.z() = 0.1; // N
  input.touch.energy = 1e-3;   // J
  Acting acting;
  acting.steps(input, 60); // fades in
  input.dt = 0.00025;      // s
  input.longest_dt = 0.01; // s
  input.moved.z() = -1e-6; // m
  acting.steps(input, 200);
  ASSERT_DOUBLE_EQ(acting.steps(input, 1).force.z(), 0.1);
  input.moved.z() = 0.9 * test::kSpidar.flicker_way;
  EXPECT_DOUBLE_EQ(acting.step(input).force.z(), 0.1);
  input.moved.z() = 0.9 * input.dt; // a hand that jumps
  EXPECT_LT(acting.step(input).force.z(), 0.05);
}

} // namespace safety_chain_test
