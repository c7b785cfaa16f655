// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/held-trail.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace held_trail_test {

using haptic::HeldTrail;
using haptic::HoldState;

constexpr std::uint64_t kMs = 1'000'000; // ns

// Each frame moves the thing by a hundredth of the width.
void follow(HeldTrail &trail, HoldState state, int first, int last, std::uint64_t interval) {
  for (int i = first; i <= last; ++i)
    trail.add(
        {state, static_cast<float>(i) / 100, 0.5F, 0.1F, static_cast<std::uint64_t>(i) * interval});
}

std::vector<int> places(const HeldTrail &trail) {
  std::vector<int> places;
  for (const auto &point : trail.points())
    places.push_back(static_cast<int>(point.x * 100 + 0.5F));
  return places;
}

TEST(HeldTrail, IsThePathOfTheLastSecond) {
  HeldTrail trail;
  follow(trail, HoldState::held, 0, 7, 200 * kMs);
  EXPECT_EQ(places(trail), (std::vector<int>{2, 3, 4, 5, 6, 7}));
  for (const auto &point : trail.points())
    EXPECT_TRUE(point.joined);
}

TEST(HeldTrail, HasAGapWhereTheThingWasNotSeen) {
  HeldTrail trail;
  follow(trail, HoldState::held, 0, 2, 50 * kMs);
  follow(trail, HoldState::hidden, 3, 4, 50 * kMs);
  follow(trail, HoldState::held, 5, 6, 50 * kMs);
  EXPECT_EQ(places(trail), (std::vector<int>{0, 1, 2, 5, 6}));
  std::vector<bool> joined;
  for (const auto &point : trail.points())
    joined.push_back(point.joined);
  EXPECT_EQ(joined, (std::vector<bool>{false, true, true, false, true}));
}

TEST(HeldTrail, AThingThatIsLostLeavesNone) {
  HeldTrail trail;
  follow(trail, HoldState::held, 0, 2, 50 * kMs);
  follow(trail, HoldState::lost, 3, 30, 50 * kMs);
  EXPECT_TRUE(trail.points().empty());
}

TEST(HeldTrail, EndsWhenTheThingIsLetGo) {
  HeldTrail trail;
  follow(trail, HoldState::held, 0, 2, 50 * kMs);
  trail.add({});
  EXPECT_TRUE(trail.points().empty());
}

TEST(HeldTrail, BeginsAnewWithTheNextThing) {
  HeldTrail trail;
  follow(trail, HoldState::held, 0, 2, 50 * kMs);
  follow(trail, HoldState::about, 0, 0, 50 * kMs);
  EXPECT_EQ(places(trail), (std::vector<int>{0}));
  EXPECT_FALSE(trail.points()[0].joined);
}

TEST(HeldTrail, TimesThatStandStillDoNotMakeItLonger) {
  HeldTrail trail;
  follow(trail, HoldState::held, 0, 10000, 0);
  EXPECT_LE(trail.points().size(), 1000U);
}

} // namespace held_trail_test
