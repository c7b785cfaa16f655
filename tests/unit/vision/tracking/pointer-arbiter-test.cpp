// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracking/pointer-arbiter.hpp"

#include <gtest/gtest.h>

namespace pointer_arbiter_test {

using namespace std::chrono_literals;
using haptic::Pointer;
using haptic::PointerArbiter;
using haptic::PointerSource;

constexpr Pointer kDevice{0.1, 0.2};
constexpr Pointer kMouse{0.3, 0.4};
constexpr Pointer kSet{0.6, 0.7};
constexpr PointerArbiter::Time kNow{1000s};

PointerArbiter all_three(PointerSource source) {
  PointerArbiter arbiter;
  arbiter.source = source;
  arbiter.property = kSet;
  arbiter.point_navigation(60, 60, 200, 150);
  arbiter.point_haptic(kDevice, kNow);
  return arbiter;
}

TEST(PointerArbiter, StartsInTheMiddle) {
  EXPECT_EQ(PointerArbiter{}.in_use(kNow), (Pointer{0.5, 0.5}));
}

TEST(PointerArbiter, TheHandComesBeforeTheMouseForASecondAfterItMoved) {
  const PointerArbiter arbiter = all_three(PointerSource::automatic);
  EXPECT_EQ(arbiter.in_use(kNow + 1s), kDevice);
  EXPECT_EQ(arbiter.in_use(kNow + 1001ms), kMouse);
}

TEST(PointerArbiter, AMouseOutsideTheFramePointsAtItsBorder) {
  PointerArbiter arbiter;
  arbiter.point_navigation(-5, 500, 200, 150);
  EXPECT_EQ(arbiter.in_use(kNow), (Pointer{0, 1}));
}

TEST(PointerArbiter, TheForceIsKnownForASecondAfterTheDeviceReportedIt) {
  PointerArbiter arbiter = all_three(PointerSource::property);
  EXPECT_EQ(arbiter.force(kNow), std::nullopt);
  const haptic::Force force = {0.1, -0.2, 0.3};
  arbiter.point_haptic(kDevice, kNow, force);
  EXPECT_EQ(arbiter.force(kNow + 1s), force);
  EXPECT_EQ(arbiter.force(kNow + 1001ms), std::nullopt);
  arbiter.point_haptic(kDevice, kNow + 2s);
  EXPECT_EQ(arbiter.force(kNow + 2s), std::nullopt);
  arbiter.point_haptic(kDevice, kNow + 3s, force);
  arbiter.forget();
  EXPECT_EQ(arbiter.force(kNow + 3s), std::nullopt);
}

TEST(PointerArbiter, WhileADevicePressesNoOtherOnePoints) {
  PointerArbiter arbiter;
  constexpr Pointer kPressed{0.1, 0.2, 0, true};
  constexpr Pointer kOther{0.8, 0.9};
  arbiter.point_haptic(kPressed, kNow, {}, {}, "mine");
  arbiter.point_haptic(kOther, kNow, {}, {}, "other");
  EXPECT_EQ(arbiter.in_use(kNow), kPressed);
  arbiter.point_haptic(kOther, kNow + 1001ms, {}, {}, "other"); // the first one is silent
  EXPECT_EQ(arbiter.in_use(kNow + 1001ms), kOther);
  arbiter.point_haptic(kDevice, kNow + 1001ms, {}, {}, "mine");
  EXPECT_EQ(arbiter.in_use(kNow + 1001ms), kDevice);
}

TEST(PointerArbiter, TheProxyIsKnownAsLongAsTheForce) {
  PointerArbiter arbiter;
  const haptic::ProxyPosition proxy{0.25, 0.75, 0.002};
  arbiter.point_haptic(kDevice, kNow, std::nullopt, proxy);
  EXPECT_EQ(arbiter.proxy(kNow + 1s), proxy);
  EXPECT_EQ(arbiter.proxy(kNow + 1001ms), std::nullopt);
  arbiter.point_haptic(kDevice, kNow + 2s);
  EXPECT_EQ(arbiter.proxy(kNow + 2s), std::nullopt);
}

TEST(PointerArbiter, WithoutEventsTheProperties) {
  PointerArbiter arbiter = all_three(PointerSource::automatic);
  arbiter.forget();
  EXPECT_EQ(arbiter.in_use(kNow), kSet);
}

TEST(PointerArbiter, AChosenSourceIsTheOnlyOne) {
  EXPECT_EQ(all_three(PointerSource::haptic).in_use(kNow + 1h), kDevice);
  EXPECT_EQ(all_three(PointerSource::navigation).in_use(kNow), kMouse);
  EXPECT_EQ(all_three(PointerSource::property).in_use(kNow), kSet);
}

TEST(PointerArbiter, AChosenSourceThatNeverSpokeLeavesTheProperties) {
  for (const auto source : {PointerSource::haptic, PointerSource::navigation}) {
    PointerArbiter arbiter;
    arbiter.source = source;
    arbiter.property = kSet;
    EXPECT_EQ(arbiter.in_use(kNow), kSet);
  }
}

} // namespace pointer_arbiter_test
