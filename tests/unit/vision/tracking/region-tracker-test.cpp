// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracking/region-tracker.hpp"

#include "moving-texture.hpp"
#include "tracking/tracking-statistics.hpp"

#include <algorithm>
#include <chrono>
#include <gtest/gtest.h>
#include <thread>
#include <utility>
#include <vector>

namespace region_tracker_test {

using haptic::Areas;
using haptic::Finding;
using haptic::is_identical;
using haptic::LumaView;
using haptic::Rectangle;
using haptic::RegionTracker;
using haptic::TrackerMethod;
using test::Frame;

constexpr int kWidth = 96;
constexpr int kHeight = 80;
constexpr Rectangle kRegion{33, 25, 30, 30};

// A frame whose luma is a plane of its own, or must be converted.
class Source final : public haptic::LumaSource {
public:
  explicit Source(const Frame &frame, bool is_plane = true) : frame_(frame), is_plane_(is_plane) {}

  LumaView plane(const Rectangle &area) const override {
    return is_plane_ ? view(area) : LumaView{};
  }
  void convert(const Rectangle &area, std::uint8_t *to, std::ptrdiff_t stride) const override {
    const auto begin = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - begin < pause) {
    }
    for (int y = 0; y < area.height; ++y)
      std::copy_n(view(area).pixels + y * frame_.width, area.width, to + y * stride);
    converted += area.width * area.height;
    time += std::chrono::steady_clock::now() - begin;
  }

  std::chrono::milliseconds pause{0};
  mutable int converted = 0; // px
  mutable std::chrono::nanoseconds time{0};

private:
  LumaView view(const Rectangle &area) const {
    return {frame_.pixels.data() + area.y * frame_.width + area.x, area.width, area.height,
            frame_.width};
  }

  const Frame &frame_;
  bool is_plane_;
};

class RegionTrackerTest : public ::testing::Test {
protected:
  Frame moved(double x, double y) const { return texture.frame(kWidth, kHeight, {x, y}); }

  Finding compare(const Frame &earlier, const Frame &frame, const Rectangle &region = kRegion) {
    tracker.clear_measurement();
    return tracker.compare(Source(earlier), Source(frame), tracker.areas(region, kWidth, kHeight));
  }

  // Returns the pixels of the two frames that were converted.
  std::pair<int, int> converted(const Frame &earlier, const Frame &frame,
                                const Rectangle &region = kRegion) {
    const Source before(earlier, false);
    const Source after(frame, false);
    tracker.compare(before, after, tracker.areas(region, kWidth, kHeight));
    return {before.converted, after.converted};
  }

  int crop_size(const Rectangle &region = kRegion) const {
    const Rectangle crop = tracker.areas(region, kWidth, kHeight).crop;
    return crop.width * crop.height;
  }

  test::Texture texture{1};
  RegionTracker tracker;
};

TEST_F(RegionTrackerTest, MeasuresTheMotionBetweenTwoFramesWithEachMethod) {
  for (const auto method : {TrackerMethod::fast, TrackerMethod::opencv, TrackerMethod::layers}) {
    tracker.set_method(method, 10);
    const Finding found = compare(moved(0, 0), moved(2, -1));
    EXPECT_EQ(found.flags, 0);
    EXPECT_TRUE(found.becomes_reference);
    EXPECT_TRUE(found.time.has_value());
    ASSERT_GT(tracker.measurement().count, 0);
    EXPECT_LE(tracker.measurement().count, 10);
    for (const auto &patch : tracker.measurement().view()) {
      EXPECT_NEAR(patch.dx, 2, 0.1);
      EXPECT_NEAR(patch.dy, -1, 0.1);
    }
  }
}

TEST_F(RegionTrackerTest, TheCropIsTheRegionWithAMarginInsideTheFrame) {
  const Areas areas = tracker.areas(kRegion, kWidth, kHeight);
  EXPECT_EQ(areas.region, kRegion);
  EXPECT_LT(areas.crop.x, kRegion.x);
  EXPECT_GT(areas.crop.width, kRegion.width);
  const Areas corner = tracker.areas({0, 0, 20, 20}, kWidth, kHeight);
  EXPECT_EQ(corner.crop.x, 0);
  EXPECT_EQ(corner.crop.y, 0);
}

TEST_F(RegionTrackerTest, ARepeatedFrameIsADuplicateThatDoesNotBecomeTheReference) {
  const Frame first = moved(0, 0);
  const Frame second = moved(2, 0);
  EXPECT_EQ(compare(first, second).flags, 0);
  const Finding found = compare(second, second);
  EXPECT_EQ(found.flags, haptic::kMotionDuplicate);
  EXPECT_FALSE(found.becomes_reference);
  EXPECT_FALSE(found.time.has_value());
  EXPECT_EQ(tracker.measurement().count, 0);
}

TEST_F(RegionTrackerTest, AFrameThatRepeatsAThirdTimeStandsStill) {
  const Frame frame = moved(0, 0);
  EXPECT_EQ(compare(frame, frame).flags, haptic::kMotionDuplicate);
  EXPECT_EQ(compare(frame, frame).flags, haptic::kMotionDuplicate);
  const Finding found = compare(frame, frame);
  EXPECT_EQ(found.flags, haptic::kMotionStill);
  EXPECT_TRUE(found.becomes_reference);
}

