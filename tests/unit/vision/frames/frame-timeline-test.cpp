// SPDX-License-Identifier: LGPL-2.1-or-later
#include "frames/frame-timeline.hpp"

#include <gtest/gtest.h>

namespace frame_timeline_test {

using haptic::FrameTimeline;
using haptic::TimeStep;
using Kind = haptic::TimeStep::Kind;

constexpr std::uint64_t kMs = 1'000'000;

// A frame that becomes the reference, as all but duplicates do.
TimeStep next(FrameTimeline &timeline, std::optional<std::uint64_t> ms, bool descending = false) {
  const TimeStep step = timeline.advance(ms ? std::optional(*ms * kMs) : std::nullopt, descending);
  if (step.kind != Kind::repeats)
    timeline.adopt();
  return step;
}

TEST(FrameTimeline, TheIntervalIsTheDifferenceOfTheTimeStamps) {
  FrameTimeline timeline;
  EXPECT_EQ(next(timeline, 100).kind, Kind::restarts);
  const TimeStep step = next(timeline, 133);
  EXPECT_EQ(step.kind, Kind::follows);
  EXPECT_EQ(step.interval, 33 * kMs);
  EXPECT_EQ(step.fault, nullptr);
}

TEST(FrameTimeline, ASkippedReferenceMakesTheNextIntervalSpanBoth) {
  FrameTimeline timeline;
  next(timeline, 100);
  EXPECT_EQ(timeline.advance(133 * kMs, false).interval, 33 * kMs); // not adopted: a duplicate
  EXPECT_EQ(next(timeline, 166).interval, 66 * kMs);
  EXPECT_EQ(next(timeline, 200).interval, 34 * kMs);
}

TEST(FrameTimeline, PlayedBackwardsTheTimeStampsFall) {
  FrameTimeline timeline;
  next(timeline, 1000, true);
  const TimeStep step = next(timeline, 960, true);
  EXPECT_EQ(step.kind, Kind::follows);
  EXPECT_EQ(step.interval, 40 * kMs);
}

TEST(FrameTimeline, ATimeStampAgainstTheDirectionOfPlayIsAFaultAndStartsAnew) {
  FrameTimeline timeline;
  next(timeline, 100);
  next(timeline, 140);
  const TimeStep back = next(timeline, 60);
  EXPECT_EQ(back.kind, Kind::restarts);
  EXPECT_NE(back.fault, nullptr);
  EXPECT_EQ(next(timeline, 100).interval, 40 * kMs);
}

TEST(FrameTimeline, EqualTimeStampsMeasureNothingAndCostNothing) {
  FrameTimeline timeline;
  next(timeline, 100);
  const TimeStep same = next(timeline, 100);
  EXPECT_EQ(same.kind, Kind::repeats);
  EXPECT_NE(same.fault, nullptr);
  EXPECT_EQ(next(timeline, 140).interval, 40 * kMs);
}

TEST(FrameTimeline, WithoutATimeStampEverythingBeforeIsForgotten) {
  FrameTimeline timeline;
  next(timeline, 100);
  EXPECT_NE(next(timeline, std::nullopt).fault, nullptr);
  EXPECT_EQ(next(timeline, 140).kind, Kind::restarts);
  EXPECT_EQ(next(timeline, 180).kind, Kind::follows);
}

TEST(FrameTimeline, APauseOfMoreThanTwoSecondsIsNoMotion) {
  FrameTimeline timeline;
  next(timeline, 0);
  next(timeline, 40);
  EXPECT_EQ(next(timeline, 2041).kind, Kind::restarts);
}

TEST(FrameTimeline, SlowStreamsAreMeasuredAtTheirOwnPace) {
  FrameTimeline timeline;
  std::uint64_t time = 0;
  next(timeline, time);
  for (const std::uint64_t interval : {330U, 730U, 400U, 533U, 1990U})
    EXPECT_EQ(next(timeline, time += interval).interval, interval * kMs);
  // Every five seconds: the first one is a pause, then it is the pace.
  EXPECT_EQ(next(timeline, time += 25'000).kind, Kind::restarts);
  EXPECT_EQ(next(timeline, time += 25'000).interval, 25'000 * kMs);
}

TEST(FrameTimeline, ForgetsOnDemand) {
  FrameTimeline timeline;
  next(timeline, 0);
  timeline.forget();
  EXPECT_EQ(next(timeline, 40).kind, Kind::restarts);
}

} // namespace frame_timeline_test
