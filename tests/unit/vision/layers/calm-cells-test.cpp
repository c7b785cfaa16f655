// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/calm-cells.hpp"

#include "layer-scene.hpp"

#include <gtest/gtest.h>
#include <memory>

namespace calm_cells_test {

using haptic::CalmCells;
using test::kCropSize;
using test::LayerScene;
using test::Shift;

constexpr float kFrame = 1.0F / 60; // s

class CalmCellsTest : public ::testing::Test {
protected:
  // Shows so many frames; the sky and the leaf move by so much in each.
  void show(int frames, Shift sky, Shift leaf, float frame_moves = 0) {
    for (int i = 0; i < frames; ++i, ++shown)
      cells->update(test::prepared(scene.draw(test::kCropSide, test::kCropSide,
                                              {sky.x * i, sky.y * i}, {leaf.x * i, leaf.y * i})),
                    kCropSize,
                    {.seconds = kFrame,
                     .shift = {static_cast<float>(sky.x), static_cast<float>(sky.y)},
                     .has_shift = frame_moves > 0,
                     .frame_moves = frame_moves});
  }

  LayerScene scene;
  std::unique_ptr<CalmCells> cells = std::make_unique<CalmCells>();
  int shown = 0;
};

TEST_F(CalmCellsTest, TheSkyIsBackgroundAndTheLeafIsNot) {
  show(20, {0.1, 0}, {0.5, 0.2});
  EXPECT_EQ(cells->background().at(1, 1), 1);
  EXPECT_EQ(cells->background().at(18, 18), 1);
  EXPECT_EQ(cells->background().at(10, 10), 0) << "the middle of the leaf";
}

TEST_F(CalmCellsTest, AFlatThingThatPassesIsNoBackground) {
  scene.radius = 10;
  scene.place = {20, 40};
  test::Texture clouds(1, 60, 12);
  for (int i = 0; i < 24; ++i) {
    test::Frame frame = clouds.frame(test::kCropSide, test::kCropSide, {});
    // A grey board of 32 px, whose inside shows nothing.
    for (int y = 20; y < 60; ++y)
      for (int x = 10 + 2 * i; x < std::min(test::kCropSide, 42 + 2 * i); ++x)
        frame.at(x, y) = 60;
    cells->update(test::prepared(frame), kCropSize, {.seconds = kFrame, .shift = {}});
  }
  // Its front edge has just passed these cells.
  EXPECT_EQ(cells->background().at(18, 10), 0);
  EXPECT_EQ(cells->background().at(2, 1), 1);
}

TEST_F(CalmCellsTest, ASkyAtRestDoesNotFollowTheFrame) {
  show(20, {0, 0}, {0.5, 0});
  EXPECT_EQ(cells->follows().at(1, 1), 0);
}

TEST_F(CalmCellsTest, ASkyThatMovesWithTheFrameFollowsItAndStaysBackground) {
  show(30, {1.5, 0.5}, {1.5, 0.5}, 1);
  EXPECT_GT(cells->follows().at(5, 5), 0.9F);
  EXPECT_EQ(cells->background().at(6, 17), 1);
}

} // namespace calm_cells_test
