// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/centred-mean.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace centred_mean_test {

using haptic::MotionField;

MotionField field_of(float velocity, float confidence = 1) {
  MotionField field;
  field.interval = 16'666'000;
  field.frame_width = 640;
  field.frame_height = 360;
  field.columns = field.rows = 2;
  field.cells.assign(4, {velocity, -velocity, confidence});
  return field;
}

float mean_of(const MotionField &before, MotionField now, const MotionField &after) {
  take_centred_mean(before, now, after);
  EXPECT_EQ(now.cells[0].velocity_y, -now.cells[0].velocity_x);
  return now.cells[0].velocity_x;
}

TEST(CentredMean, AnEvenMotionAndAnEvenAccelerationStay) {
  EXPECT_EQ(mean_of(field_of(8), field_of(8), field_of(8)), 8);
  EXPECT_EQ(mean_of(field_of(4), field_of(8), field_of(12)), 8) << "nothing is late";
}

TEST(CentredMean, AnErrorOfOneFieldIsHalved) {
  EXPECT_EQ(mean_of(field_of(8), field_of(12), field_of(8)), 10);
  EXPECT_EQ(mean_of(field_of(12), field_of(8), field_of(8)), 9);
}

TEST(CentredMean, ASwingLosesAsLittleAtAnyRate) {
  for (const double rate : {25.0, 30.0, 60.0, 120.0}) {
    const auto at = [rate](int frame) {
      MotionField field =
          field_of(static_cast<float>(100 * std::cos(2 * std::numbers::pi * 2 * frame / rate)));
      field.interval = static_cast<std::uint64_t>(1e9 / rate);
      return field;
    };
    const float peak = mean_of(at(-1), at(0), at(1));
    EXPECT_LT(peak, 100);
    EXPECT_GT(peak, 98.8) << rate;
  }
}

TEST(CentredMean, WhatWasNotMeasuredSaysNothing) {
  EXPECT_EQ(mean_of(field_of(0, 0), field_of(8), field_of(8)), 8);
  EXPECT_EQ(mean_of(field_of(8), field_of(0, 0), field_of(8)), 0);
}

TEST(CentredMean, ACutAndRestStayWhereTheyAre) {
  for (const auto flag : {haptic::kMotionCut, haptic::kMotionStill, haptic::kMotionDuplicate,
                          haptic::kMotionDiscontinuity}) {
    MotionField marked = field_of(0);
    marked.flags = flag;
    EXPECT_EQ(mean_of(marked, field_of(8), field_of(12)), 8);
    EXPECT_EQ(mean_of(field_of(4), field_of(8), marked), 8);
    EXPECT_EQ(mean_of(field_of(4), marked, field_of(4)), 0);
  }
}

TEST(CentredMean, AFieldOfAnotherGridSaysNothing) {
  MotionField other = field_of(0);
  other.columns = 1;
  other.cells.resize(2);
  EXPECT_EQ(mean_of(other, field_of(8), field_of(12)), 8);
}

} // namespace centred_mean_test
