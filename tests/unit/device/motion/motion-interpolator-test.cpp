// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/motion-interpolator.hpp"

#include "samples/field-sampler.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <random>
#include <utility>

namespace motion_interpolator_test {

using haptic::kAtOnce;
using haptic::MotionInterpolator;
using haptic::MotionSample;
using haptic::TimedMotion;

constexpr std::int64_t kMs = 1'000'000; // ns
constexpr std::int64_t kFrame = 40 * kMs;

MotionSample moving(double vx, std::uint32_t width = 352) {
  MotionSample sample;
  sample.velocity_x = static_cast<float>(vx);
  sample.confidence = 1;
  sample.interval = kFrame;
  sample.frame_width = width;
  sample.frame_height = width * 3 / 4;
  return sample;
}
TimedMotion at(std::int64_t time, double vx) {
  return {moving(vx), true, time};
}
TimedMotion gap(std::int64_t time) {
  return {{}, false, time};
}

// The left half moves with the one velocity, the right one with the other; confidence 0 where it is
// said to be silent.
class Fields {
public:
  TimedMotion halves(std::int64_t time, double left, std::optional<double> right,
                     std::uint32_t width = 352) {
    auto field = pool_->acquire();
    const MotionSample frame = moving(0, width);
    field->interval = frame.interval;
    field->frame_width = frame.frame_width;
    field->frame_height = frame.frame_height;
    field->columns = 8;
    field->rows = 1;
    field->cells.assign(8, {});
    for (std::size_t i = 0; i < 8; ++i)
      if (i < 4 || right)
        field->cells[i] = {static_cast<float>(i < 4 ? left : *right), 0, 1};
    return {haptic::frame_of(*field), true, time, std::move(field)};
  }

private:
  std::unique_ptr<haptic::FieldPool> pool_ = std::make_unique<haptic::FieldPool>();
};
const haptic::PointerPosition kLeft{.x = 0.25};
const haptic::PointerPosition kRight{.x = 0.75};

TEST(MotionInterpolator, KnowsNothingAtFirst) {
  MotionInterpolator motion;
  EXPECT_FALSE(motion.at(5 * kMs).measured);
  EXPECT_EQ(motion.at(1000 * kMs).sample.confidence, 0);
}

TEST(MotionInterpolator, GoesInStraightLinesBetweenTheMiddlesOfTheIntervals) {
  MotionInterpolator motion;
  motion.add(at(100 * kMs, 0), 20 * kMs);
  motion.add(at(140 * kMs, 80), 60 * kMs);
  motion.add(at(180 * kMs, -80), 100 * kMs);
  EXPECT_FALSE(motion.at(99 * kMs).measured); // what is to come is not felt yet
  EXPECT_NEAR(motion.at(100 * kMs).sample.velocity_x, 0, 1e-4);
  EXPECT_NEAR(motion.at(110 * kMs).sample.velocity_x, 20, 1e-4);
  EXPECT_NEAR(motion.at(140 * kMs).sample.velocity_x, 80, 1e-4);
  EXPECT_NEAR(motion.at(160 * kMs).sample.velocity_x, 0, 1e-4);
  EXPECT_NEAR(motion.at(180 * kMs).sample.velocity_x, -80, 1e-4);
}

TEST(MotionInterpolator, HoldsTheLastMotionAndGoesOnFromThere) {
  MotionInterpolator motion;
  motion.add(at(100 * kMs, 50), 20 * kMs);
  EXPECT_EQ(motion.at(150 * kMs).sample.velocity_x, 50);
  motion.add(at(200 * kMs, 100), 150 * kMs); // in time
  EXPECT_NEAR(motion.at(175 * kMs).sample.velocity_x, 75, 1e-4);
}

TEST(MotionInterpolator, WhatComesTooLateIsLedToOverItsInterval) {
  for (const std::int64_t time : {kAtOnce, 70 * kMs, 110 * kMs}) {
    MotionInterpolator motion;
    motion.add(at(kAtOnce, 0), 60 * kMs);
    motion.at(100 * kMs);
    motion.add(at(time, 80), 100 * kMs);
    EXPECT_NEAR(motion.at(100 * kMs).sample.velocity_x, 0, 1e-4);
    EXPECT_NEAR(motion.at(120 * kMs).sample.velocity_x, 40, 1e-4);
    EXPECT_NEAR(motion.at(140 * kMs).sample.velocity_x, 80, 1e-4);
  }
}

TEST(MotionInterpolator, TheFirstMotionNeedsNothingToLeadToIt) {
  MotionInterpolator motion;
  motion.add(at(kAtOnce, 70), 10 * kMs);
  EXPECT_EQ(motion.at(10 * kMs).sample.velocity_x, 70);
}

TEST(MotionInterpolator, AGapCountsFromItsTimeOnAndLeavesNoLineAcrossIt) {
  MotionInterpolator motion;
  motion.add(at(100 * kMs, 50), 20 * kMs);
  motion.add(gap(140 * kMs), 60 * kMs);
  motion.add(at(180 * kMs, -50), 100 * kMs);
  EXPECT_TRUE(motion.at(130 * kMs).measured);
  EXPECT_EQ(motion.at(130 * kMs).sample.velocity_x, 50);
  EXPECT_FALSE(motion.at(150 * kMs).measured);
  EXPECT_EQ(motion.at(150 * kMs).sample.confidence, 0);
  EXPECT_TRUE(motion.at(180 * kMs).measured);
  EXPECT_EQ(motion.at(180 * kMs).sample.velocity_x, -50);
}

TEST(MotionInterpolator, ACutIsToldOnceWhenItIsPassed) {
  MotionInterpolator motion;
  motion.add(at(100 * kMs, 50), 20 * kMs);
  auto cut = gap(140 * kMs);
  cut.sample.flags = haptic::kMotionCut;
  motion.add(std::move(cut), 60 * kMs);
  EXPECT_FALSE(motion.at(139 * kMs).cut);
  EXPECT_TRUE(motion.at(140 * kMs).cut);
  EXPECT_FALSE(motion.at(141 * kMs).cut);
}

TEST(MotionInterpolator, ACutThatTheNextFrameReplacesIsToldAllTheSame) {
  MotionInterpolator motion;
  motion.add(at(kAtOnce, 50), 20 * kMs);
  motion.at(20 * kMs);
  auto cut = gap(kAtOnce);
  cut.sample.flags = haptic::kMotionCut;
  motion.add(std::move(cut), 60 * kMs);
  motion.add(at(kAtOnce, -50), 60 * kMs);
  EXPECT_TRUE(motion.at(60 * kMs).cut);
  EXPECT_FALSE(motion.at(61 * kMs).cut);
}

TEST(MotionInterpolator, AgeCountsFromWhenTheNewestFrameIsDue) {
  MotionInterpolator motion;
  motion.add(at(100 * kMs, 50), 60 * kMs); // due at 120 ms
  EXPECT_EQ(motion.at(110 * kMs).age, 0);
  EXPECT_NEAR(motion.at(150 * kMs).age, 0.03, 1e-9);
  motion.add(at(kAtOnce, 50), 200 * kMs);
  EXPECT_NEAR(motion.at(210 * kMs).age, 0.01, 1e-9);
  EXPECT_NEAR(motion.at(210 * kMs).interval, 0.04, 1e-9);
}

TEST(MotionInterpolator, FramesOfTwoSizesMeetInThePixelsOfTheNewer) {
  MotionInterpolator motion;
  motion.add({moving(100, 352), true, 100 * kMs}, 20 * kMs);
  motion.add({moving(200, 704), true, 140 * kMs}, 60 * kMs);
  for (std::int64_t t = 100; t <= 140; t += 10)
    EXPECT_NEAR(motion.at(t * kMs).sample.velocity_x, 200, 1e-3);
}

TEST(MotionInterpolator, AClockThatJumpsIsSurvivedAndCaughtUpWith) {
  for (const std::int64_t jump : {-100'000 * kMs, -1000 * kMs, 1000 * kMs, 100'000 * kMs}) {
    MotionInterpolator motion;
    std::int64_t now = 200'000 * kMs;
    for (int i = 0; i < 10; ++i, now += kFrame) {
      motion.add(at(now + kFrame, 100), now);
      motion.at(now);
    }
    now += jump;
    for (int i = 0; i < 10; ++i, now += kFrame) {
      motion.add(at(now + kFrame, -100), now);
      motion.at(now);
    }
    EXPECT_TRUE(motion.at(now).measured) << jump / kMs;
    EXPECT_NEAR(motion.at(now).sample.velocity_x, -100, 1e-4) << jump / kMs;
    EXPECT_LT(motion.at(now).age, 0.1) << jump / kMs;
  }
}

// Whatever the times, velocities stay between those that were given, and change without a step
// while the clock runs evenly.
TEST(MotionInterpolator, RandomTimesNeverGiveMoreThanWasMeasuredNorAStep) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> velocity(-100, 100);
  std::uniform_int_distribution<int> offset(-300, 500);
  MotionInterpolator motion;
  double before = 0;
  bool measured = false;
  for (int ms = 0; ms < 100'000; ++ms) {
    const std::int64_t now = ms * kMs;
    if (ms % 37 == 0)
      motion.add(at(random() % 5 ? now + offset(random) * kMs : kAtOnce, velocity(random)), now);
    const auto &felt = motion.at(now);
    ASSERT_LE(std::abs(felt.sample.velocity_x), 100 + 1e-3);
    if (measured && felt.measured) {
      ASSERT_LE(std::abs(felt.sample.velocity_x - before), 200.0 / 10 + 1e-3) << ms; // d/4 is 10 ms
    }
    before = felt.sample.velocity_x;
    measured = felt.measured;
  }
}

