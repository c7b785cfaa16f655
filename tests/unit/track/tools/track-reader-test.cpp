// SPDX-License-Identifier: LGPL-2.1-or-later
// The times of samples, of a stream whose packets lost some of their time stamps and of a file that
// has none, and what is said of damage.
#include "tracks/track-reader.hpp"

#include "forms/klv.hpp"
#include "forms/text-line.hpp"
#include "track-samples.hpp"

#include <gtest/gtest.h>

namespace track_reader_test {

using haptic::kNoTime;
using haptic::kSecond;
using haptic::TrackFile;
using haptic::TrackSample;

constexpr std::uint64_t kFrame = kSecond / 30;
constexpr std::uint64_t kSent = 100 * kSecond; // the sender's time of the first sample

// Pushes samples at each frame. Of those in [from, to), the packets have no time stamp.
TrackFile track_without(std::size_t from, std::size_t to, std::size_t count) {
  TrackFile track;
  haptic::TrackReader stream(haptic::make_klv_form(), track);
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

TEST(TrackReader, TimeStampsAreTheTimes) {
  const TrackFile track = track_without(0, 0, 100);
  ASSERT_EQ(track.samples.size(), 100U);
  expect_times(track, 5 * kSecond);
  EXPECT_TRUE(track.remarks.empty());
}

// Those before the first clock of a transport stream that was cut, for more than two seconds.
TEST(TrackReader, PacketsBeforeTheFirstTimeStampGetTheirs) {
  const TrackFile track = track_without(0, 90, 100);
  ASSERT_EQ(track.samples.size(), 100U);
  expect_times(track, 5 * kSecond);
  EXPECT_TRUE(track.remarks.empty()) << "nothing is lost";
}

TEST(TrackReader, PacketsBetweenTimeStampsGetTheirsAndItIsSaid) {
  const TrackFile track = track_without(20, 80, 100);
  ASSERT_EQ(track.samples.size(), 100U);
  expect_times(track, 5 * kSecond);
  EXPECT_EQ(track.remarks, std::vector<std::string>{haptic::messages::kTrackHasNoTimes});
  EXPECT_FALSE(track.is_untied);
}

TEST(TrackReader, WithoutAnyTimeStampItBeginsAtZeroAndItIsSaid) {
  const TrackFile track = track_without(0, 100, 100);
  ASSERT_EQ(track.samples.size(), 100U);
  expect_times(track, 0);
  EXPECT_EQ(track.remarks, std::vector<std::string>{haptic::messages::kTrackIsUntied});
  EXPECT_TRUE(track.is_untied);
}

TEST(TrackReader, WithoutAnyTimeStampASenderThatBeginsAnewDoesNotTurnTheTimesBack) {
  TrackFile track;
  haptic::TrackReader stream(haptic::make_klv_form(), track);
  for (const std::uint64_t begin : {kSent, kSent - 3 * kSecond})
    for (std::size_t i = 0; i < 60; ++i) {
      TrackSample sample = test::TrackSamples(1).next();
      sample.time = begin + i * kFrame;
      const auto bytes = haptic::write_klv(sample);
      stream.push({bytes, kNoTime, kNoTime});
    }
  stream.finish();
  ASSERT_EQ(track.samples.size(), 120U);
  EXPECT_EQ(track.samples[0].time, 0U);
  for (std::size_t i = 1; i < 120; ++i)
    EXPECT_GE(track.samples[i].time, track.samples[i - 1].time) << i;
}

TEST(TrackReader, SamplesOfAFileKeepTheirOwnTimes) {
  TrackFile track;
  haptic::TrackReader reader(haptic::make_text_form(), track, "line ");
  test::TrackSamples samples(1);
  for (std::size_t i = 0; i < 3; ++i) {
    TrackSample sample = samples.next();
    sample.time = kSent + i * kFrame;
    const std::string line = haptic::write_text_line(sample);
    reader.push({{reinterpret_cast<const std::uint8_t *>(line.data()), line.size()}}, i + 1);
  }
  reader.finish();
  ASSERT_EQ(track.samples.size(), 3U);
  expect_times(track, kSent);
  EXPECT_TRUE(track.remarks.empty());
}

TEST(TrackReader, SomeDamageOfAFileIsNamedAndTheRestCounted) {
  TrackFile track;
  haptic::TrackReader reader(haptic::make_text_form(), track, "line ");
  const std::string line = "hv1 nothing";
  for (std::size_t i = 1; i <= 8; ++i)
    reader.push({{reinterpret_cast<const std::uint8_t *>(line.data()), line.size()}}, i);
  reader.finish();
  EXPECT_EQ(reader.damage(), 8U);
  ASSERT_EQ(track.remarks.size(), 6U);
  EXPECT_EQ(track.remarks[4].substr(0, 8), "line 5: ");
  EXPECT_EQ(track.remarks[5], "3 further ones were left out");
}

} // namespace track_reader_test
