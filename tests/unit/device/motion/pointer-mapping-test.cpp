// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/pointer-mapping.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace pointer_mapping_test {

using haptic::map_pointer;
using haptic::PointerGate;
using haptic::PointerPosition;
using spidar::Vector3;

const Vector3 kHalf(0.025, 0.02, 0.03); // m
constexpr std::int64_t kMs = 1'000'000; // ns

TEST(MapPointer, TheCentreOfTheWorkspaceIsTheCentreOfTheFrame) {
  const PointerPosition p = map_pointer(Vector3::Zero(), kHalf);
  EXPECT_EQ(p.x, 0.5);
  EXPECT_EQ(p.y, 0.5);
  EXPECT_EQ(p.z, 0);
}

TEST(MapPointer, IsEquation1) {
  const PointerPosition p = map_pointer({0.0125, -0.01, 0.015}, kHalf);
  EXPECT_NEAR(p.x, 0.75, 1e-12);
  EXPECT_NEAR(p.y, 0.75, 1e-12); // below the centre
  EXPECT_NEAR(p.z, 0.5, 1e-12);
  EXPECT_NEAR(map_pointer({0, 0.02, 0}, kHalf).y, 0, 1e-12); // up is the top
}

TEST(MapPointer, StaysInTheFrameWhenTheHandLeavesTheWorkspace) {
  const PointerPosition p = map_pointer({1, 1, -1}, kHalf);
  EXPECT_EQ(p.x, 1);
  EXPECT_EQ(p.y, 0);
  EXPECT_EQ(p.z, -1);
}

// ---- wash-out -----------------------------------------------------------------------------------

using haptic::FrameShift;
using haptic::WashOut;

constexpr double kTick = 0.001; // s

// A hand that moves to and fro about `centre` (m to the right), and what it points at.
struct Pointing {
  WashOut wash_out;
  double time = 0;

  PointerPosition tick(double centre, double rate, double amplitude = 0.005) {
    time += kTick;
    const Vector3 hand(centre + amplitude * std::sin(10 * time), 0, 0);
    const Vector3 velocity(10 * amplitude * std::cos(10 * time), 0, 0);
    wash_out.step(hand, velocity, kHalf, rate, kTick);
    return map_pointer(hand, kHalf, wash_out.shift());
  }
};

TEST(WashOutTest, OffItIsExactlyEquation1) {
  Pointing pointing;
  for (int ms = 0; ms < 10'000; ++ms) {
    const PointerPosition point = pointing.tick(0.02, 0);
    const Vector3 hand(0.02 + 0.005 * std::sin(10 * pointing.time), 0, 0);
    ASSERT_EQ(point.x, map_pointer(hand, kHalf).x);
    ASSERT_EQ(point.y, map_pointer(hand, kHalf).y);
  }
}

TEST(WashOutTest, ThePointerNeverJumpsWhateverTheRate) {
  for (const double rate : {0.1, 1.0, 10.0}) {
    Pointing pointing;
    PointerPosition before = pointing.tick(0.01, rate);
    for (int ms = 0; ms < 20'000; ++ms) {
      const double rate_now = ms / 5000 % 2 ? 0 : rate; // switched off and on
      const PointerPosition point = pointing.tick(0.01, rate_now);
      const double most = 10 * 0.005 * kTick / (2 * kHalf.x()); // of the hand alone
      ASSERT_LE(std::abs(point.x - before.x), (1 + WashOut::kMostDrift) * most + 1e-12);
      ASSERT_EQ(point.y, before.y);
      before = point;
    }
  }
}

// The hand keeps its point in sight: it moves back by what the frame moves under it.
TEST(WashOutTest, AHandThatFollowsItsPointComesToRestNearTheCentre) {
  Pointing pointing;
  double centre = 0.02; // m; the point is at 0.9 of the frame
  double worst = 0;
  for (int ms = 0; ms < 60'000; ++ms) {
    const FrameShift before = pointing.wash_out.shift();
    const PointerPosition point = pointing.tick(centre, 0.2);
    centre -= (pointing.wash_out.shift().x - before.x) * 2 * kHalf.x();
    worst = std::max(worst, std::abs(point.x - 0.9));
  }
  EXPECT_LT(std::abs(centre), 0.002);
  EXPECT_LT(worst, 0.11); // the movement to and fro
}