TEST(MotionInterpolator, MoreThanItCanKeepPushesOutTheOldest) {
  MotionInterpolator motion;
  for (int i = 0; i < 1000; ++i)
    motion.add(at((1000 + 15 * i) * kMs, i), (1000 + 15 * i - 2500) * kMs);
  EXPECT_NEAR(motion.at((1000 + 15 * 999) * kMs).sample.velocity_x, 999, 1e-2);
}

// ---- fields -------------------------------------------------------------------------------------

TEST(MotionInterpolator, OfAFieldItIsTheMotionUnderTheHand) {
  Fields fields;
  MotionInterpolator motion;
  motion.add(fields.halves(100 * kMs, 0, 100), 20 * kMs);
  motion.add(fields.halves(140 * kMs, -80, 300), 60 * kMs);
  EXPECT_NEAR(motion.at(110 * kMs, kLeft).sample.velocity_x, -20, 1e-3);
  EXPECT_NEAR(motion.at(110 * kMs, kRight).sample.velocity_x, 150, 1e-3);
  EXPECT_NEAR(motion.at(140 * kMs, kLeft).sample.velocity_x, -80, 1e-3);
}

TEST(MotionInterpolator, AHandThatWandersOverFieldsThatStandStillFeelsExactlyNothing) {
  Fields fields;
  MotionInterpolator motion;
  for (int ms = 0; ms < 400; ++ms) {
    if (ms % 40 == 0)
      motion.add(fields.halves(ms * kMs, 0, 0), ms * kMs);
    const auto &felt = motion.at(ms * kMs, {.x = 0.5 + 0.5 * std::sin(0.05 * ms)});
    ASSERT_TRUE(felt.measured);
    ASSERT_EQ(felt.sample.velocity_x, 0);
  }
}

