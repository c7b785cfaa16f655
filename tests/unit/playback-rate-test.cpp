// SPDX-License-Identifier: LGPL-2.1-or-later
#include "playback-rate.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace {

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

TEST(PlaybackRate, AtTheFilmsOwnPaceNothingChanges) {
  for (const auto law : {RateLaw::as_seen, RateLaw::as_filmed})
    EXPECT_EQ(haptic::play(filmed(), {}, law), filmed());
}

TEST(PlaybackRate, AsSeenSlowMotionIsSofterAndFastMotionStronger) {
  for (const double rate : {0.25, 0.5, 2.0}) {
    const auto felt = haptic::play(filmed(), {.rate = rate}, RateLaw::as_seen);
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
    const auto felt = haptic::play(filmed(), {.rate = rate}, RateLaw::as_filmed);
    ASSERT_TRUE(felt);
    EXPECT_EQ(felt->velocity_x, 100);
    EXPECT_NEAR(static_cast<double>(felt->interval), 40e6 / rate, 1);
  }
}

// Upstream has squeezed the time stamps, so that the velocities already are as seen.
TEST(PlaybackRate, ARateThatUpstreamAppliedIsTakenOutOnlyAsFilmed) {
  const Playback twice{.applied_rate = 2};
  EXPECT_EQ(haptic::play(filmed(), twice, RateLaw::as_seen)->velocity_x, 100);
  EXPECT_EQ(haptic::play(filmed(), twice, RateLaw::as_filmed)->velocity_x, 50);
}

// The frames come in reverse order, so that what was measured is turned round already.
TEST(PlaybackRate, BackwardsKeepsTheDirectionThatIsSeen) {
  EXPECT_EQ(haptic::play(filmed(), {.rate = -0.5}, RateLaw::as_seen)->velocity_x, 50);
  EXPECT_EQ(haptic::play(filmed(), {.rate = -0.5}, RateLaw::as_filmed)->velocity_x, 100);
}

TEST(PlaybackRate, IsMuteBeyondTwiceThePaceAndWhereFramesAreLeftOut) {
  for (const Playback &playback :
       {Playback{.rate = 2.01}, Playback{.rate = -3}, Playback{.rate = 1.5, .applied_rate = 1.5},
        Playback{.skips = true}, Playback{.rate = 0},
        Playback{.rate = std::numeric_limits<double>::quiet_NaN()},
        Playback{.rate = std::numeric_limits<double>::infinity()}})
    EXPECT_FALSE(haptic::play(filmed(), playback, RateLaw::as_seen)) << playback.rate;
}

TEST(PlaybackRate, AFieldIsFeltAsASampleIsInEachOfItsCells) {
  for (const auto law : {RateLaw::as_seen, RateLaw::as_filmed})
    for (const Playback &playback :
         {Playback{}, Playback{.rate = 0.5}, Playback{.rate = -2}, Playback{.applied_rate = 2}}) {
      haptic::MotionField field{.interval = filmed().interval,
                                .cells = {{}, {filmed().velocity_x, filmed().velocity_y, 0.5F}}};
      const auto felt = haptic::play(filmed(), playback, law);
      ASSERT_TRUE(felt);
      ASSERT_TRUE(haptic::play(field, playback, law));
      EXPECT_EQ(field.interval, felt->interval);
      EXPECT_EQ(field.cells[1], (haptic::FieldCell{felt->velocity_x, felt->velocity_y, 0.5F}));
      EXPECT_EQ(field.cells[0], haptic::FieldCell{});
    }
  haptic::MotionField field;
  EXPECT_FALSE(haptic::play(field, {.rate = 3}, RateLaw::as_seen));
}

TEST(PlaybackRate, FilmedInTheSlowestMotionNothingOverflows) {
  EXPECT_FALSE(haptic::play(filmed(), {.applied_rate = 1e-300}, RateLaw::as_filmed));
}

TEST(PlaybackRate, AtHardlyAnyPaceNothingOverflows) {
  const auto felt = haptic::play(filmed(), {.rate = 1e-300}, RateLaw::as_seen);
  ASSERT_TRUE(felt);
  EXPECT_NEAR(felt->velocity_x, 0, 1e-9);
}

} // namespace
