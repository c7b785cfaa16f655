// SPDX-License-Identifier: LGPL-2.1-or-later
#include "relief/colour-relief.hpp"
#include "relief/touch-table.hpp"
#include "temporary-folder.hpp"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <sys/stat.h>

namespace touch_table_test {

using haptic::LabColour;
using haptic::ReliefCell;
using haptic::TouchTable;

LabColour lab(int red, int green, int blue) {
  const auto light = [](int value) {
    return static_cast<double>(haptic::linear_light()[static_cast<std::size_t>(value)]);
  };
  return haptic::lab_of({light(red), light(green), light(blue)});
}

TEST(TouchTable, ColoursStandWhereTheStandardPutsThem) {
  // Published values of sRGB's corners.
  const auto expect = [](const LabColour &colour, double lightness, double a, double b) {
    EXPECT_NEAR(colour.lightness, lightness, 0.05);
    EXPECT_NEAR(colour.a, a, 0.1);
    EXPECT_NEAR(colour.b, b, 0.1);
  };
  expect(lab(0, 0, 0), 0, 0, 0);
  expect(lab(255, 255, 255), 100, 0, 0);
  expect(lab(255, 0, 0), 53.24, 80.09, 67.20);
  expect(lab(0, 255, 0), 87.73, -86.18, 83.18);
  expect(lab(0, 0, 255), 32.30, 79.19, -107.86);
}

TEST(TouchTable, ByColourAnEntryIsExactAndBetweenTwoIsBetween) {
  const TouchTable table({{lab(255, 0, 0), 0.01, 100, 0.1},
                          {lab(0, 255, 0), -0.01, 300, 0.5},
                          {lab(0, 0, 255), 0, 500, 0.9}},
                         false);
  const ReliefCell green = table.at(lab(0, 255, 0));
  EXPECT_NEAR(green.height, -0.01, 1e-6);
  EXPECT_NEAR(green.stiffness, 300, 0.1);
  EXPECT_NEAR(green.friction, 0.5, 1e-4);
  EXPECT_EQ(green.validity, 1);
  float before = 0.01F;
  for (int i = 0; i <= 255; i += 5) { // from red to green
    const float height = table.at(lab(255 - i, i, 0)).height;
    EXPECT_LT(height, before + 0.002F) << i;
    EXPECT_GE(height, -0.01F);
    before = height;
  }
}

TEST(TouchTable, ByLightnessAllIsLinearAndTheEndsHold) {
  LabColour dark = lab(255, 0, 255);
  dark.lightness = 20;
  LabColour light = dark;
  light.lightness = 60;
  const TouchTable table({{light, 0.01, 400, 1}, {dark, -0.01, 200, 0}}, true);
  for (const auto &[lightness, height] : {std::pair(0.0, -0.01),
                                          {20.0, -0.01},
                                          {30.0, -0.005},
                                          {40.0, 0.0},
                                          {60.0, 0.01},
                                          {100.0, 0.01}})
    EXPECT_NEAR(table.at({lightness, -30, 10}).height, height, 1e-7) << lightness;
  EXPECT_NEAR(table.at({50, 0, 0}).stiffness, 350, 1e-3);
}

TEST(TouchTable, TheBuiltInOnesMakeReliefsThatAHandCanReach) {
  for (const char *name : {"generic", "fabric", "foliage"}) {
    const TouchTable table = haptic::load_touch_table(name);
    haptic::ReliefField all;
    all.frame_width = all.frame_height = all.rows = 1;
    for (int red = 0; red < 256; red += 51)
      for (int green = 0; green < 256; green += 51)
        for (int blue = 0; blue < 256; blue += 51) {
          all.cells.push_back(table.at(lab(red, green, blue)));
          EXPECT_LE(std::abs(all.cells.back().height), 0.02F) << name;
        }
    all.columns = static_cast<std::uint16_t>(all.cells.size());
    EXPECT_TRUE(is_valid(all)) << name;
  }
  const TouchTable foliage = haptic::load_touch_table("foliage");
  EXPECT_GT(foliage.at(lab(130, 170, 70)).height, foliage.at(lab(50, 90, 40)).height);
  EXPECT_LT(foliage.at(lab(150, 190, 230)).height, -0.008F); // sky
  EXPECT_GT(foliage.at(lab(92, 70, 51)).stiffness, 390);     // bark
}

class TableFile : public ::testing::Test {
protected:
  static std::string refusal(const std::string &text) {
    const std::string path = ::testing::TempDir() + "touch-table-test.ini";
    std::ofstream(path) << text;
    try {
      haptic::load_touch_table(path);
    } catch (const std::runtime_error &error) {
      return error.what();
    }
    return "";
  }
  static bool has(const std::string &text, const char *part) {
    return text.find(part) != std::string::npos;
  }
};

TEST_F(TableFile, WhatIsWrongIsNamedWithItsCure) {
  const std::string head = "[table]\nunit=mm\n";
  const std::string entry = "[entry-1]\ncolour=#A0b1c2\nheight=2.5\nstiffness=100\nfriction=0.3\n";
  EXPECT_EQ(refusal(head + entry), "");
  EXPECT_TRUE(has(refusal(entry), "unit=mm"));
  EXPECT_TRUE(has(refusal(head), "0 entries"));
  EXPECT_TRUE(has(refusal(head + "by=luma\n" + entry), "by=luma"));
  EXPECT_TRUE(has(refusal(head + "[entry-1]\ncolour=red\n"), "#rrggbb"));
  EXPECT_TRUE(has(refusal(head + "[entry-1]\ncolour=#12345g\n"), "#rrggbb"));
  EXPECT_TRUE(has(refusal(head + "[entry-1]\ncolour=#123456\nheight=1\nfriction=1\n"),
                  "[entry-1] has no stiffness"));
  EXPECT_TRUE(has(refusal(head + "[entry-1]\ncolour=#123456\nheight=1001\n"), "-1000 to 1000"));
  EXPECT_TRUE(has(refusal(head + "[entry-1]\ncolour=#123456\nheight=nan\n"), "not a number"));
  EXPECT_TRUE(has(refusal(head + entry + "[entry-3]\ncolour=#123456\n"), "without a gap"));
  EXPECT_TRUE(has(refusal(head + entry + "hight=3\n"), "unknown key, hight"));
  EXPECT_TRUE(has(refusal("not a table"), "cannot be read"));
  EXPECT_TRUE(has(refusal(std::string("\x89PNG\r\n\x1a\n\0\0", 10)), "cannot be read"));
  EXPECT_THROW(haptic::load_touch_table("velvet"), std::runtime_error);
  EXPECT_THROW(haptic::load_touch_table("/nowhere/velvet.ini"), std::runtime_error);
}

TEST(TouchTable, AFifoIsRefusedAndNotWaitedFor) {
  const test::TemporaryFolder folder;
  const std::string fifo = folder.path_of("fifo.ini");
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  try {
    haptic::load_touch_table(fifo);
    ADD_FAILURE() << "it was taken";
  } catch (const std::runtime_error &error) {
    EXPECT_NE(std::string(error.what()).find("it is a FIFO"), std::string::npos) << error.what();
  }
}

TEST(ColourRelief, ACellHasTheMeanLightOfItsPixels) {
  constexpr int kWidth = 80;
  constexpr int kHeight = 40;
  std::vector<std::uint8_t> pixels(3UL * kWidth * kHeight);
  for (std::size_t i = 0; i < pixels.size(); ++i) // left white, right red
    pixels[i] = i / 3 % kWidth < kWidth / 2 || i % 3 == 0 ? 255 : 0;
  const haptic::ColourView view = {
      {pixels.data(), pixels.data() + 1, pixels.data() + 2}, kWidth, kHeight, 3L * kWidth, 3};
  const TouchTable table({{lab(255, 255, 255), 0.01, 100, 0.1}, {lab(255, 0, 0), -0.01, 300, 0.5}},
                         false);
  haptic::ReliefField relief;
  relief.columns = 8;
  relief.rows = 4;
  relief.cells.resize(32);
  haptic::make_colour_relief(view, table, relief);
  for (std::size_t i = 0; i < relief.cells.size(); ++i)
    EXPECT_NEAR(relief.cells[i].height, i % 8 < 4 ? 0.01 : -0.01, 1e-5) << i;
}

} // namespace touch_table_test
