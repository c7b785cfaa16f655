// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/background-motion.hpp"

#include "layer-scene.hpp"
#include "layers/segmentation.hpp"

#include <gtest/gtest.h>
#include <memory>

namespace background_motion_test {

using haptic::BackgroundMotion;
using haptic::Displacement;
using test::Frame;
using test::kCropSide;
using test::kCropSize;
using test::Shift;

class BackgroundMotionTest : public ::testing::Test {
protected:
  BackgroundMotionTest() {
    all.values.fill(1);
    none.values.fill(0);
  }

  // The motion in the middle after frames that show the sky at `places`.
  template <typename PlaceOf>
  Displacement after(int frames, PlaceOf &&place_of) {
    auto segmentation = std::make_unique<haptic::Segmentation>();
    haptic::LayerFrame earlier = test::prepared(clouds.frame(kCropSide, kCropSide, place_of(0)));
    for (int i = 1; i < frames; ++i) {
      const haptic::LayerFrame later =
          test::prepared(clouds.frame(kCropSide, kCropSide, place_of(i)));
      segmentation->find_luma(later, all, kCropSize);
      motion->update(earlier, later, segmentation->luma(), all, none, kCropSize,
                     {.seconds = 1.0F / 60, .prior = {}});
      earlier = later;
    }
    return {motion->motion().x.at(10, 10), motion->motion().y.at(10, 10)};
  }

  test::Texture clouds{1, 60, 12};
  haptic::CellMap all;
  haptic::CellMap none;
  std::unique_ptr<BackgroundMotion> motion = std::make_unique<BackgroundMotion>();
};

TEST_F(BackgroundMotionTest, CloudsDriftByATenthOfAPixel) {
  const Displacement found = after(90, [](int i) { return Shift{0.1 * i, -0.05 * i}; });
  EXPECT_NEAR(found.x, 0.1, 0.015);
  EXPECT_NEAR(found.y, -0.05, 0.015);
}

TEST_F(BackgroundMotionTest, CloudsThatACoderMovesInJumpsDriftAllTheSame) {
  const Displacement found = after(120, [](int i) { return Shift{0.1 * (i / 8 * 8), 0}; });
  EXPECT_NEAR(found.x, 0.1, 0.03);
  EXPECT_NEAR(found.y, 0, 0.01);
}

TEST_F(BackgroundMotionTest, ASkyAtRestHasNoMotion) {
  const Displacement found = after(30, [](int) { return Shift{}; });
  EXPECT_EQ(found.x, 0);
  EXPECT_EQ(found.y, 0);
}

TEST_F(BackgroundMotionTest, ASkyThatStopsIsAtRestWithinSeconds) {
  const Displacement found = after(60 + 180, [](int i) { return Shift{0.1 * std::min(i, 60), 0}; });
  EXPECT_LT(std::abs(found.x), 0.01);
}

} // namespace background_motion_test
