// SPDX-License-Identifier: LGPL-2.1-or-later
#include "region-tracking.hpp"
#include "tracking/noise-estimate.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace opencv_tracker_test {

using haptic::Measurement;
using haptic::Rectangle;
using test::Frame;
using test::Shift;
using test::Texture;

class OpencvTracker : public test::RegionTracking {
protected:
  OpencvTracker() : RegionTracking(haptic::make_opencv_tracker()) {}

  // Median of each component.
  static Shift median(const Measurement &found) {
    std::vector<double> dx;
    std::vector<double> dy;
    for (const haptic::Patch &patch : found.view()) {
      dx.push_back(patch.dx);
      dy.push_back(patch.dy);
    }
    const auto middle = [](std::vector<double> &values) {
      std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                       values.end());
      return values[values.size() / 2];
    };
    return {middle(dx), middle(dy)};
  }
};

TEST_F(OpencvTracker, MeasuresEveryFractionOfAPixelWithinAFiftieth) {
  double errors = 0;
  int cases = 0;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const Texture texture(seed);
    Frame before = texture.frame(140, 140, {});
    for (int step = 0; step < 16; ++step) {
      const Shift truth{1 + step / 16.0, -step / 16.0};
      Frame after = texture.frame(140, 140, truth);
      const Measurement &found = track(before, after);
      ASSERT_GT(found.count, 10);
      const Shift measured = mean(found);
      const double error = std::hypot(measured.x - truth.x, measured.y - truth.y);
      EXPECT_LT(error, 0.02) << "step " << step << " of texture " << seed;
      errors += error;
      ++cases;
    }
  }
  EXPECT_LT(errors / cases, 0.01);
}

TEST_F(OpencvTracker, AlmostNeverErrsGrosslyUpToSixteenPixels) {
  int gross = 0;
  int lost = 0;
  const int cases =
      test::for_large_displacements(140, [&](Frame &before, Frame &after, Shift truth) {
        const Measurement &found = track(before, after);
        if (found.count < found.candidates / 2) {
          ++lost;
          return;
        }
        const Shift measured = median(found);
        gross += std::hypot(measured.x - truth.x, measured.y - truth.y) > 0.5;
      });
  EXPECT_LE(gross, cases / 100);
  EXPECT_LE(lost, cases / 50);
}

TEST_F(OpencvTracker, APatchSitsWhereItIsInTheEarlierFrame) {
  const Texture texture(3);
  Frame before = texture.frame(200, 160, {});
  Frame after = texture.frame(200, 160, {3, 2});
  const Rectangle region{100, 60, kSide, kSide};
  const Measurement &found = track(before, after, region);
  ASSERT_GT(found.count, 0);
  for (const haptic::Patch &patch : found.view()) {
    EXPECT_GE(patch.x, 100);
    EXPECT_LE(patch.x, 130);
    EXPECT_GE(patch.y, 60);
    EXPECT_LE(patch.y, 90);
  }
}

TEST_F(OpencvTracker, FollowsTheObjectInTheRegionAndNotItsNeighbour) {
  const Texture left(11);
  const Texture right(12);
  Frame before(240, 140);
  Frame after(240, 140);
  left.paint(before, {}, 0, 120);
  right.paint(before, {}, 120, 240);
  left.paint(after, {-3, 1}, 0, 120);
  right.paint(after, {4, -2}, 120, 240);
  const Shift of_left = median(track(before, after, {80, 55, kSide, kSide}));
  EXPECT_NEAR(of_left.x, -3, 0.05);
  EXPECT_NEAR(of_left.y, 1, 0.05);
  const Shift of_right = median(track(before, after, {130, 55, kSide, kSide}));
  EXPECT_NEAR(of_right.x, 4, 0.05);
  EXPECT_NEAR(of_right.y, -2, 0.05);
}

TEST_F(OpencvTracker, TheStatedPrecisionIsTheErrorsThatNoiseMakes) {
  std::mt19937 random(5);
  double normalised = 0;
  int patches = 0;
  for (int i = 0; i < 40; ++i) {
    const Texture texture(static_cast<unsigned>(random()), 8);
    Frame before = texture.frame(140, 140, {});
    Frame after = before;
    add_noise(before, haptic::kAssumedNoise, random);
    add_noise(after, haptic::kAssumedNoise, random);
    for (const haptic::Patch &patch : track(before, after).view()) {
      normalised += patch.dx * patch.dx * patch.precision_xx +
                    2 * patch.dx * patch.dy * patch.precision_xy +
                    patch.dy * patch.dy * patch.precision_yy;
      ++patches;
    }
  }
  // Chi-squared with two degrees of freedom has the mean 2.
  EXPECT_GT(normalised / patches, 2 / 2.0);
  EXPECT_LT(normalised / patches, 2 * 2.0);
}