TEST(WashOutTest, AHandThatRestsKeepsItsPoint) {
  Pointing pointing;
  const double before = pointing.tick(0.02, 10, 0).x;
  for (int ms = 0; ms < 10'000; ++ms)
    ASSERT_EQ(pointing.tick(0.02, 10, 0).x, before);
}

TEST(WashOutTest, TheHandInTheCentreAlwaysPointsIntoTheFrame) {
  Pointing pointing;
  for (int ms = 0; ms < 100'000; ++ms)
    pointing.tick(0.02, 10, 0.01);
  EXPECT_EQ(pointing.wash_out.shift().x, 0.5);
  EXPECT_EQ(map_pointer(Vector3::Zero(), kHalf, pointing.wash_out.shift()).x, 1);
}

TEST(WashOutTest, SwitchedOffItGoesBackAsSlowly) {
  Pointing pointing;
  for (int ms = 0; ms < 10'000; ++ms)
    pointing.tick(0.02, 1);
  ASSERT_GT(pointing.wash_out.shift().x, 0.05);
  for (int ms = 0; ms < 60'000; ++ms)
    pointing.tick(0.02, 0);
  EXPECT_NEAR(pointing.wash_out.shift().x, 0, 1e-6);
}

TEST(PointerGateTest, LetsTheFirstPositionThrough) {
  EXPECT_TRUE(PointerGate().pass({}, 0));
}

TEST(PointerGateTest, ARestingHandIsToldFiveTimesASecond) {
  PointerGate gate;
  int passed = 0;
  for (int ms = 0; ms < 1000; ms += 10)
    passed += gate.pass({.x = 0.5 + 0.0009 * (ms % 20 ? 1 : 0)}, ms * kMs);
  EXPECT_EQ(passed, 5);
}

TEST(PointerGateTest, AMovingHandIsToldAtOnce) {
  PointerGate gate;
  gate.pass({.x = 0.5}, 0);
  EXPECT_TRUE(gate.pass({.x = 0.502}, kMs));
  EXPECT_TRUE(gate.pass({.x = 0.502, .y = 0.51}, 2 * kMs));
  EXPECT_TRUE(gate.pass({.x = 0.502, .y = 0.51, .z = 0.1}, 3 * kMs));
}

TEST(PointerGateTest, AButtonIsToldAtOnce) {
  PointerGate gate;
  gate.pass({}, 0);
  EXPECT_TRUE(gate.pass({.pressed = true}, kMs)) << "it is pressed";
  EXPECT_FALSE(gate.pass({.pressed = true}, 2 * kMs));
  EXPECT_TRUE(gate.pass({}, 3 * kMs)) << "it is released";
}

TEST(PointerGateTest, AForceThatChangesIsToldAtOnce) {
  PointerGate gate;
  gate.pass({.force = {{0.1, 0, 0}}}, 0);
  EXPECT_FALSE(gate.pass({.force = {{0.105, 0, 0}}}, kMs));
  EXPECT_TRUE(gate.pass({.force = {{0.1, 0.02, 0}}}, 2 * kMs));
  EXPECT_TRUE(gate.pass({}, 3 * kMs));
}

TEST(PointerGateTest, ATouchThatChangesIsToldAtOnce) {
  PointerGate gate;
  gate.pass({.proxy = {{0.5, 0.5, 0}}}, 0);
  EXPECT_FALSE(gate.pass({.proxy = {{0.5005, 0.5, 0}}}, kMs));
  EXPECT_TRUE(gate.pass({.proxy = {{0.5, 0.5, 1e-5}}}, 2 * kMs)) << "it begins";
  EXPECT_FALSE(gate.pass({.proxy = {{0.5, 0.5, 1e-4}}}, 3 * kMs));
  EXPECT_TRUE(gate.pass({.proxy = {{0.5, 0.5, 2e-4}}}, 4 * kMs));
  EXPECT_TRUE(gate.pass({.proxy = {{0.5, 0.5, 0}}}, 5 * kMs)) << "it ends";
  EXPECT_TRUE(gate.pass({}, 6 * kMs)) << "touch is off";
}

TEST(PointerGateTest, ASlowDriftIsToldOnceItIsLargeEnough) {
  PointerGate gate;
  gate.pass({.x = 0.5}, 0);
  EXPECT_FALSE(gate.pass({.x = 0.5006}, 10 * kMs));
  EXPECT_TRUE(gate.pass({.x = 0.5012}, 20 * kMs));
}

} // namespace pointer_mapping_test
