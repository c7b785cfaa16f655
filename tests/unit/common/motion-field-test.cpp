// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-field.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

namespace {

using haptic::MotionField;

MotionField small_field() {
  MotionField field;
  field.interval = 33'333'333;
  field.frame_width = 352;
  field.frame_height = 288;
  field.pixel_aspect_n = 12;
  field.pixel_aspect_d = 11;
  field.flags = haptic::kMotionCut;
  field.columns = 3;
  field.rows = 2;
  for (int i = 0; i < 6; ++i) {
    const auto number = static_cast<float>(i);
    field.cells.push_back({12.5F * number, -3.25F * number, number / 8});
  }
  return field;
}

std::vector<std::uint8_t> packed(const MotionField &field) {
  std::vector<std::uint8_t> bytes(haptic::packed_size(field));
  haptic::pack_motion_field(field, bytes);
  return bytes;
}

bool is_read(std::span<const std::uint8_t> bytes) {
  MotionField field;
  return haptic::unpack_motion_field(bytes, field);
}

TEST(MotionField, ComesBackBitByBit) {
  MotionField field;
  ASSERT_TRUE(haptic::unpack_motion_field(packed(small_field()), field));
  EXPECT_EQ(field, small_field());
}

TEST(MotionField, StartsWithItsNameVersionAndKindSoThatAFileExplainsItself) {
  const auto bytes = packed(small_field());
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 4), "HMSP");
  EXPECT_EQ(bytes[4], 1);
  EXPECT_EQ(bytes[5], 1);
}

TEST(MotionField, EveryTruncationIsRefused) {
  const auto bytes = packed(small_field());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(is_read(std::span(bytes).first(size))) << size;
}

TEST(MotionField, APointAndAFieldAreNotTakenForOneAnother) {
  EXPECT_EQ(haptic::unpack_motion_sample(packed(small_field())), std::nullopt);
  haptic::MotionSample point;
  point.frame_width = point.frame_height = 100;
  EXPECT_FALSE(is_read(haptic::pack_motion_sample(point)));
}

TEST(MotionField, NumbersThatAreNotFiniteOrOutOfRangeAreRefused) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    for (auto number : {&haptic::FieldCell::velocity_x, &haptic::FieldCell::velocity_y,
                        &haptic::FieldCell::confidence}) {
      MotionField field = small_field();
      field.cells[4].*number = bad;
      EXPECT_FALSE(is_read(packed(field)));
    }
  MotionField field = small_field();
  field.cells[0].confidence = 1.5F;
  EXPECT_FALSE(is_read(packed(field)));
  field = small_field();
  field.frame_width = 0;
  EXPECT_FALSE(is_read(packed(field)));
}

TEST(MotionField, AFieldWithMoreCellsThanItHasBytesOrThanAreAllowedIsRefused) {
  auto bytes = packed(small_field());
  bytes[32] = bytes[33] = bytes[34] = bytes[35] = 0xFF;
  EXPECT_FALSE(is_read(bytes));
  bytes.resize(haptic::kFieldHeaderSize + 65535UL * haptic::kFieldCellSize);
  EXPECT_FALSE(is_read(bytes));
  bytes[32] = bytes[33] = bytes[34] = bytes[35] = 0;
  EXPECT_FALSE(is_read(bytes));
}

} // namespace