// The pixels under the pointer are the same in both frames, but those where motion was seen are
// not.
TEST_F(RegionTrackerTest, ARegionAtRestBesideAMovingOneStandsStillAtOnce) {
  constexpr Rectangle kLeft{10, 25, 20, 30};
  constexpr Rectangle kRight{66, 25, 20, 30};
  const auto half_moved = [&](double x) {
    Frame frame = moved(0, 0);
    const Frame other = moved(x, 0);
    for (int row = 0; row < kHeight; ++row)
      std::copy_n(other.pixels.begin() + row * kWidth, kWidth / 2,
                  frame.pixels.begin() + row * kWidth);
    return frame;
  };
  EXPECT_EQ(compare(half_moved(0), half_moved(1), kLeft).flags, 0);
  EXPECT_EQ(compare(half_moved(1), half_moved(2), kRight).flags, haptic::kMotionStill);
}

// Of a format that is converted, the pixels where motion was seen take the place of the region's.
TEST_F(RegionTrackerTest, ARegionAtRestIsNotMeasuredByThePixelsThatMovedElsewhere) {
  constexpr int kWide = 400;
  constexpr Rectangle kFar{10, 25, 30, 30};
  constexpr Rectangle kHere{340, 25, 30, 30};
  std::vector<Frame> film;
  for (int i = 0; i < 5; ++i) {
    film.push_back(texture.frame(kWide, kHeight, {}));
    texture.paint(film.back(), {1.0 * i, 0}, 0, kWide / 2);
  }
  for (std::size_t i = 1; i < film.size(); ++i) {
    const bool is_here = i + 1 == film.size();
    const Finding found = tracker.compare(Source(film[i - 1], false), Source(film[i], false),
                                          tracker.areas(is_here ? kHere : kFar, kWide, kHeight));
    EXPECT_EQ(found.flags, is_here ? haptic::kMotionStill : found.flags & haptic::kTiled) << i;
  }
}

// The layers read patches of the frame, too.
TEST_F(RegionTrackerTest, ThePixelsOfACropAreConvertedOnce) {
  tracker.set_method(TrackerMethod::fast, haptic::kUsualPatches);
  const int all = crop_size();
  EXPECT_EQ(converted(moved(0, 0), moved(1, 0)), std::pair(all, all));
  EXPECT_EQ(converted(moved(1, 0), moved(2, 0)), std::pair(0, all)) << "the earlier one was kept";
  EXPECT_EQ(converted(moved(2, 0), moved(2, 0)), std::pair(0, all)) << "a duplicate";
  EXPECT_EQ(converted(moved(2, 0), moved(3, 0)), std::pair(0, all)) << "the earlier one still is";
  constexpr Rectangle kRight{37, 25, 30, 30};
  const auto [earlier, later] = converted(moved(3, 0), moved(4, 0), kRight);
  EXPECT_LE(earlier, 4 * kHeight) << "only what came into the crop";
  EXPECT_EQ(later, crop_size(kRight));
  tracker.skip();
  EXPECT_EQ(converted(moved(5, 0), moved(6, 0)), std::pair(all, all)) << "of another frame";
  tracker.forget();
  EXPECT_EQ(converted(moved(7, 0), moved(8, 0)), std::pair(all, all)) << "of another scene";
}

TEST_F(RegionTrackerTest, TheTimeOfAMeasurementContainsThatOfTheConversion) {
  const Frame first = moved(0, 0);
  const Frame second = moved(1, 0);
  Source before(first, false);
  Source after(second, false);
  before.pause = after.pause = std::chrono::milliseconds(5);
  const Finding found = tracker.compare(before, after, tracker.areas(kRegion, kWidth, kHeight));
  ASSERT_TRUE(found.time.has_value());
  EXPECT_GE(*found.time, before.time + after.time);
}

TEST_F(RegionTrackerTest, AfterForgettingASceneMayBeginWithDuplicates) {
  const Frame frame = moved(0, 0);
  for (int i = 0; i < 3; ++i)
    compare(frame, frame);
  tracker.forget();
  EXPECT_EQ(compare(frame, frame).flags, haptic::kMotionDuplicate);
}

TEST(IsIdentical, LooksAtThePixelsOfTheViewsOnly) {
  const std::vector<std::uint8_t> one(10 * 8, 50);
  std::vector<std::uint8_t> other = one;
  const LumaView a{one.data(), 7, 8, 10};
  const LumaView b{other.data(), 7, 8, 10};
  other[7] = 99; // right of the first row
  EXPECT_TRUE(is_identical(a, b));
  other[7 * 10 + 6] = 51; // last pixel
  EXPECT_FALSE(is_identical(a, b));
}

TEST(TrackingStatistics, CountsFramesByTheirFlagsAndTakesMeans) {
  using namespace std::chrono_literals;
  haptic::TrackingStatistics statistics;
  EXPECT_EQ(statistics.mean_points(), 0);
  EXPECT_EQ(statistics.mean_time(), 0);
  statistics.add({.flags = haptic::kMotionDiscontinuity}, 0);
  statistics.add({.time = 100us}, 4);
  statistics.add({.time = 300us}, 7);
  statistics.add({.time = 200us}, 0);
  statistics.add({.flags = haptic::kMotionDuplicate}, 0);
  statistics.add({.flags = haptic::kMotionStill}, 0);
  EXPECT_EQ(statistics.frames, 6U);
  EXPECT_EQ(statistics.measured, 2U);
  EXPECT_EQ(statistics.still, 1U);
  EXPECT_EQ(statistics.duplicates, 1U);
  EXPECT_EQ(statistics.discontinuities, 1U);
  EXPECT_EQ(statistics.timed, 3U);
  EXPECT_EQ(statistics.mean_points(), 5.5);
  EXPECT_EQ(statistics.mean_time(), 200);
}

} // namespace region_tracker_test
