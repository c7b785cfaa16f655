// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/flat-things.hpp"

#include <algorithm>
#include <cstdlib>
#include <gtest/gtest.h>
#include <memory>

namespace flat_things_test {

using haptic::CellMap;
using haptic::HalfMap;
using haptic::LayerFrame;
using haptic::LayerSize;

constexpr LayerSize kSize{80, 80};
constexpr float kInterval = 1.0F / 60; // s
constexpr float kMoves = -1;
constexpr float kRests = 1;

// Cells of a square about the middle of the crop: what is inside, a border of one cell, what is
// beyond.
class FlatThingsTest : public ::testing::Test {
protected:
  FlatThingsTest() {
    for (CellMap *map : {&frame->flat, &frame->mean, &rests})
      map->values.fill(0);
    for (CellMap *map : {&structure.xx, &structure.xy, &structure.yy, &motion.x, &motion.y})
      map->values.fill(0);
    for (HalfMap *map : {&flow.x, &flow.y})
      map->values.fill(0);
  }

  static int ring(int x, int y) { return std::max(std::abs(x - 10), std::abs(y - 10)); }
  static bool is_border(int x, int y) { return ring(x, y) == kBorder; }

  // `inside`, `beyond`: kMoves or kRests for texture, 0: flat.
  void draw(float inside, float border, float beyond) {
    haptic::for_cells(kSize, [&](int x, int y) {
      rests.at(x, y) = ring(x, y) < kBorder ? inside : is_border(x, y) ? border : beyond;
      frame->flat.at(x, y) = rests.at(x, y) == 0 ? 1 : 0;
      frame->mean.at(x, y) = ring(x, y) < kBorder ? 60 : 160;
    });
  }
  void show(int frames = 10) {
    for (int i = 0; i < frames; ++i)
      things.find(*frame, rests, kSize, kInterval);
  }
  int cells() const {
    int count = 0;
    haptic::for_cells(kSize, [&](int x, int y) { count += things.cells().at(x, y) > 0; });
    return count;
  }

  static constexpr int kBorder = 4;
  static constexpr int kInside = (2 * kBorder - 1) * (2 * kBorder - 1);
  haptic::FlatThings things;
  std::unique_ptr<LayerFrame> frame = std::make_unique<LayerFrame>();
  CellMap rests;
  haptic::VectorMap<HalfMap> flow;
  haptic::TensorMap<CellMap> structure;
  haptic::VectorMap<CellMap> motion;
};

TEST_F(FlatThingsTest, AFlatAreaWhoseBorderMovesBeforeARestIsAThing) {
  draw(0, kMoves, kRests);
  show();
  EXPECT_EQ(cells(), kInside);
}

TEST_F(FlatThingsTest, BeforeAFlatBackgroundTheAreaInsideIsTheThing) {
  draw(0, kMoves, 0);
  show();
  EXPECT_EQ(cells(), kInside);
}

TEST_F(FlatThingsTest, ASkyBehindALeafIsNone) {
  draw(kMoves, kMoves, 0);
  show();
  EXPECT_EQ(cells(), 0);
}

TEST_F(FlatThingsTest, ASkyBetweenLeavesIsNone) {
  draw(0, kMoves, kMoves);
  show();
  EXPECT_EQ(cells(), 0);
}

TEST_F(FlatThingsTest, AFlatAreaAtRestIsNone) {
  draw(0, kRests, kRests);
  show();
  EXPECT_EQ(cells(), 0);
}

TEST_F(FlatThingsTest, AThingStaysOneAtTheTurnOfItsSway) {
  draw(0, kMoves, kRests);
  show();
  draw(0, kRests, kRests);
  show(30);
  EXPECT_EQ(cells(), kInside);
  things.forget();
  show();
  EXPECT_EQ(cells(), 0);
}

// The edges left and right show one component, those above and below the other.
TEST_F(FlatThingsTest, AThingMovesAsItsBordersDoTogether) {
  draw(0, kMoves, kRests);
  haptic::for_cells(kSize, [&](int x, int y) {
    if (!is_border(x, y))
      return;
    const bool is_side = std::abs(x - 10) == kBorder;
    (is_side ? structure.xx : structure.yy).at(x, y) = 400;
    for (const int i : {0, 1})
      for (const int j : {0, 1}) {
        flow.x.at(2 * x + i, 2 * y + j) = is_side ? 1.5F : 0;
        flow.y.at(2 * x + i, 2 * y + j) = is_side ? 0 : -0.5F;
      }
  });
  show();
  things.move(flow, structure, kSize, motion);
  EXPECT_NEAR(motion.x.at(10, 10), 1.5F, 0.01F);
  EXPECT_NEAR(motion.y.at(10, 10), -0.5F, 0.01F);
  EXPECT_EQ(motion.x.at(10, 2), 0);
}

} // namespace flat_things_test
