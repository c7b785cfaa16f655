// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-sample.hpp"

#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace motion_sample_test {

using haptic::MotionSample;

MotionSample full_sample() {
  MotionSample s;
  s.velocity_x = 12.5F;
  s.velocity_y = -3.25F;
  s.spin = 0.5F;
  s.divergence = -0.125F;
  s.pointer_x = 0.25F;
  s.pointer_y = 0.75F;
  s.region_width = 0.1F;
  s.region_height = 0.2F;
  s.confidence = 0.875F;
  s.interval = 33'333'333;
  s.frame_width = 352;
  s.frame_height = 288;
  s.pixel_aspect_n = 12;
  s.pixel_aspect_d = 11;
  s.points = 17;
  s.flags = haptic::kMotionCut;
  s.model = haptic::MotionModel::translation;
  return s;
}

MotionSample held_sample() {
  MotionSample s = full_sample();
  s.held = {haptic::HoldState::hidden, 0.5F, 0.25F, 0.125F, 0x0102030405060708};
  return s;
}

std::optional<MotionSample> sent(const MotionSample &sample) {
  return haptic::unpack_motion_sample(haptic::pack_motion_sample(sample));
}

std::vector<std::uint8_t> bytes_of(const MotionSample &sample) {
  const auto bytes = haptic::pack_motion_sample(sample);
  return {bytes.begin(), bytes.end()};
}

TEST(MotionSample, ComesBackBitByBit) {
  EXPECT_EQ(sent(full_sample()), full_sample());
  EXPECT_EQ(sent(held_sample()), held_sample());
}

TEST(MotionSample, AHeldThingIsAppended) {
  const auto without = bytes_of(full_sample());
  auto with = bytes_of(held_sample());
  EXPECT_EQ(without.size(), 72U);
  const std::vector<std::uint8_t> held(with.begin() + 72, with.end());
  with.resize(72);
  EXPECT_EQ(with, without) << "a reader that knows the first 72 bytes reads the same motion";
  EXPECT_EQ(held, (std::vector<std::uint8_t>{0, 0, 0, 0x3f, 0, 0, 0x80, 0x3e, 0, 0, 0, 0x3e,
                                             3, 0, 0, 0,    8, 7, 6,    5,    4, 3, 2, 1}));
}

TEST(MotionSample, NothingIsHeldInASampleOf72Bytes) {
  auto bytes = bytes_of(held_sample());
  bytes.resize(72);
  EXPECT_EQ(haptic::unpack_motion_sample(bytes), full_sample());
}

TEST(MotionSample, StartsWithItsNameAndVersionSoThatAFileExplainsItself) {
  const auto bytes = haptic::pack_motion_sample(full_sample());
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 4), "HMSP");
  EXPECT_EQ(bytes[4], 1);
}

TEST(MotionSample, EveryTruncationIsRefused) {
  const auto bytes = bytes_of(held_sample());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    if (size == 72) // nothing is held
      continue;
    const std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<long>(size));
    EXPECT_EQ(haptic::unpack_motion_sample(cut), std::nullopt) << size;
  }
}

TEST(MotionSample, LongerInputIsALaterVersionWithMoreFields) {
  auto longer = bytes_of(held_sample());
  longer.resize(longer.size() + 9, 0xAA);
  EXPECT_EQ(haptic::unpack_motion_sample(longer), held_sample());
}

TEST(MotionSample, NumbersThatAreNotFiniteOrOutOfRangeAreRefused) {
  for (float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                    -std::numeric_limits<float>::infinity()}) {
    for (float MotionSample::*field : std::initializer_list<float MotionSample::*>{
             &MotionSample::velocity_x, &MotionSample::velocity_y, &MotionSample::spin,
             &MotionSample::divergence, &MotionSample::pointer_x, &MotionSample::confidence,
             &MotionSample::region_width}) {
      MotionSample s = full_sample();
      s.*field = bad;
      EXPECT_EQ(sent(s), std::nullopt);
    }
    using haptic::HeldPlace;
    for (float HeldPlace::*field : {&HeldPlace::x, &HeldPlace::y, &HeldPlace::radius}) {
      MotionSample s = held_sample();
      s.held.*field = bad;
      EXPECT_EQ(sent(s), std::nullopt);
    }
  }
  MotionSample s = full_sample();
  s.confidence = 1.5F;
  EXPECT_EQ(sent(s), std::nullopt);
  s = full_sample();
  s.frame_width = 0;
  EXPECT_EQ(sent(s), std::nullopt);
  s = held_sample();
  s.held.radius = -0.5F;
  EXPECT_EQ(sent(s), std::nullopt);
  s = held_sample();
  s.held.state = static_cast<haptic::HoldState>(6);
  EXPECT_EQ(sent(s), std::nullopt);
}

TEST(MotionSample, AFlippedBitNeverYieldsAValueOutsideItsRange) {
  const auto bytes = bytes_of(held_sample());
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    auto flipped = bytes;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1U << (bit % 8)));
    if (const auto s = haptic::unpack_motion_sample(flipped)) {
      EXPECT_TRUE(std::isfinite(s->velocity_x) && std::isfinite(s->velocity_y)) << bit;
      EXPECT_GE(s->confidence, 0) << bit;
      EXPECT_LE(s->confidence, 1) << bit;
      EXPECT_TRUE(s->held.x >= 0 && s->held.x <= 1) << bit;
      EXPECT_LE(s->held.state, haptic::HoldState::refused) << bit;
    }
  }
}

} // namespace motion_sample_test
