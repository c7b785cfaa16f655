// SPDX-License-Identifier: LGPL-2.1-or-later
#include "relief/depth-relief.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>

namespace depth_relief_test {

using haptic::DepthKind;
using haptic::DepthScale;
using haptic::ReliefCell;
using haptic::ReliefField;

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr std::uint16_t kNothing = 0;

// A frame of 16 bits without padding.
struct Depth {
  std::vector<std::uint8_t> bytes = std::vector<std::uint8_t>(2UL * kWidth * kHeight);

  explicit Depth(const std::function<double(int, int)> &value) {
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        set(x, y, static_cast<std::uint16_t>(std::lround(value(x, y))));
  }
  void set(int x, int y, std::uint16_t value) {
    const std::size_t at = 2 * (static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x));
    bytes[at] = static_cast<std::uint8_t>(value);
    bytes[at + 1] = static_cast<std::uint8_t>(value >> 8);
  }
  void clear(int x0, int y0, int width, int height) {
    for (int y = y0; y < y0 + height; ++y)
      for (int x = x0; x < x0 + width; ++x)
        set(x, y, kNothing);
  }
  haptic::DepthView view() const { return {bytes.data(), kWidth, kHeight, 2 * kWidth, 2}; }
};

// Near 1 m, far 3 m, 40 mm between them.
DepthScale metre_scale() {
  DepthScale scale;
  scale.near = 1;
  scale.far = 3;
  return scale;
}

ReliefField empty_relief() {
  ReliefField relief;
  relief.frame_width = kWidth;
  relief.frame_height = kHeight;
  relief.columns = 32;
  relief.rows = 24;
  relief.cells.resize(32UL * 24);
  return relief;
}

ReliefField relief_of(const Depth &depth, const DepthScale &scale = metre_scale()) {
  ReliefField relief = empty_relief();
  haptic::DepthRelief maker;
  maker.make(depth.view(), scale, relief);
  EXPECT_TRUE(is_valid(relief));
  return relief;
}

const ReliefCell &cell_at(const ReliefField &relief, int column, int row) {
  return relief
      .cells[static_cast<std::size_t>(row) * relief.columns + static_cast<std::size_t>(column)];
}

bool is_silent(const ReliefField &relief) {
  return std::ranges::all_of(relief.cells, [](const auto &cell) { return cell == ReliefCell{}; });
}

TEST(DepthRelief, NearIsHighFarIsLowAndTheMiddleIsThePlaneOfTheHand) {
  for (const auto &[metres, height] : {std::pair(1.0, 0.02), {2.0, 0.0}, {3.0, -0.02}}) {
    const ReliefField relief = relief_of(Depth([m = metres](int, int) { return 1000 * m; }));
    for (const ReliefCell &cell : relief.cells) {
      ASSERT_NEAR(cell.height, height, 1e-6) << metres;
      ASSERT_EQ(cell.stiffness, 200);
      ASSERT_EQ(cell.friction, 0.3F);
      ASSERT_EQ(cell.validity, 1);
    }
  }
}

TEST(DepthRelief, ASlopeHasItsHeightAtTheCentreOfEachCell) {
  const auto depth = [](double x, double y) { return 1500 + 2.3 * x + 1.1 * y; };
  const ReliefField relief = relief_of(Depth([&](int x, int y) { return depth(x, y); }));
  for (int row = 0; row < 24; ++row)
    for (int column = 0; column < 32; ++column) {
      const double there = depth(10 * column + 4.5, 10 * row + 4.5);
      // 2 mm of 2 m: 0.1 % of the range
      ASSERT_NEAR(cell_at(relief, column, row).height, 0.04 * (2000 - there) / 2000, 4e-5);
    }
}

TEST(DepthRelief, DisparityRisesToTheUserAndLeavesAPlaneAPlane) {
  DepthScale scale = metre_scale();
  scale.kind = DepthKind::disparity;
  scale.scale = 3000; // 3000 at 1 m, 1000 at 3 m
  const ReliefField relief = relief_of(Depth([](int x, int) { return 1000 + 5.0 * x; }), scale);
  for (int column = 0; column < 32; ++column)
    EXPECT_NEAR(cell_at(relief, column, 7).height, 0.04 * (50.0 * column + 22.5 - 1000) / 2000,
                6e-5);
}

