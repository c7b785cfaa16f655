// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-field.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

namespace motion_field_test {

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

MotionField field_with_things() {
  MotionField field = small_field();
  field.things = {{0x0102, haptic::HoldState::held, 0.25F, 1, 0.05F},
                  {7, haptic::HoldState::hidden, 0, 0.5F, 0}};
  return field;
}

TEST(MotionField, ThingsStandBehindTheCellsWhereEarlierReadersDoNotLook) {
  const auto without = packed(small_field());
  const auto with = packed(field_with_things());
  ASSERT_EQ(with.size(), without.size() + 4 + 2 * 12);
  EXPECT_TRUE(std::equal(without.begin(), without.end(), with.begin()));
  const std::vector<std::uint8_t> things = {2, 0, 0, 0,                                           //
                                            2, 1, 1, 0, 0x00, 0x40, 0xFF, 0xFF, 0xCD, 0x0C, 0, 0, //
                                            7, 0, 3, 0, 0,    0,    0x00, 0x80, 0,    0,    0, 0};
  EXPECT_EQ(std::vector(with.begin() + static_cast<std::ptrdiff_t>(without.size()), with.end()),
            things);
}

TEST(MotionField, ThingsComeBackWithin65535thsAndThenBitByBit) {
  MotionField field;
  ASSERT_TRUE(haptic::unpack_motion_field(packed(field_with_things()), field));
  ASSERT_EQ(field.things.size(), 2U);
  EXPECT_EQ(field.things[0].id, 0x0102);
  EXPECT_EQ(field.things[1].state, haptic::HoldState::hidden);
  EXPECT_NEAR(field.things[0].x, 0.25F, 1 / 131070.F);
  EXPECT_NEAR(field.things[0].radius, 0.05F, 1 / 131070.F);
  MotionField again;
  ASSERT_TRUE(haptic::unpack_motion_field(packed(field), again));
  EXPECT_EQ(again, field);
  ASSERT_TRUE(haptic::unpack_motion_field(packed(small_field()), again));
  EXPECT_TRUE(again.things.empty()) << "none are left of the field before";
}

TEST(MotionField, ThingsThatAreCutOffTooManyOrOfAnotherStateAreRefused) {
  const auto whole = packed(field_with_things());
  const std::size_t things_at = packed(small_field()).size();
  for (std::size_t size = things_at + 1; size < whole.size(); ++size)
    EXPECT_FALSE(is_read(std::span(whole).first(size))) << size;
  for (const int state : {0, 4, 5, 6, 255}) {
    auto bytes = whole;
    bytes[things_at + 6] = static_cast<std::uint8_t>(state);
    EXPECT_FALSE(is_read(bytes)) << state;
  }
  MotionField field = field_with_things();
  field.things.resize(haptic::kMostFieldThings, field.things[0]);
  EXPECT_TRUE(is_read(packed(field)));
  field.things.push_back(field.things[0]);
  EXPECT_FALSE(is_read(packed(field)));
}

} // namespace motion_field_test
