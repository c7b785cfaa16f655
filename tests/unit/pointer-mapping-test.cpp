// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pointer-mapping.hpp"

#include <gtest/gtest.h>

namespace {

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

TEST(PointerGateTest, AForceThatChangesIsToldAtOnce) {
  PointerGate gate;
  gate.pass({.force = {{0.1, 0, 0}}}, 0);
  EXPECT_FALSE(gate.pass({.force = {{0.105, 0, 0}}}, kMs));
  EXPECT_TRUE(gate.pass({.force = {{0.1, 0.02, 0}}}, 2 * kMs));
  EXPECT_TRUE(gate.pass({}, 3 * kMs));
}

TEST(PointerGateTest, ASlowDriftIsToldOnceItIsLargeEnough) {
  PointerGate gate;
  gate.pass({.x = 0.5}, 0);
  EXPECT_FALSE(gate.pass({.x = 0.5006}, 10 * kMs));
  EXPECT_TRUE(gate.pass({.x = 0.5012}, 20 * kMs));
}

} // namespace
