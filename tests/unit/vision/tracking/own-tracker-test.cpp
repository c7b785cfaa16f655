// SPDX-License-Identifier: LGPL-2.1-or-later
// The tracker of docs/own-tracker.md, a first one to copy, and a test of what a tracker promises.
#include "region-tracking.hpp"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>

namespace haptic {
namespace {

// Compares the region with every place up to 8 px away, and takes the most similar one (block
// matching). The minimum between whole pixels is that of a parabola.
class BlockTracker final : public PatchTracker {
public:
  int margin(int /*region_side*/) const override { return kReach; }
  void set_max_points(int /*max_points*/) override {} // one patch, the region
  void reset() override {}                            // it remembers nothing

  void measure(const CropPair &pair, Measurement &measurement) override {
    measurement.clear();
    measurement.candidates = 1;
    int best_x = 0;
    int best_y = 0;
    double least = difference(pair, 0, 0);
    for (int dy = -kReach; dy <= kReach; ++dy)
      for (int dx = -kReach; dx <= kReach; ++dx)
        if (const double squares = difference(pair, dx, dy); squares < least) {
          least = squares;
          best_x = dx;
          best_y = dy;
        }
    const auto beside = [&](int x, int y) { return difference(pair, best_x + x, best_y + y); };
    const double bend_x = beside(-1, 0) - 2 * least + beside(1, 0);
    const double bend_y = beside(0, -1) - 2 * least + beside(0, 1);
    const double bend_xy = (beside(1, 1) - beside(1, -1) - beside(-1, 1) + beside(-1, -1)) / 4;

    Patch patch{};
    patch.width = static_cast<float>(pair.region.width);
    patch.height = static_cast<float>(pair.region.height);
    patch.x = static_cast<float>(pair.region.x) + patch.width / 2;
    patch.y = static_cast<float>(pair.region.y) + patch.height / 2;
    patch.dx = static_cast<float>(best_x + (beside(-1, 0) - beside(1, 0)) / (2 * bend_x));
    patch.dy = static_cast<float>(best_y + (beside(0, -1) - beside(0, 1)) / (2 * bend_y));
    // The inverse of the covariance (1/px²), of two frames with noise: the sharper the minimum, the
    // surer the displacement. This is what the confidence is made of.
    const double precision = 1 / (4 * kNoise * kNoise);
    patch.precision_xx = static_cast<float>(precision * bend_x);
    patch.precision_xy = static_cast<float>(precision * bend_xy);
    patch.precision_yy = static_cast<float>(precision * bend_y);
    patch.residual =
        static_cast<float>(std::sqrt(least / (pair.region.width * pair.region.height)));
    // Silence beats a wrong number: a wall without texture has no sharp minimum, and a region at
    // the border of the frame has none that was compared.
    const float least_precision = 1; // 1/px², an error of 1 px
    if (std::isfinite(bend_x + bend_y + bend_xy) && patch.precision_xx > least_precision &&
        patch.precision_yy > least_precision)
      measurement.add(patch);
  }

private:
  static constexpr int kReach = 8;      // px
  static constexpr double kNoise = 1.5; // grey levels, of a usual camera

  // Sum of the squared differences between the region and the place (dx, dy) beside it.
  static double difference(const CropPair &pair, int dx, int dy) {
    const int left = pair.region.x - pair.crop.x;
    const int top = pair.region.y - pair.crop.y;
    if (left + dx < 0 || top + dy < 0 || left + dx + pair.region.width > pair.crop.width ||
        top + dy + pair.region.height > pair.crop.height)
      return std::numeric_limits<double>::infinity(); // beyond the border of the frame
    double sum = 0;
    for (int y = top; y < top + pair.region.height; ++y) {
      const std::uint8_t *before = pair.previous.pixels + y * pair.previous.stride + left;
      const std::uint8_t *after = pair.current.pixels + (y + dy) * pair.current.stride + left + dx;
      for (int x = 0; x < pair.region.width; ++x)
        sum += (after[x] - before[x]) * (after[x] - before[x]);
    }
    return sum;
  }
};

} // namespace

std::unique_ptr<PatchTracker> make_block_tracker() {
  return std::make_unique<BlockTracker>();
}

} // namespace haptic

namespace own_tracker_test {

using test::Frame;
using test::Shift;
using test::Texture;

class OwnTracker : public test::RegionTracking {
protected:
  OwnTracker() : RegionTracking(haptic::make_block_tracker()) {}
};

TEST_F(OwnTracker, MeasuresADisplacementWithinATenthOfAPixel) {
  const Texture texture(1);
  Frame before = texture.frame(140, 140, {});
  for (const Shift truth : {Shift{0, 0}, Shift{3, -2}, Shift{-1.5, 0.25}, Shift{5.75, 6.5}}) {
    Frame after = texture.frame(140, 140, truth);
    const haptic::Measurement &found = track(before, after);
    ASSERT_EQ(found.count, 1);
    EXPECT_NEAR(mean(found).x, truth.x, 0.1);
    EXPECT_NEAR(mean(found).y, truth.y, 0.1);
  }
}

TEST_F(OwnTracker, IsSilentOnAWallWithoutTexture) {
  Frame wall(140, 140, 128);
  EXPECT_EQ(track(wall, wall).count, 0);
}

TEST_F(OwnTracker, IsSilentWhereThePlaceLeftTheFrame) {
  const Texture texture(1);
  Frame before = texture.frame(140, 140, {});
  Frame after = texture.frame(140, 140, {8, 0});
  EXPECT_EQ(track(before, after, {104, 50, kSide, kSide}).count, 0);
}

} // namespace own_tracker_test
