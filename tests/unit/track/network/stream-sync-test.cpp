// SPDX-License-Identifier: LGPL-2.1-or-later
#include "network/stream-sync.hpp"

#include <gtest/gtest.h>

namespace stream_sync_test {

using haptic::kMostApart;
using haptic::StreamSync;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kWall = 4'000'000'000'000'000'000; // the sender's wall clock at its start
constexpr std::uint32_t kRtp[] = {4'294'960'000, 1000};   // random, and one wraps around at once
constexpr std::int64_t kLatency = 30;                     // for which packets are waited, ms

// Picture (session 0) and track (session 1) of one sender. Its clocks show the same instant, in ms.
struct Streams {
  StreamSync sync;
  std::int64_t step = 0; // of the sender's wall clock, ms

  static std::uint32_t rtp(unsigned session, std::int64_t instant) {
    return kRtp[session] + static_cast<std::uint32_t>(instant * 90);
  }
  void report(unsigned session, std::int64_t instant, const char *sender = "pc") {
    sync.report(session,
                {sender, 7 + session, rtp(session, instant), kWall + (instant + step) * kMs});
  }
  void report_both(std::int64_t instant) {
    report(0, instant);
    report(1, instant);
  }
  // The packet came after `way` ms, and the jitter buffer of this stream would play it after
  // `planned` ms.
  std::int64_t play(unsigned session, std::int64_t instant, std::int64_t way,
                    std::int64_t planned) {
    return sync.time_of(session, {7 + session, rtp(session, instant), 90'000,
                                  (instant + planned) * kMs, (instant + way - kLatency) * kMs});
  }
  std::int64_t play(unsigned session, std::int64_t instant, std::int64_t way) {
    return play(session, instant, way, way);
  }
};

TEST(StreamSync, BeforeBothStreamsAreReportedTheJitterBufferIsRight) {
  Streams streams;
  EXPECT_EQ(streams.play(0, 0, 50), 50 * kMs);
  streams.report(0, 0);
  EXPECT_EQ(streams.play(0, 33, 50), 83 * kMs);
  EXPECT_EQ(streams.play(1, 33, 20), 53 * kMs);
}

TEST(StreamSync, TheSameInstantIsPlayedAtTheSameTimeAfterTheLongestWay) {
  Streams streams;
  streams.report_both(0);
  streams.play(0, 0, 50);
  for (std::int64_t instant = 0; instant < 60'000; instant += 33) { // the time stamps wrap around
    EXPECT_EQ(streams.play(1, instant, 20), (instant + 50) * kMs);
    EXPECT_EQ(streams.play(0, instant, 50), (instant + 50) * kMs);
  }
}

TEST(StreamSync, AJitterBufferThatAStallHasResetMovesNothing) {
  Streams streams;
  streams.report_both(0);
  for (std::int64_t instant = 0; instant < 20'000; instant += 33) {
    const std::int64_t stall = instant < 10'000 ? 0 : std::max<std::int64_t>(0, 10'400 - instant);
    const std::int64_t reset =
        instant < 10'000 ? 0 : std::max<std::int64_t>(0, 11'800 - instant) / 4;
    streams.play(0, instant, 50 + stall, 50);
    EXPECT_EQ(streams.play(1, instant, 20 + stall, 20 + reset), (instant + 50) * kMs) << instant;
  }
}

TEST(StreamSync, AWayThatStaysLongerIsFollowedAfterHalfASecond) {
  Streams streams;
  streams.report_both(0);
  for (std::int64_t instant = 0; instant < 20'000; instant += 100) {
    const std::int64_t longer = instant < 10'000 ? 0 : 400;
    streams.play(0, instant, 50 + longer);
    const std::int64_t played = streams.play(1, instant, 20 + longer);
    EXPECT_EQ(played, (instant + 50 + (instant < 10'400 ? 0 : longer)) * kMs) << instant;
  }
}

TEST(StreamSync, AWallClockThatIsSetMovesNothingOnceBothStreamsAreReported) {
  Streams streams;
  streams.report_both(0);
  streams.play(0, 0, 50);
  streams.play(1, 0, 20);
  for (const std::int64_t step : {-700, 1300}) {
    streams.step = step;
    streams.report_both(1000);
    EXPECT_EQ(streams.play(1, 1033, 20), 1083 * kMs);
    EXPECT_EQ(streams.play(0, 1033, 50), 1083 * kMs);
  }
}

TEST(StreamSync, StreamsOfTwoSendersStayAsTheyAre) {
  Streams streams;
  streams.report(0, 0, "one");
  streams.step = 400;
  streams.report(1, 0, "other");
  EXPECT_EQ(streams.play(0, 0, 50), 50 * kMs);
  EXPECT_EQ(streams.play(1, 0, 20), 20 * kMs);
}

TEST(StreamSync, ClocksThatHaveNothingInCommonStayAsTheyAre) {
  Streams streams;
  streams.report(0, 0);
  streams.step = kMostApart / kMs + 100;
  streams.report(1, 0);
  EXPECT_EQ(streams.play(0, 0, 50), 50 * kMs);
  EXPECT_EQ(streams.play(1, 0, 20), 20 * kMs);
  EXPECT_EQ(streams.play(0, 33, 50), 83 * kMs);
}

TEST(StreamSync, AStreamThatHasEndedHoldsNothingBack) {
  Streams streams;
  streams.report_both(0);
  streams.play(0, 0, 50);
  EXPECT_EQ(streams.play(1, 0, 20), 50 * kMs);
  EXPECT_EQ(streams.play(1, 4000, 20), 4020 * kMs);
}

TEST(StreamSync, ARestartedSenderIsNotMeasuredByTheReportsOfTheOneBefore) {
  Streams streams;
  streams.report_both(0);
  streams.play(0, 0, 50);
  EXPECT_EQ(streams.sync.time_of(1, {99, 5, 90'000, 123, 0}), 123);
  EXPECT_EQ(streams.sync.time_of(1, {8, 5, 0, 123, 0}), 123); // no clock rate
}

} // namespace stream_sync_test
