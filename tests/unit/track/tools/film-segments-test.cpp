// SPDX-License-Identifier: LGPL-2.1-or-later
#include "package/film-segments.hpp"

#include "forms/klv.hpp"
#include "leaf-track.hpp"
#include "made-film.hpp"
#include "temporary-folder.hpp"
#include "track-error.hpp"

#include <gst/gst.h>
#include <gtest/gtest.h>
#include <set>

namespace film_segments_test {

using haptic::CodedField;
using haptic::FilmPlan;
using haptic::FilmSegment;
using test::FrameTime;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kFrame = kSecond / 10;

class FilmSegments : public testing::Test {
protected:
  void SetUp() override {
    gst_init(nullptr, nullptr);
    for (const char *element : {"parsebin", "qtdemux", "h264parse"}) {
      GstElementFactory *factory = gst_element_factory_find(element);
      if (!factory)
        GTEST_SKIP() << "needs the element " << element;
      gst_object_unref(factory);
    }
  }

  // A film of so many frames, ten a second, with key frames at some of them.
  void write(int count, const std::set<int> &keys) const {
    std::vector<FrameTime> times;
    for (int i = 0; i < count; ++i)
      times.push_back({i * kFrame, keys.contains(i)});
    test::write_film(path, times);
  }

  std::vector<FilmSegment> segments(const FilmPlan &plan,
                                    const std::vector<CodedField> &track = {}) const {
    std::vector<FilmSegment> all;
    haptic::for_each_segment(path, plan, track,
                             [&](const FilmSegment &segment) { all.push_back(segment); });
    return all;
  }

  const test::TemporaryFolder folder;
  const std::string path = folder.path_of("film.mp4");
};

std::set<int> each(int frames, int count) {
  std::set<int> keys;
  for (int i = 0; i < count; i += frames)
    keys.insert(i);
  return keys;
}

TEST_F(FilmSegments, TheyBeginAtKeyFramesAndLastTwoToSixSeconds) {
  constexpr int kCount = 200; // 20 s
  const std::set<int> uneven = {0, 10, 21, 79, 90, 130, 160};
  for (const auto &keys : {each(10, kCount), each(25, kCount), each(30, kCount), each(35, kCount),
                           each(50, kCount), uneven}) {
    write(kCount, keys);
    const FilmPlan plan = haptic::plan_film(path);
    EXPECT_EQ(plan.end, kCount * kFrame);
    std::int64_t next = 0;
    std::size_t frames = 0;
    for (const FilmSegment &segment : segments(plan)) {
      EXPECT_EQ(segment.start, next);
      EXPECT_GE(segment.end - segment.start, 2 * kSecond);
      EXPECT_LE(segment.end - segment.start, 6 * kSecond);
      ASSERT_FALSE(segment.frames.empty());
      EXPECT_TRUE(segment.frames[0].is_idr);
      EXPECT_EQ(segment.frames[0].presentation, haptic::ticks_of(segment.start));
      frames += segment.frames.size();
      next = segment.end;
    }
    EXPECT_EQ(next, plan.end);
    EXPECT_EQ(frames, std::size_t{kCount}) << "each frame once";
  }
}

TEST_F(FilmSegments, EachHasItsFieldsAndNeedsNoneBefore) {
  constexpr int kCount = 120;
  write(kCount, each(17, kCount));
  const auto track = test::leaf_track(kCount, kFrame);
  haptic::FieldDecoder whole;
  std::size_t count = 0;
  for (const FilmSegment &segment : segments(haptic::plan_film(path), track)) {
    ASSERT_EQ(segment.fields.size(), segment.frames.size());
    haptic::FieldDecoder alone;
    for (std::size_t i = 0; i < segment.fields.size(); ++i) {
      EXPECT_EQ(segment.fields[i].presentation, segment.frames[i].presentation);
      haptic::KlvReader sets(segment.fields[i].set);
      const CodedField field = coded_field_of(sets.next().value());
      ASSERT_EQ(alone.push(field.bytes), haptic::FieldDecoder::Result::field);
      ASSERT_EQ(whole.push(track.at(count++).bytes), haptic::FieldDecoder::Result::field);
      EXPECT_EQ(alone.field(), whole.field());
    }
  }
  EXPECT_EQ(count, track.size());
}

TEST_F(FilmSegments, FramesThatAreDecodedBeforeTheirTurnKeepTheirTimes) {
  std::vector<FrameTime> times;
  for (int group = 0; group < 10; ++group)
    for (const int i : {0, 3, 1, 2, 6, 4, 5, 9, 7, 8})
      times.push_back({(10 * group + i) * kFrame, i == 0});
  test::write_film(path, times);
  const FilmPlan plan = haptic::plan_film(path);
  EXPECT_EQ(plan.reordering, kFrame) << "the second of three is shown one turn before its own";
  std::size_t k = 0;
  for (const FilmSegment &segment : segments(plan))
    for (const auto &frame : segment.frames) {
      EXPECT_EQ(frame.presentation, haptic::ticks_of(times.at(k).presentation)) << k;
      EXPECT_EQ(frame.turn, haptic::ticks_of(static_cast<std::int64_t>(k++) * kFrame));
    }
  EXPECT_EQ(k, times.size());
}

TEST_F(FilmSegments, WhatStandsBeforeTheFirstKeyFrameIsLeftOut) {
  write(63, {3, 33});
  const auto all = segments(haptic::plan_film(path));
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].frames.size(), 60U);
  EXPECT_TRUE(all[0].frames[0].is_idr);
  EXPECT_EQ(all[0].frames[0].presentation, 0);
}

TEST_F(FilmSegments, AFilmWithoutAKeyFrameForAMinuteIsRefused) {
  for (const int count : {600, 650}) {
    write(count, {0});
    std::string refusal;
    try {
      haptic::plan_film(path);
    } catch (const haptic::TrackFileError &error) {
      refusal = error.what();
    }
    EXPECT_EQ(refusal, count <= 600 ? ""
                                    : haptic::format_text(haptic::messages::kFilmIsNotCut,
                                                          path.c_str(), 65.0));
  }
}

} // namespace film_segments_test
