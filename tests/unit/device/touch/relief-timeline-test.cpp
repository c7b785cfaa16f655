// SPDX-License-Identifier: LGPL-2.1-or-later
#include "touch/relief-timeline.hpp"
#include "touched-surface.hpp"

#include <gtest/gtest.h>
#include <memory>

namespace relief_timeline_test {

using haptic::kAtOnce;
using haptic::ReliefAt;

constexpr std::int64_t kMs = 1'000'000;

class Timeline : public ::testing::Test {
protected:
  void add(double height, std::int64_t ms, std::int64_t now_ms, std::uint16_t flags = 0) {
    haptic::ReliefPool::Field field = pool_->acquire();
    ASSERT_TRUE(field);
    *field = test::relief_of(test::flat(height), 200, 0, 2);
    field->interval = 40 * kMs;
    field->flags = flags;
    timeline_.add({std::move(field), ms == kAtOnce ? ms : ms * kMs}, now_ms * kMs);
  }
  // m, in the middle of the workspace; -1 without a surface.
  double height_at(std::int64_t ms) {
    const ReliefAt &now = timeline_.at(ms * kMs);
    if (!now.to)
      return -1;
    return haptic::ReliefSurface(*now.from, *now.to, now.weight, test::kHalf).at(0, 0).height;
  }

  std::unique_ptr<haptic::ReliefPool> pool_ = std::make_unique<haptic::ReliefPool>();
  haptic::ReliefTimeline timeline_;
};

TEST_F(Timeline, IsLinearBetweenReliefsThatComeEarly) {
  add(0, 100, 40);
  add(0.008, 140, 80);
  EXPECT_EQ(height_at(99), -1);
  EXPECT_NEAR(height_at(100), 0, 1e-9);
  EXPECT_NEAR(height_at(110), 0.002, 1e-8);
  EXPECT_NEAR(height_at(130), 0.006, 1e-8);
  EXPECT_NEAR(height_at(200), 0.008, 1e-8);
  EXPECT_NEAR(timeline_.at(200 * kMs).age, 0.06, 1e-9);
}

TEST_F(Timeline, ReachesALateReliefOverAnInterval) {
  add(0, kAtOnce, 100);
  EXPECT_NEAR(height_at(100), 0, 1e-9);
  add(0.008, kAtOnce, 150);
  EXPECT_NEAR(height_at(150), 0, 1e-9);
  EXPECT_NEAR(height_at(170), 0.004, 1e-8);
  EXPECT_NEAR(height_at(190), 0.008, 1e-8);
  EXPECT_NEAR(timeline_.at(250 * kMs).age, 0.1, 1e-9);
}

TEST_F(Timeline, DrawsNoLineIntoAnotherScene) {
  add(0, 100, 40);
  add(0.008, 140, 80, haptic::kMotionCut);
  EXPECT_NEAR(height_at(139), 0, 1e-9);
  EXPECT_FALSE(timeline_.at(139 * kMs).cut);
  EXPECT_TRUE(timeline_.at(140 * kMs).cut);
  EXPECT_NEAR(height_at(141), 0.008, 1e-8);
  EXPECT_FALSE(timeline_.at(141 * kMs).cut);
}

TEST_F(Timeline, AGapEndsTheSurface) {
  add(0.001, 100, 40);
  timeline_.add({{}, 140 * kMs}, 80 * kMs);
  EXPECT_NEAR(height_at(139), 0.001, 1e-8);
  EXPECT_EQ(height_at(140), -1);
  add(0.002, 180, 120);
  EXPECT_EQ(height_at(179), -1);
  EXPECT_NEAR(height_at(180), 0.002, 1e-8);
}

TEST_F(Timeline, ASourceThatDoesNotWaitLosesItsOldestAndGivesAllMemoryBack) {
  for (int n = 0; n < 40; ++n) {
    add(0.001 * n / 40, 10'000 + n, 0);
  }
  EXPECT_NEAR(height_at(20'000), 0.001 * 39 / 40, 1e-6);
  timeline_.clear();
  std::vector<haptic::ReliefPool::Field> all;
  while (auto field = pool_->acquire())
    all.push_back(std::move(field));
  EXPECT_EQ(all.size(), haptic::ReliefPool::kSlots);
}

} // namespace relief_timeline_test
