// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/field-sampler.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>

namespace field_sampler_test {

using haptic::FieldCell;
using haptic::MotionField;
using haptic::MotionSample;
using haptic::sample_field;

// 352 x 288 in cells of 11 x 12 px; the region of a hand at z = 0 is 30 px wide.
MotionField field_of(const std::function<FieldCell(double x, double y)> &cell, int columns = 32,
                     int rows = 24) {
  MotionField field;
  field.interval = 33'000'000;
  field.frame_width = 352;
  field.frame_height = 288;
  field.columns = static_cast<std::uint16_t>(columns);
  field.rows = static_cast<std::uint16_t>(rows);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      field.cells.push_back(cell((column + 0.5) / columns, (row + 0.5) / rows));
  return field;
}

FieldCell moving(double vx, double vy = 0, double confidence = 1) {
  return {static_cast<float>(vx), static_cast<float>(vy), static_cast<float>(confidence)};
}

TEST(FieldSampler, SaysWhatTheFieldSaysOfItsFrame) {
  MotionField field = field_of([](double, double) { return moving(3, 4, 0.5); });
  field.flags = haptic::kMotionStill;
  field.pixel_aspect_n = 12;
  field.pixel_aspect_d = 11;
  const MotionSample sample = sample_field(field, {});
  EXPECT_EQ(sample.interval, field.interval);
  EXPECT_EQ(sample.frame_width, 352U);
  EXPECT_EQ(sample.frame_height, 288U);
  EXPECT_EQ(sample.pixel_aspect_n, 12U);
  EXPECT_EQ(sample.flags, haptic::kMotionStill);
}

TEST(FieldSampler, OneMotionIsTheSameAtEveryPlaceAndSize) {
  const MotionField field = field_of([](double, double) { return moving(100, -40, 0.75); });
  for (double x = 0; x <= 1; x += 0.0625)
    for (double y = 0; y <= 1; y += 0.125)
      for (double z = -1; z <= 1; z += 0.25) {
        const MotionSample sample = sample_field(field, {.x = x, .y = y, .z = z});
        ASSERT_NEAR(sample.velocity_x, 100, 1e-4);
        ASSERT_NEAR(sample.velocity_y, -40, 1e-4);
        ASSERT_NEAR(sample.confidence, 0.75, 1e-6);
        ASSERT_EQ(sample.spin, 0);
      }
}

TEST(FieldSampler, IsExactWhereTheMotionIsLinearInThePlaceWhateverTheSizeOfTheRegion) {
  const auto motion = [](double x, double y) { return moving(200 * x - 50 * y, 30 - 100 * y); };
  const MotionField field = field_of(motion);
  for (double x = 0.3; x <= 0.7; x += 0.0123)
    for (double y = 0.3; y <= 0.7; y += 0.0321)
      for (double z = -1; z <= 1; z += 0.21) {
        const MotionSample sample = sample_field(field, {.x = x, .y = y, .z = z});
        ASSERT_NEAR(sample.velocity_x, motion(x, y).velocity_x, 1e-3) << x << ' ' << y << ' ' << z;
        ASSERT_NEAR(sample.velocity_y, motion(x, y).velocity_y, 1e-3) << x << ' ' << y << ' ' << z;
      }
}

TEST(FieldSampler, IsExactInCellsLargerThanTheRegionToo) {
  const auto motion = [](double x, double y) { return moving(200 * x, -100 * y); };
  const MotionField field = field_of(motion, 8, 6);
  for (double x = 0.1; x <= 0.9; x += 0.0123) {
    const MotionSample sample = sample_field(field, {.x = x, .y = 1 - x});
    ASSERT_NEAR(sample.velocity_x, motion(x, 1 - x).velocity_x, 1e-3) << x;
    ASSERT_NEAR(sample.velocity_y, motion(x, 1 - x).velocity_y, 1e-3) << x;
  }
}

// The mean over a wave has its amplitude times sin(a) / a, with a = pi width / wavelength.
TEST(FieldSampler, IsTheMeanOverTheRegion) {
  constexpr double kCell = 11; // px
  const auto share = [](double width, double wavelength) {
    const double angle = std::numbers::pi * width / wavelength;
    return std::sin(angle) / angle;
  };
  for (const double wavelength : {80.0, 120.0, 200.0}) {
    const auto wave = [&](double x) {
      return std::sin(2 * std::numbers::pi * 352 * x / wavelength);
    };
    const MotionField field = field_of([&](double x, double) {
      return moving(100 * share(kCell, wavelength) * wave(x)); // the mean over the cell
    });
    for (double region = 30; region <= wavelength / 2; region *= 1.1) {
      const double z = std::log2(region / 30) / 2;
      for (double x = 0.35; x < 0.65; x += 0.003)
        EXPECT_NEAR(sample_field(field, {.x = x, .z = z}).velocity_x,
                    100 * share(region, wavelength) * wave(x), 2)
            << wavelength << " px, " << region << " px, " << x;
    }
  }
}

TEST(FieldSampler, AtTheBorderItIsTheMeanOfWhatLiesInTheFrame) {
  const MotionField field =
      field_of([](double x, double) { return moving(x < 1.0 / 32 ? 80 : 0); });
  EXPECT_NEAR(
      sample_field(field_of([](double x, double) { return moving(x < 0.2 ? 80 : 0); }, 8, 6),
                   {.x = 0})
          .velocity_x,
      80, 1e-3);
  EXPECT_GT(sample_field(field, {.x = 0}).velocity_x, 40);
  EXPECT_NEAR(sample_field(field, {.x = 0}).confidence, 1, 1e-6);
  EXPECT_NEAR(sample_field(field, {.x = 0.5}).velocity_x, 0, 1e-6);
}

TEST(FieldSampler, PullingTheHandCloserTakesInMoreOfTheFrame) {
  const MotionField field = field_of(
      [](double x, double y) { return moving(std::hypot(x - 0.5, y - 0.5) < 0.08 ? 100 : 0); });
  const auto at = [&](double z) { return sample_field(field, {.z = z}).velocity_x; };
  EXPECT_NEAR(at(-1), 100, 1e-3);
  EXPECT_LT(at(0.5), at(0));
  EXPECT_LT(at(1), at(0.5));
  EXPECT_GT(at(1), 0);
}

TEST(FieldSampler, TwoHalvesAreFeltEachAndTheirBorderIsCrossedWithoutAStep) {
  const MotionField field = field_of([](double x, double) { return moving(x < 0.5 ? -100 : 100); });
  EXPECT_NEAR(sample_field(field, {.x = 0.25}).velocity_x, -100, 1e-4);
  EXPECT_NEAR(sample_field(field, {.x = 0.75}).velocity_x, 100, 1e-4);
  float before = -100;
  for (double x = 0.4; x < 0.6; x += 0.001) {
    const float now = sample_field(field, {.x = x}).velocity_x;
    ASSERT_GE(now, before - 1e-4F);
    ASSERT_LE(now - before, 100.0 * 2 * 0.001 * 32); // not faster than from cell to cell
    before = now;
  }
  EXPECT_NEAR(before, 100, 1e-4);
}

TEST(FieldSampler, ACellWithoutConfidenceAddsNothingButDoubt) {
  const MotionField field =
      field_of([](double x, double) { return x < 0.5 ? moving(100) : FieldCell{}; });
  const MotionSample sample = sample_field(field, {.x = 0.5});
  EXPECT_NEAR(sample.velocity_x, 100, 1e-4);
  EXPECT_NEAR(sample.confidence, 0.5, 1e-6);
  EXPECT_EQ(sample_field(field, {.x = 0.8}).confidence, 0);
  EXPECT_EQ(sample_field(field, {.x = 0.8}).velocity_x, 0);
}

TEST(FieldSampler, WhatIsSureWeighsMore) {
  const MotionField field = field_of(
      [](double x, double) { return x < 0.5 ? moving(100, 0, 0.75) : moving(0, 0, 0.25); });
  EXPECT_NEAR(sample_field(field, {.x = 0.5}).velocity_x, 75, 1e-4);
  EXPECT_NEAR(sample_field(field, {.x = 0.5}).confidence, 0.5, 1e-6);
}

TEST(FieldSampler, TheOddestFieldsAreSampledWithinTheirValues) {
  for (const auto &[columns, rows] : {std::pair{1, 1}, {8192, 1}, {1, 8192}, {128, 64}, {3, 2}}) {
    const MotionField field =
        field_of([](double x, double y) { return moving(x, y); }, columns, rows);
    for (double x = 0; x <= 1; x += 0.25)
      for (double y = 0; y <= 1; y += 0.25)
        for (double z = -1; z <= 1; z += 0.5) {
          const MotionSample sample = sample_field(field, {.x = x, .y = y, .z = z});
          ASSERT_NEAR(sample.confidence, 1, 1e-6);
          ASSERT_TRUE(sample.velocity_x > 0 && sample.velocity_x < 1);
          ASSERT_TRUE(sample.velocity_y > 0 && sample.velocity_y < 1);
        }
  }
}

} // namespace field_sampler_test