TEST_F(OpencvTracker, TheResidualIsTheNoiseOfBothFrames) {
  std::mt19937 random(6);
  const Texture texture(4, 8);
  Frame before = texture.frame(140, 140, {});
  Frame after = texture.frame(140, 140, {2, 1});
  add_noise(before, 1.5, random);
  add_noise(after, 1.5, random);
  double sum = 0;
  const Measurement &found = track(before, after);
  for (const haptic::Patch &patch : found.view())
    sum += patch.residual;
  EXPECT_NEAR(sum / found.count, 1.5 * std::numbers::sqrt2, 0.4);
}

TEST_F(OpencvTracker, NoiseOnABlankWallIsNoMotion) {
  std::mt19937 random(8);
  int patches = 0;
  for (int i = 0; i < 50; ++i) {
    Frame before(140, 140, 120);
    Frame after(140, 140, 120);
    add_noise(before, 1.5, random);
    add_noise(after, 1.5, random);
    patches += track(before, after).count;
  }
  EXPECT_EQ(patches, 0);
}

TEST_F(OpencvTracker, AnotherSceneIsNoMotion) {
  int survivors = 0;
  int candidates = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    Frame before = Texture(2 * seed).frame(140, 140, {});
    Frame after = Texture(2 * seed + 1).frame(140, 140, {});
    const Measurement &found = track(before, after);
    survivors += found.count;
    candidates += found.candidates;
  }
  EXPECT_GT(candidates, 0);
  EXPECT_LT(survivors, candidates / 50);
}

TEST_F(OpencvTracker, UnchangedPixelsAreExactlyNoMotion) {
  Frame frame = Texture(9).frame(140, 140, {});
  Frame same = frame;
  const Measurement &found = track(frame, same);
  ASSERT_GT(found.count, 0);
  for (const haptic::Patch &patch : found.view()) {
    EXPECT_EQ(patch.dx, 0);
    EXPECT_EQ(patch.dy, 0);
    EXPECT_EQ(patch.residual, 0);
  }
}

TEST_F(OpencvTracker, KeepsToTheMaximumOfPoints) {
  const Texture texture(10);
  Frame before = texture.frame(140, 140, {});
  Frame after = texture.frame(140, 140, {1, 0});
  for (const int most : {1, 5, haptic::kMaxPatches}) {
    tracker->set_max_points(most);
    const Measurement &found = track(before, after);
    EXPECT_GE(found.count, 1);
    EXPECT_LE(found.count, most);
    EXPECT_LE(found.count, found.candidates);
  }
}

TEST_F(OpencvTracker, WorksInTheSmallestFrameThatCanBeMeasured) {
  const Texture texture(13);
  for (int side = haptic::kSmallestRegion; side < 60; ++side) {
    Frame before = texture.frame(side, side, {});
    Frame after = texture.frame(side, side, {0.5, 0.25});
    const int width = std::min(side, kSide);
    for (const haptic::Patch &patch : track(before, after, {0, 0, width, width}).view()) {
      EXPECT_TRUE(std::isfinite(patch.dx) && std::isfinite(patch.dy));
      EXPECT_TRUE(std::isfinite(patch.precision_xx) && std::isfinite(patch.residual));
    }
  }
}

TEST_F(OpencvTracker, ALargeRegionInALargeFrameReachesFurther) {
  const Texture texture(15, 15);
  const Shift truth{28, -20};
  Frame before = texture.frame(400, 400, {});
  Frame after = texture.frame(400, 400, truth);
  const Measurement &found = track(before, after, {140, 140, 120, 120});
  ASSERT_GT(found.count, 10);
  const Shift measured = median(found);
  EXPECT_NEAR(measured.x, truth.x, 0.05);
  EXPECT_NEAR(measured.y, truth.y, 0.05);
}

TEST_F(OpencvTracker, StartsNoThreads) {
  const auto threads = [] {
    const std::filesystem::directory_iterator tasks("/proc/self/task");
    return std::distance(begin(tasks), end(tasks));
  };
  const auto before_tracking = threads();
  const Texture texture(16);
  Frame before = texture.frame(400, 400, {});
  Frame after = texture.frame(400, 400, {1, 1});
  tracker->set_max_points(haptic::kMaxPatches);
  ASSERT_GT(track(before, after, {100, 100, 200, 200}).count, 0);
  EXPECT_EQ(threads(), before_tracking);
}

} // namespace opencv_tracker_test
