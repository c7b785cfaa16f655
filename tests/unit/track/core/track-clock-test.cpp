// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track-clock.hpp"

#include <gtest/gtest.h>

namespace track_clock_test {

using haptic::kNoTime;
using haptic::kSecond;
using haptic::TrackClock;

TEST(TrackClock, BeginsAtTheStartOfTheSegment) {
  EXPECT_EQ(TrackClock().recovered(70 * kSecond, 5 * kSecond), 5 * kSecond);
}

TEST(TrackClock, MovesOnByTheSendersTimes) {
  TrackClock clock;
  clock.remember(10 * kSecond, 100 * kSecond, kSecond);
  EXPECT_EQ(clock.recovered(103 * kSecond, 0), 13 * kSecond);
  EXPECT_EQ(clock.recovered(98 * kSecond, 0), 8 * kSecond) << "also back";
  EXPECT_EQ(clock.recovered(100 * kSecond, 0), 10 * kSecond);
}

TEST(TrackClock, AJumpIsASenderThatWasStartedAnew) {
  TrackClock clock;
  clock.remember(10 * kSecond, 100 * kSecond, kSecond / 2);
  EXPECT_EQ(clock.recovered(111 * kSecond, 0), 10 * kSecond + kSecond / 2);
  EXPECT_EQ(clock.recovered(0, 0), 10 * kSecond + kSecond / 2);
  clock.remember(2 * kSecond, 100 * kSecond, kSecond / 2);
  EXPECT_EQ(clock.recovered(97 * kSecond, 0), 2 * kSecond + kSecond / 2)
      << "no time stamp is below 0";
}

TEST(TrackClock, ALongSampleCountsOneSecond) {
  TrackClock clock;
  clock.remember(0, 0, 3600 * kSecond);
  EXPECT_EQ(clock.recovered(99 * kSecond, 0), kSecond);
  clock.remember(0, 0, kNoTime);
  EXPECT_EQ(clock.recovered(99 * kSecond, 0), 0U);
}

TEST(TrackClock, SamplesWithoutATimeStampChangeNothing) {
  TrackClock clock;
  clock.remember(10 * kSecond, 100 * kSecond, 0);
  clock.remember(kNoTime, 200 * kSecond, 0);
  EXPECT_EQ(clock.recovered(101 * kSecond, 0), 11 * kSecond);
  clock.forget();
  EXPECT_EQ(clock.recovered(101 * kSecond, 0), 0U);
}

TEST(TrackClock, ATrackHasLostItsTimesOnceItHadNoneForTwoSeconds) {
  TrackClock clock;
  EXPECT_FALSE(clock.is_waiting()) << "nothing has come";
  EXPECT_FALSE(clock.wait_for_tie(5 * kSecond));
  EXPECT_FALSE(clock.wait_for_tie(6 * kSecond));
  EXPECT_TRUE(clock.wait_for_tie(7 * kSecond));
  EXPECT_TRUE(clock.is_waiting());
  clock.remember(0, 8 * kSecond, 0);
  EXPECT_TRUE(clock.is_tied());
  EXPECT_FALSE(clock.is_waiting());
}

TEST(TrackClock, ATimeThatGoesBackIsNoWait) {
  TrackClock clock;
  EXPECT_FALSE(clock.wait_for_tie(5 * kSecond));
  EXPECT_FALSE(clock.wait_for_tie(4 * kSecond));
  EXPECT_TRUE(clock.wait_for_tie(6 * kSecond));
}

} // namespace track_clock_test
