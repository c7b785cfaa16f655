// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracking/region.hpp"

#include <gtest/gtest.h>

namespace region_test {

using haptic::Rectangle;

TEST(Region, IsThirtyPixelsWideInThePapersFrameAndGrowsWithTheFrame) {
  EXPECT_EQ(haptic::default_region_side(352), 30);
  EXPECT_EQ(haptic::default_region_side(1920), 164);
  EXPECT_EQ(haptic::default_region_side(176), 15);
  EXPECT_EQ(haptic::default_region_side(1), 1);
}

TEST(Region, IsCentredUnderThePointer) {
  EXPECT_EQ(haptic::region_at(0.5, 0.5, 30, 352, 288), (Rectangle{161, 129, 30, 30}));
  EXPECT_EQ(haptic::region_at(0.25, 0.75, 30, 352, 288), (Rectangle{73, 201, 30, 30}));
}

TEST(Region, IsClippedAtTheBorderWhileItsCentreStaysUnderThePointer) {
  EXPECT_EQ(haptic::region_at(0, 0, 30, 352, 288), (Rectangle{0, 0, 15, 15}));
  EXPECT_EQ(haptic::region_at(1, 1, 30, 352, 288), (Rectangle{337, 273, 15, 15}));
}

TEST(Region, NeverLeavesTheFrameNorBecomesEmpty) {
  for (const auto &[width, height] : {std::pair{1, 1}, {2, 1}, {13, 7}, {352, 288}})
    for (const int side : {1, 2, 29, 30, 8192})
      for (double x = 0; x <= 1; x += 0.125)
        for (double y = 0; y <= 1; y += 0.125) {
          const Rectangle region = haptic::region_at(x, y, side, width, height);
          const Rectangle crop = haptic::crop_around(region, 36, width, height);
          for (const Rectangle &r : {region, crop}) {
            EXPECT_GE(r.x, 0);
            EXPECT_GE(r.y, 0);
            EXPECT_GE(r.width, 1);
            EXPECT_GE(r.height, 1);
            EXPECT_LE(r.x + r.width, width);
            EXPECT_LE(r.y + r.height, height);
          }
          EXPECT_LE(crop.x, region.x);
          EXPECT_GE(crop.x + crop.width, region.x + region.width);
        }
}

TEST(Region, BelowTwelvePixelsIsTooSmallToMeasure) {
  EXPECT_TRUE(haptic::is_measurable({0, 0, 12, 12}));
  EXPECT_FALSE(haptic::is_measurable({0, 0, 11, 30}));
  EXPECT_FALSE(haptic::is_measurable({0, 0, 30, 11}));
}

TEST(RegionSize, DoublesWithEveryQuarterOfTheWorkspaceTowardsTheUser) {
  const auto side = [](double z) { return haptic::RegionSize().side(z, 30, 352, 288); };
  EXPECT_EQ(side(0), 30);
  EXPECT_EQ(side(0.5), 60);
  EXPECT_EQ(side(1), 120);
  EXPECT_EQ(side(-0.5), 16); // 15, even
}

TEST(RegionSize, IsBoundedByWhatCanBeMeasuredAndByHalfTheFrame) {
  EXPECT_EQ(haptic::RegionSize().side(-1, 30, 352, 288), 12);
  EXPECT_EQ(haptic::RegionSize().side(-1, 164, 1920, 1080), 66);
  EXPECT_EQ(haptic::RegionSize().side(1, 60, 352, 288), 144);
  EXPECT_EQ(haptic::RegionSize().side(1, 12, 20, 16), 12);
}

TEST(RegionSize, OfASizeBeyondTheBoundsPullingAndPushingGoOppositeWays) {
  for (const int base : {14, 20, 300})
    for (const auto &[width, height] : {std::pair(640, 360), std::pair(1920, 1080)}) {
      int before = 0;
      for (const double z : {-1.0, -0.5, -0.2, 0.0, 0.2, 0.5, 1.0}) {
        const int side = haptic::RegionSize().side(z, base, width, height);
        EXPECT_GE(side, before) << base << ' ' << z;
        before = side;
      }
    }
}

TEST(RegionSize, ATremblingHandLeavesItAlone) {
  haptic::RegionSize size;
  const int side = size.side(0.3, 30, 352, 288);
  for (const double tremor : {0.02, -0.03, 0.05, -0.05, 0.0})
    EXPECT_EQ(size.side(0.3 + tremor, 30, 352, 288), side);
  EXPECT_NE(size.side(0.5, 30, 352, 288), side);
}

TEST(RegionSize, WithoutAThirdDimensionItIsWhatThePropertySays) {
  haptic::RegionSize size;
  for (const int base : {31, 8000, 5})
    EXPECT_EQ(size.side(0, base, 352, 288), base);
}

} // namespace region_test
