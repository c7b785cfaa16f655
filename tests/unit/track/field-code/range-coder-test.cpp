// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-code/range-coder.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace range_coder_test {

using haptic::BitModel;
using haptic::RangeDecoder;
using haptic::RangeEncoder;
using Bytes = std::vector<std::uint8_t>;

// Random bits, of which `ones` are 1, each third of them without a model.
std::vector<bool> random_bits(unsigned seed, std::size_t count, double ones) {
  std::mt19937 random(seed);
  std::bernoulli_distribution is_one(ones);
  std::vector<bool> bits;
  for (std::size_t i = 0; i < count; ++i)
    bits.push_back(is_one(random));
  return bits;
}

Bytes encoded(const std::vector<bool> &bits) {
  RangeEncoder encoder;
  BitModel model;
  for (std::size_t i = 0; i < bits.size(); ++i)
    if (i % 3 == 2)
      encoder.even_bit(bits[i]);
    else
      encoder.bit(model, bits[i]);
  Bytes bytes;
  encoder.finish(bytes);
  return bytes;
}

std::vector<bool> decoded(const Bytes &bytes, std::size_t count) {
  RangeDecoder decoder(bytes);
  BitModel model;
  std::vector<bool> bits;
  for (std::size_t i = 0; i < count; ++i)
    bits.push_back(i % 3 == 2 ? decoder.even_bit() : decoder.bit(model));
  return bits;
}

std::size_t size_of(const std::vector<bool> &bits) {
  RangeEncoder encoder;
  BitModel model;
  for (const bool bit : bits)
    encoder.bit(model, bit);
  Bytes bytes;
  encoder.finish(bytes);
  return bytes.size();
}

TEST(RangeCoder, GivesBackEveryBit) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const auto bits = random_bits(seed, seed * 7, (seed % 11) / 10.0);
    EXPECT_EQ(decoded(encoded(bits), bits.size()), bits) << seed;
  }
}

TEST(RangeCoder, CarriesRunThroughWaitingBytes) {
  // A bit that the model takes for unlikely, after many that it took for likely, adds to a long row
  // of 0xFF.
  for (std::size_t before = 0; before < 300; ++before) {
    std::vector<bool> bits(before, true);
    bits.push_back(false);
    bits.insert(bits.end(), 40, true);
    EXPECT_EQ(decoded(encoded(bits), bits.size()), bits) << before;
  }
}

TEST(RangeCoder, CostsLittleMoreThanTheEntropy) {
  for (const double ones : {0.02, 0.1, 0.3, 0.5}) {
    constexpr std::size_t kBits = 20'000;
    const double entropy = -ones * std::log2(ones) - (1 - ones) * std::log2(1 - ones); // bits
    const double size = 8.0 * static_cast<double>(size_of(random_bits(1, kBits, ones)));
    EXPECT_LT(size, 1.05 * entropy * kBits + 64) << ones;
    EXPECT_GT(size, 0.95 * entropy * kBits) << ones;
  }
}

TEST(RangeCoder, NothingCostsNothing) {
  Bytes bytes;
  RangeEncoder().finish(bytes);
  EXPECT_LE(bytes.size(), 1U);
  EXPECT_LE(size_of(std::vector<bool>(1000, false)), 12U) << "zeros at the end are left out";
}

TEST(RangeCoder, TheEndStandsForZeros) {
  const auto bits = random_bits(3, 500, 0.2);
  Bytes bytes = encoded(bits);
  bytes.insert(bytes.end(), 20, 0);
  EXPECT_EQ(decoded(bytes, bits.size()), bits);
}

TEST(RangeCoder, AppendsToWhatIsThere) {
  RangeEncoder encoder;
  encoder.even_bit(true);
  Bytes bytes = {1, 2, 3};
  encoder.finish(bytes);
  ASSERT_GE(bytes.size(), 3U);
  EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 3), (Bytes{1, 2, 3}));
}

TEST(RangeCoder, AnyBytesDecodeToSomething) {
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    Bytes bytes(random() % 40);
    for (auto &byte : bytes)
      byte = static_cast<std::uint8_t>(random());
    EXPECT_EQ(decoded(bytes, 1000).size(), 1000U);
  }
}

TEST(BitModel, NeverBecomesCertain) {
  BitModel zeros;
  BitModel ones;
  constexpr std::uint32_t kRange = 1U << 24; // the smallest that the coder keeps
  for (int i = 0; i < 10'000; ++i) {
    zeros.learn(false);
    ones.learn(true);
    ASSERT_LT(zeros.bound(kRange), kRange);
    ASSERT_GT(ones.bound(kRange), 0U);
  }
}

} // namespace range_coder_test
