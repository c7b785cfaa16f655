// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/bits.hpp"

#include <gtest/gtest.h>
#include <random>

namespace bits_test {

using haptic::BitReader;
using haptic::BitWriter;
using Bytes = std::vector<std::uint8_t>;

TEST(Bits, TheMostSignificantComesFirst) {
  BitWriter out;
  out.put(0b101, 3);
  out.put(0x1FF, 9);
  out.put(0, 4);
  EXPECT_EQ(out.bytes(), (Bytes{0b10111111, 0b11110000}));
}

TEST(Bits, TheLastByteIsFilledWithZeros) {
  BitWriter out;
  out.put(1, 1);
  EXPECT_EQ(out.bytes(), (Bytes{0x80}));
}

TEST(Bits, OnlyTheLowBitsAreWritten) {
  BitWriter out;
  out.put(0xABCD, 8);
  out.put(~std::uint64_t{0}, 32);
  EXPECT_EQ(out.bytes(), (Bytes{0xCD, 0xFF, 0xFF, 0xFF, 0xFF}));
}

TEST(Bits, FieldsOfEachWidthComeBack) {
  std::mt19937 random(1);
  for (int round = 0; round < 100; ++round) {
    std::vector<std::pair<std::uint32_t, unsigned>> fields;
    BitWriter out;
    for (int i = 0; i < 50; ++i) {
      const unsigned width = 1 + static_cast<unsigned>(random() % 32);
      const auto value = static_cast<std::uint32_t>(random() & ((std::uint64_t{1} << width) - 1));
      fields.emplace_back(value, width);
      out.put(value, width);
    }
    BitReader in(out.bytes());
    for (const auto &[value, width] : fields)
      EXPECT_EQ(in.get(width), value);
    EXPECT_FALSE(in.failed());
    EXPECT_LT(in.left(), 8U);
  }
}

TEST(Bits, TextsComeBackCutTo255Bytes) {
  BitWriter out;
  out.put(1, 3); // they need not begin at a byte
  out.text("grass");
  out.text("");
  out.text(std::string(300, 'x'));
  BitReader in(out.bytes());
  in.get(3);
  EXPECT_EQ(in.text(), "grass");
  EXPECT_EQ(in.text(), "");
  EXPECT_EQ(in.text(), std::string(255, 'x'));
  EXPECT_FALSE(in.failed());
}

TEST(Bits, BeyondTheEndAreZerosAndItSaysSo) {
  const Bytes bytes = {0xFF, 0xFF};
  BitReader in(bytes);
  EXPECT_EQ(in.get(12), 0xFFFU);
  EXPECT_EQ(in.byte(), 1U);
  EXPECT_EQ(in.left(), 4U);
  EXPECT_FALSE(in.failed());
  EXPECT_EQ(in.get(5), 0U) << "none of a field that is not there as a whole";
  EXPECT_TRUE(in.failed());
  EXPECT_EQ(in.left(), 0U);
  EXPECT_EQ(in.get(1), 0U);
}

TEST(Bits, ATextThatIsCutOffFails) {
  const Bytes bytes = {5, 'a', 'b'};
  BitReader in(bytes);
  in.text();
  EXPECT_TRUE(in.failed());
  EXPECT_EQ(in.left(), 0U);
}

} // namespace bits_test
