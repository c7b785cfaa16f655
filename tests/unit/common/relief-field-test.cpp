// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-field.hpp"
#include "samples/relief-field.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

namespace relief_field_test {

using haptic::ReliefCell;
using haptic::ReliefField;

ReliefField small_relief() {
  ReliefField relief;
  relief.interval = 33'333'333;
  relief.frame_width = 352;
  relief.frame_height = 288;
  relief.pixel_aspect_n = 12;
  relief.pixel_aspect_d = 11;
  relief.flags = haptic::kMotionCut;
  relief.columns = 3;
  relief.rows = 2;
  for (int i = 0; i < 6; ++i) {
    const auto number = static_cast<float>(i);
    relief.cells.push_back({0.0125F * number - 0.03F, 300 * number, 0.25F * number, number / 8});
  }
  return relief;
}

std::vector<std::uint8_t> packed(const ReliefField &relief) {
  std::vector<std::uint8_t> bytes(haptic::packed_size(relief));
  haptic::pack_relief_field(relief, bytes);
  return bytes;
}

bool is_read(std::span<const std::uint8_t> bytes) {
  ReliefField relief;
  return haptic::unpack_relief_field(bytes, relief);
}

TEST(ReliefField, ComesBackBitByBit) {
  ReliefField relief;
  ASSERT_TRUE(haptic::unpack_relief_field(packed(small_relief()), relief));
  EXPECT_EQ(relief, small_relief());
}

TEST(ReliefField, EveryTruncationIsRefused) {
  const auto bytes = packed(small_relief());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(is_read(std::span(bytes).first(size))) << size;
}

TEST(ReliefField, AReliefAndAMotionFieldAreNotTakenForOneAnother) {
  const auto bytes = packed(small_relief());
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 4), "HMSP");
  EXPECT_EQ(bytes[5], 2);
  haptic::MotionField motion;
  EXPECT_FALSE(haptic::unpack_motion_field(bytes, motion));
  motion = {{.frame_width = 8, .frame_height = 8, .columns = 1, .rows = 1, .cells = {{}}}, {}};
  std::vector<std::uint8_t> motion_bytes(haptic::packed_size(motion) + 8);
  haptic::pack_motion_field(motion, motion_bytes);
  EXPECT_FALSE(is_read(motion_bytes));
}

TEST(ReliefField, NumbersThatAreNotFiniteOrOutOfRangeAreRefused) {
  const auto refuses = [](float ReliefCell::*number, float value) {
    ReliefField relief = small_relief();
    relief.cells[4].*number = value;
    return !is_valid(relief) && !is_read(packed(relief));
  };
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    for (auto number : {&ReliefCell::height, &ReliefCell::stiffness, &ReliefCell::friction,
                        &ReliefCell::validity})
      EXPECT_TRUE(refuses(number, bad));
  EXPECT_TRUE(refuses(&ReliefCell::height, 1.01F)); // millimetres taken for metres
  EXPECT_TRUE(refuses(&ReliefCell::height, -1.01F));
  EXPECT_TRUE(refuses(&ReliefCell::stiffness, -1));
  EXPECT_TRUE(refuses(&ReliefCell::stiffness, 1.01e5F));
  EXPECT_TRUE(refuses(&ReliefCell::friction, -0.1F));
  EXPECT_TRUE(refuses(&ReliefCell::friction, 10.1F));
  EXPECT_TRUE(refuses(&ReliefCell::validity, 1.01F));
  EXPECT_FALSE(refuses(&ReliefCell::height, 1));
}

TEST(ReliefField, AReliefWithMoreCellsThanItHasBytesOrThanAreAllowedIsRefused) {
  auto bytes = packed(small_relief());
  bytes[32] = bytes[33] = bytes[34] = bytes[35] = 0xFF;
  EXPECT_FALSE(is_read(bytes));
  bytes.resize(haptic::kFieldHeaderSize + 65535UL * haptic::kReliefCellSize);
  EXPECT_FALSE(is_read(bytes));
  bytes[32] = bytes[33] = bytes[34] = bytes[35] = 0;
  EXPECT_FALSE(is_read(bytes));
}

} // namespace relief_field_test