TEST(MotionInterpolator, WhereAFieldIsSilentNothingIsMeasuredThere) {
  Fields fields;
  MotionInterpolator motion;
  motion.add(fields.halves(100 * kMs, 60, std::nullopt), 20 * kMs);
  motion.add(fields.halves(140 * kMs, 60, 90), 60 * kMs);
  motion.add(fields.halves(180 * kMs, 60, std::nullopt), 100 * kMs);
  EXPECT_TRUE(motion.at(120 * kMs, kLeft).measured);
  EXPECT_FALSE(motion.at(120 * kMs, kRight).measured);
  EXPECT_EQ(motion.at(120 * kMs, kRight).sample.confidence, 0);
  EXPECT_TRUE(motion.at(150 * kMs, kRight).measured); // held, as before any gap
  EXPECT_EQ(motion.at(150 * kMs, kRight).sample.velocity_x, 90);
  EXPECT_FALSE(motion.at(180 * kMs, kRight).measured);
}

TEST(MotionInterpolator, FieldsAndPointsMayFollowOneAnother) {
  Fields fields;
  MotionInterpolator motion;
  motion.add(fields.halves(100 * kMs, -100, 100), 20 * kMs);
  motion.add(at(140 * kMs, 0), 60 * kMs);
  motion.add(fields.halves(180 * kMs, 80, -80), 100 * kMs);
  EXPECT_NEAR(motion.at(120 * kMs, kLeft).sample.velocity_x, -50, 1e-3);
  EXPECT_NEAR(motion.at(120 * kMs, kRight).sample.velocity_x, 50, 1e-3);
  EXPECT_NEAR(motion.at(160 * kMs, kLeft).sample.velocity_x, 40, 1e-3);
  EXPECT_NEAR(motion.at(160 * kMs, kRight).sample.velocity_x, -40, 1e-3);
}

TEST(MotionInterpolator, FieldsOfTwoSizesMeetInThePixelsOfTheNewer) {
  Fields fields;
  MotionInterpolator motion;
  motion.add(fields.halves(100 * kMs, 100, 50, 352), 20 * kMs);
  motion.add(fields.halves(140 * kMs, 200, 100, 704), 60 * kMs);
  for (std::int64_t t = 100; t <= 140; t += 10) {
    EXPECT_NEAR(motion.at(t * kMs, kLeft).sample.velocity_x, 200, 1e-3);
    EXPECT_NEAR(motion.at(t * kMs, kRight).sample.velocity_x, 100, 1e-3);
  }
}

// Fields that stay with the interpolator could not be taken a thousand times.
TEST(MotionInterpolator, EveryFieldGoesBackToItsPool) {
  Fields fields;
  MotionInterpolator motion;
  std::mt19937 random(7);
  std::uniform_int_distribution<int> offset(-300, 2500);
  for (int ms = 0; ms < 40'000; ++ms) {
    const std::int64_t now = ms * kMs;
    if (ms % 15 == 0)
      motion.add(fields.halves(now + offset(random) * kMs, 10, 20), now);
    ASSERT_LE(std::abs(motion.at(now, kRight).sample.velocity_x), 20 + 1e-3);
    if (ms % 1777 == 0)
      motion.clear();
  }
}

} // namespace motion_interpolator_test
