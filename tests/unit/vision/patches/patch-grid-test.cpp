// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-frames.hpp"
#include "patches/patch-grid.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <set>

namespace patch_grid_test {

using haptic::Area;
using haptic::PatchGrid;
using haptic::Plane;

struct Shape {
  int rows;
  int columns;
};

Plane plane_of(int width, int height) {
  Plane plane;
  haptic::smooth(test::view_of(test::Texture(1).frame(width, height, {})), plane);
  return plane;
}

TEST(PatchGrid, PatchesAreSpreadEvenlyOverTheArea) {
  const Plane plane = plane_of(120, 100);
  const auto grid = std::make_unique<PatchGrid>();
  grid->cover(plane, {20, 30, 48, 36}, 4, 3, 8, false);
  ASSERT_EQ(grid->view().size(), 12U);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      const auto &patch = grid->patches[haptic::cell(row, 4, column)];
      EXPECT_EQ(patch.side, 8);
      EXPECT_EQ(patch.x + 4, 20 + 12 * (static_cast<float>(column) + 0.5F));
      EXPECT_EQ(patch.y + 4, 30 + 12 * (static_cast<float>(row) + 0.5F));
      EXPECT_GT(patch.energy, 0);
    }
}

TEST(PatchGrid, DitheredNeighboursAreAQuarterAndThreeQuartersOffTheRaster) {
  const Plane plane = plane_of(120, 100);
  const auto grid = std::make_unique<PatchGrid>();
  grid->cover(plane, {20, 30, 48, 36}, 4, 3, 8, true);
  haptic::for_places(*grid, [&](int row, int column) {
    const auto &patch = grid->patches[haptic::cell(row, 4, column)];
    const float off = (row + column) % 2 == 0 ? 0.25F : 0.75F;
    EXPECT_EQ(patch.x - std::floor(patch.x), off);
    EXPECT_EQ(patch.y - std::floor(patch.y), off);
  });
}

TEST(PatchGrid, PatchesStayInsideThePlane) {
  for (const int side : {haptic::kSmallPatch, haptic::kLargePatch})
    for (const int length : {side + haptic::kRim, 40, 61}) {
      const Plane plane = plane_of(length + 2, length + 2);
      ASSERT_TRUE(haptic::fits_into(plane, side));
      const auto grid = std::make_unique<PatchGrid>();
      for (const Area area : {Area{-30, -30, 20, 20}, {0, 0, 200, 200}, {50, 50, 30, 30}}) {
        grid->cover(plane, area, 3, 3, side, true);
        for (const auto &patch : grid->view()) {
          EXPECT_GE(patch.x, 1);
          EXPECT_GE(patch.y, 1);
          EXPECT_LT(patch.x + static_cast<float>(side), static_cast<float>(plane.width()) - 1);
          EXPECT_LT(patch.y + static_cast<float>(side), static_cast<float>(plane.height()) - 1);
        }
      }
    }
}

TEST(PatchGrid, HoldsNoMorePatchesThanAMeasurement) {
  const Plane plane = plane_of(120, 100);
  const auto grid = std::make_unique<PatchGrid>();
  grid->cover(plane, {0, 0, 100, 80}, 100, 100, 8, false);
  EXPECT_EQ(grid->view().size(), static_cast<std::size_t>(haptic::kMaxPatches));
  EXPECT_EQ(haptic::parts_of(1000, 6), haptic::kMostAlong);
  EXPECT_EQ(haptic::parts_of(0.5F, 6), 1);
  EXPECT_EQ(haptic::parts_of(30, 6), 5);
}

TEST(PatchGrid, NeighboursAreThoseInsideTheGrid) {
  const auto places = [](int row, int column) {
    std::set<std::pair<int, int>> found;
    haptic::for_neighbours(Shape{3, 4}, row, column, [&](int y, int x) { found.insert({y, x}); });
    return found;
  };
  EXPECT_EQ(places(1, 1).size(), 9U);
  EXPECT_EQ(places(0, 0), (std::set<std::pair<int, int>>{{0, 0}, {0, 1}, {1, 0}, {1, 1}}));
  EXPECT_EQ(places(2, 3), (std::set<std::pair<int, int>>{{1, 2}, {1, 3}, {2, 2}, {2, 3}}));
  int visited = 0;
  EXPECT_FALSE(haptic::all_neighbours(Shape{3, 4}, 1, 1, [&](int, int) { return ++visited < 3; }));
  EXPECT_EQ(visited, 3);
}

TEST(PatchGrid, TheNearestPartIsTheOneInWhichTheMiddleLies) {
  for (const int parts : {1, 3, 8, 40})
    for (const int other : {1, 2, 5, 8, 33})
      for (int i = 0; i < parts; ++i) {
        const double middle = (i + 0.5) / parts;
        EXPECT_EQ(haptic::nearest_part(i, parts, other), static_cast<int>(middle * other + 1e-9));
      }
}

TEST(Area, IsSmallerAtACoarserLevelAndShiftedInThePlane) {
  const Area area{8, 12, 40, 20};
  const Area coarse = area.at_level(2);
  EXPECT_EQ(coarse.x, 2);
  EXPECT_EQ(coarse.y, 3);
  EXPECT_EQ(coarse.width, 10);
  EXPECT_EQ(coarse.height, 5);
  EXPECT_EQ(area.in_plane().x, 7);
  EXPECT_EQ(area.in_plane().y, 11);
  EXPECT_EQ(area.in_plane().width, 40);
}

TEST(Pyramid, EachLevelIsHalfAsLarge) {
  const auto pyramid = std::make_unique<haptic::Pyramid>();
  pyramid->build(test::view_of(test::Texture(2).frame(101, 66, {})), 3);
  EXPECT_EQ(pyramid->levels[0].width(), 99);
  EXPECT_EQ(pyramid->levels[0].height(), 64);
  EXPECT_EQ(pyramid->levels[1].width(), 49);
  EXPECT_EQ(pyramid->levels[2].width(), 24);
  EXPECT_EQ(pyramid->levels[2].height(), 16);
}

} // namespace patch_grid_test
