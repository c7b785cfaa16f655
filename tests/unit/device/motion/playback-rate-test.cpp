// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/playback-rate.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <optional>

namespace playback_rate_test {

using haptic::Playback;
using haptic::RateLaw;

haptic::MotionSample filmed() {
  haptic::MotionSample sample;
  sample.velocity_x = 100;
  sample.velocity_y = -50;
  sample.spin = 1;
  sample.divergence = 0.5;
  sample.interval = 40'000'000;
  sample.confidence = 1;
  return sample;
}

std::optional<haptic::MotionSample> play(const haptic::MotionSample &sample,
                                         const Playback &playback, RateLaw law) {
  haptic::TimedMotion motion{sample, true};
  if (!haptic::apply_playback(motion, playback, law))
    return std::nullopt;
  return motion.sample;
}

TEST(PlaybackRate, AtTheFilmsOwnPaceNothingChanges) {
  for (const auto law : {RateLaw::as_seen, RateLaw::as_filmed})
    EXPECT_EQ(play(filmed(), {}, law), filmed());
}

TEST(PlaybackRate, AsSeenSlowMotionIsSofterAndFastMotionStronger) {
  for (const double rate : {0.25, 0.5, 2.0}) {
    const auto felt = play(filmed(), {.rate = rate}, RateLaw::as_seen);
    ASSERT_TRUE(felt);
    EXPECT_NEAR(felt->velocity_x, 100 * rate, 1e-4);
    EXPECT_NEAR(felt->velocity_y, -50 * rate, 1e-4);
    EXPECT_NEAR(felt->spin, rate, 1e-6);
    EXPECT_NEAR(felt->divergence, 0.5 * rate, 1e-6);
    EXPECT_NEAR(static_cast<double>(felt->interval), 40e6 / rate, 1);
  }
}

TEST(PlaybackRate, AsFilmedThePaceDoesNotMatter) {
  for (const double rate : {0.25, 0.5, 2.0}) {
    const auto felt = play(filmed(), {.rate = rate}, RateLaw::as_filmed);
    ASSERT_TRUE(felt);
    EXPECT_EQ(felt->velocity_x, 100);
    EXPECT_NEAR(static_cast<double>(felt->interval), 40e6 / rate, 1);
  }
}

// Upstream has squeezed the time stamps, so that the velocities already are as seen.
TEST(PlaybackRate, ARateThatUpstreamAppliedIsTakenOutOnlyAsFilmed) {
  const Playback twice{.applied_rate = 2};
  EXPECT_EQ(play(filmed(), twice, RateLaw::as_seen)->velocity_x, 100);
  EXPECT_EQ(play(filmed(), twice, RateLaw::as_filmed)->velocity_x, 50);
}

// The frames come in reverse order, so that what was measured is turned round already.
TEST(PlaybackRate, BackwardsKeepsTheDirectionThatIsSeen) {
  EXPECT_EQ(play(filmed(), {.rate = -0.5}, RateLaw::as_seen)->velocity_x, 50);
  EXPECT_EQ(play(filmed(), {.rate = -0.5}, RateLaw::as_filmed)->velocity_x, 100);
}

TEST(PlaybackRate, IsMuteBeyondTwiceThePaceAndWhereFramesAreLeftOut) {
  for (const Playback &playback :
       {Playback{.rate = 2.01}, Playback{.rate = -3}, Playback{.rate = 1.5, .applied_rate = 1.5},
        Playback{.skips = true}, Playback{.rate = 0},
        Playback{.rate = std::numeric_limits<double>::quiet_NaN()},
        Playback{.rate = std::numeric_limits<double>::infinity()}})
    EXPECT_FALSE(play(filmed(), playback, RateLaw::as_seen)) << playback.rate;
}

TEST(PlaybackRate, AFieldIsFeltAsASampleIsInEachOfItsCells) {
  for (const auto law : {RateLaw::as_seen, RateLaw::as_filmed})
    for (const Playback &playback :
         {Playback{}, Playback{.rate = 0.5}, Playback{.rate = -2}, Playback{.applied_rate = 2}}) {
      const auto pool = std::make_unique<haptic::FieldPool>();
      haptic::TimedMotion motion;
      motion.sample.interval = filmed().interval;
      motion.field = pool->acquire();
      motion.field->cells = {{}, {filmed().velocity_x, filmed().velocity_y, 0.5F}};
      const auto felt = play(filmed(), playback, law);
      ASSERT_TRUE(felt);
      ASSERT_TRUE(haptic::apply_playback(motion, playback, law));
      EXPECT_EQ(motion.field->interval, felt->interval);
      EXPECT_EQ(motion.sample.interval, felt->interval);
      EXPECT_EQ(motion.field->cells[1],
                (haptic::FieldCell{felt->velocity_x, felt->velocity_y, 0.5F}));
      EXPECT_EQ(motion.field->cells[0], haptic::FieldCell{});
    }
}

TEST(PlaybackRate, FilmedInTheSlowestMotionNothingOverflows) {
  EXPECT_FALSE(play(filmed(), {.applied_rate = 1e-300}, RateLaw::as_filmed));
}

TEST(PlaybackRate, AtHardlyAnyPaceNothingOverflows) {
  const auto felt = play(filmed(), {.rate = 1e-300}, RateLaw::as_seen);
  ASSERT_TRUE(felt);
  EXPECT_NEAR(felt->velocity_x, 0, 1e-9);
}

} // namespace playback_rate_test