TEST(DepthRelief, AThirdOfWildPixelsDoesNotMoveTheHeight) {
  std::mt19937 random(3);
  Depth depth([](int, int) { return 2000; });
  for (int i = 0; i < kWidth * kHeight / 4; ++i)
    depth.set(static_cast<int>(random() % kWidth), static_cast<int>(random() % kHeight),
              static_cast<std::uint16_t>(random()));
  int right = 0;
  for (const ReliefCell &cell : relief_of(depth).cells)
    right += std::abs(cell.height) < 4e-4F; // 1 % of the range
  EXPECT_GE(right, 32 * 24 - 2);
}

TEST(DepthRelief, ValidityIsTheShareOfPixelsThatAreKnown) {
  Depth depth([](int, int) { return 2000; });
  depth.clear(100, 0, 4, kHeight); // two of five samples of a row
  const ReliefField relief = relief_of(depth);
  EXPECT_FLOAT_EQ(cell_at(relief, 10, 3).validity, 0.6F);
  EXPECT_NEAR(cell_at(relief, 10, 3).height, 0, 1e-6);
  EXPECT_EQ(cell_at(relief, 9, 3).validity, 1);
}

TEST(DepthRelief, AHoleOfOneCellBelongsToWhatLiesBehindAndALargerOneStays) {
  Depth depth([](int x, int) { return x < 100 ? 1500 : 2500; });
  depth.clear(100, 50, 10, 10); // the shadow that a nearer thing throws
  depth.clear(200, 50, 30, 30);
  const ReliefField relief = relief_of(depth);
  const ReliefCell &filled = cell_at(relief, 10, 5);
  // Above and below agree, left and right do not.
  EXPECT_NEAR(filled.height, -0.01, 1e-6);
  EXPECT_EQ(filled.validity, haptic::kFilledValidity);
  for (int row = 5; row < 8; ++row)
    for (int column = 20; column < 23; ++column)
      EXPECT_EQ(cell_at(relief, column, row), ReliefCell{}) << column << ' ' << row;
}

TEST(DepthRelief, NearestTouchesAWireThatTheMedianMisses) {
  Depth depth([](int x, int) { return x % 10 == 5 ? 1500 : 2500; });
  EXPECT_NEAR(cell_at(relief_of(depth), 4, 4).height, -0.01, 1e-6);
  DepthScale scale = metre_scale();
  scale.cell_height = haptic::CellHeight::nearest;
  EXPECT_NEAR(cell_at(relief_of(depth, scale), 4, 4).height, 0.01, 1e-6);
}

TEST(DepthRelief, WhatCannotBeADepthIsSilence) {
  for (const double value : {0.0, 65535.0, 999.0, 3001.0})
    EXPECT_TRUE(is_silent(relief_of(Depth([=](int, int) { return value; })))) << value;
  const Depth depth([](int, int) { return 2000; });
  DepthScale scale = metre_scale();
  scale.scale = 1; // millimetres taken for metres
  EXPECT_TRUE(is_silent(relief_of(depth, scale)));
  scale = metre_scale();
  std::swap(scale.near, scale.far);
  EXPECT_TRUE(is_silent(relief_of(depth, scale)));
}

TEST(DepthRelief, SaysWhetherThereIsASurface) {
  std::mt19937 random(5);
  int surfaces = 0;
  for (const double share : {0.0, 0.001, 0.01, 0.03, 0.1, 1.0}) { // of the pixels
    std::bernoulli_distribution is_known(share);
    const Depth depth([&](int, int) { return is_known(random) ? 2000 : kNothing; });
    ReliefField relief = empty_relief();
    haptic::DepthRelief maker;
    const bool is_told = maker.make(depth.view(), metre_scale(), relief);
    EXPECT_EQ(is_told, !is_silent(relief)) << share;
    surfaces += !is_silent(relief);
  }
  EXPECT_GT(surfaces, 0);
  EXPECT_LT(surfaces, 5);
}

TEST(DepthRelief, ReadsEightBitsAndNoByteOutsideTheFrame) {
  DepthScale scale;
  scale.kind = DepthKind::disparity;
  scale.scale = 255; // white at 1 m
  scale.near = 1;
  scale.far = 255;
  for (const auto &[width, height] : {std::pair(1, 1), {3, 2}, {97, 61}}) {
    const std::vector<std::uint8_t> white(static_cast<std::size_t>(width) * height, 255);
    ReliefField relief;
    relief.frame_width = relief.frame_height = 1;
    relief.columns = 12;
    relief.rows = 7;
    relief.cells.resize(84);
    haptic::DepthRelief maker;
    EXPECT_TRUE(maker.make({white.data(), width, height, width, 1}, scale, relief));
    for (const ReliefCell &cell : relief.cells)
      ASSERT_NEAR(cell.height, 0.02, 1e-6);
  }
}

} // namespace depth_relief_test
