// SPDX-License-Identifier: LGPL-2.1-or-later
// The times of the samples of a stream whose packets lost some of their time stamps.
#include "tracks/stream-track.hpp"

#include "forms/klv.hpp"
#include "track-samples.hpp"

#include <gtest/gtest.h>

namespace stream_track_test {

using haptic::kNoTime;
using haptic::kSecond;
using haptic::TrackFile;
using haptic::TrackSample;

constexpr std::uint64_t kFrame = kSecond / 30;
constexpr std::uint64_t kSent = 100 * kSecond; // the sender's time of the first sample

// Pushes samples at each frame. Of those in [from, to), the packets have no time stamp.
TrackFile track_without(std::size_t from, std::size_t to, std::size_t count) {
  TrackFile track;
  haptic::StreamTrack stream(haptic::make_klv_form(), track);
  for (std::size_t i = 0; i < count; ++i) {
    TrackSample sample = test::TrackSamples(1).next();
    sample.time = kSent + i * kFrame;
    sample.duration = kFrame;
    const auto bytes = haptic::write_klv(sample);
    stream.push({bytes, i >= from && i < to ? kNoTime : 5 * kSecond + i * kFrame, kNoTime});
  }
  stream.finish();
  return track;
}

void expect_times(const TrackFile &track, std::uint64_t first) {
  for (std::size_t i = 0; i < track.samples.size(); ++i)
    EXPECT_NEAR(static_cast<double>(track.samples[i].time), static_cast<double>(first + i * kFrame),
                1e3)
        << i;
}

void expect_one_remark(const TrackFile &track, haptic::TrackProblemKind kind) {
  ASSERT_EQ(track.remarks.size(), 1U);
  EXPECT_EQ(std::get<haptic::TrackProblemKind>(track.remarks[0].kind), kind);
}

TEST(StreamTrack, TimeStampsAreTheTimes) {
  const TrackFile track = track_without(0, 0, 100);
  ASSERT_EQ(track.samples.size(), 100U);
  expect_times(track, 5 * kSecond);
  EXPECT_TRUE(track.remarks.empty());
}

// Those before the first clock of a transport stream that was cut, for more than two seconds.
TEST(StreamTrack, PacketsBeforeTheFirstTimeStampGetTheirs) {
  const TrackFile track = track_without(0, 90, 100);
  ASSERT_EQ(track.samples.size(), 100U);
  expect_times(track, 5 * kSecond);
  EXPECT_TRUE(track.remarks.empty()) << "nothing is lost";
}

TEST(StreamTrack, PacketsBetweenTimeStampsGetTheirsAndItIsSaid) {
  const TrackFile track = track_without(20, 80, 100);
  ASSERT_EQ(track.samples.size(), 100U);
  expect_times(track, 5 * kSecond);
  expect_one_remark(track, haptic::TrackProblemKind::without_time);
}

TEST(StreamTrack, WithoutAnyTimeStampItBeginsAtZeroAndItIsSaid) {
  const TrackFile track = track_without(0, 100, 100);
  ASSERT_EQ(track.samples.size(), 100U);
  expect_times(track, 0);
  expect_one_remark(track, haptic::TrackProblemKind::untied);
}

} // namespace stream_track_test
