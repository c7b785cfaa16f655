// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-codec.hpp"
#include "klv.hpp"
#include "leaf-fields.hpp"
#include "text-line.hpp"

#include <gtest/gtest.h>
#include <map>

namespace {

using haptic::FieldDecoder;
using haptic::FieldEncoder;
using haptic::MotionField;
using Bytes = std::vector<std::uint8_t>;
using Result = FieldDecoder::Result;

constexpr int kSeconds = 10;
constexpr int kFrames = 30 * kSeconds;

// Of the frame's motion, px per frame; cells of no confidence say nothing.
double largest_error(const MotionField &sent, const MotionField &got) {
  double largest = 0;
  const double interval = static_cast<double>(sent.interval) * 1e-9;
  for (std::size_t i = 0; i < sent.cells.size(); ++i)
    if (sent.cells[i].confidence > 0)
      largest = std::max(largest,
                         interval * std::hypot(sent.cells[i].velocity_x - got.cells[i].velocity_x,
                                               sent.cells[i].velocity_y - got.cells[i].velocity_y));
  return largest;
}

// As KLV sets, with all that stands around the code.
std::size_t size_as_klv(const Bytes &bytes, int frame) {
  return haptic::write_klv(haptic::CodedField{bytes, frame * test::LeafFields::kInterval}).size();
}

double kilobits_a_second(test::LeafFields &&leaves) {
  FieldEncoder encoder;
  std::size_t size = 0;
  for (int i = 0; i < kFrames; ++i)
    if (const auto bytes = encoder.push(leaves.next()))
      size += size_as_klv(*bytes, i);
  return 8e-3 * static_cast<double>(size) / kSeconds;
}

std::vector<Bytes> coded(int frames, unsigned seed = 1) {
  test::LeafFields leaves(seed);
  FieldEncoder encoder;
  std::vector<Bytes> all;
  for (int i = 0; i < frames; ++i)
    all.push_back(encoder.push(leaves.next()).value());
  return all;
}

// Uniform motion of the whole frame.
MotionField pan(float pixels_per_second, std::uint64_t interval = test::LeafFields::kInterval) {
  MotionField field;
  field.interval = interval;
  field.frame_width = 640;
  field.frame_height = 360;
  field.columns = 8;
  field.rows = 4;
  field.cells.assign(32, {pixels_per_second, -pixels_per_second / 2, 1});
  return field;
}

bool is_silent(const MotionField &field) {
  return std::ranges::all_of(field.cells,
                             [](const auto &cell) { return cell == haptic::FieldCell{}; });
}

TEST(FieldCodec, LeavesInTheWindComeBackWithinAFifthOfAPixelAFrame) {
  test::LeafFields leaves(1);
  FieldEncoder encoder;
  FieldDecoder decoder;
  double largest = 0;
  for (int i = 0; i < kFrames; ++i) {
    const MotionField sent = leaves.next();
    const auto bytes = encoder.push(sent);
    ASSERT_TRUE(bytes);
    ASSERT_EQ(decoder.push(*bytes), Result::field) << i;
    EXPECT_TRUE(is_valid(decoder.field()));
    EXPECT_EQ(decoder.field().flags, sent.flags);
    EXPECT_NEAR(static_cast<double>(decoder.field().interval), static_cast<double>(sent.interval),
                500);
    largest = std::max(largest, largest_error(sent, decoder.field()));
  }
  std::printf("largest error %.3f px per frame\n", largest);
  EXPECT_LE(largest, 0.201);
}

TEST(FieldCodec, ATypicalTrackTakesNoMoreThan40KilobitsASecondWithAllThatIsAroundIt) {
  for (const double share : {0.1, 0.25, 0.5}) {
    const double rate = kilobits_a_second(test::LeafFields(2, share));
    std::printf("%.0f %% leaves: %.1f kbit/s as KLV\n", 100 * share, rate);
    EXPECT_LE(rate, 40);
  }
}

TEST(FieldCodec, AStillVideoTakesNoMoreThanOneKilobitASecond) {
  const double rate = kilobits_a_second(test::LeafFields(3, 0));
  std::printf("still, measured with noise: %.2f kbit/s as KLV\n", rate);
  EXPECT_LE(rate, 1);
}

TEST(FieldCodec, FastMotionIsKeptToSevenPercent) {
  for (float speed = 1; speed < 60'000; speed *= 1.1F) {
    FieldEncoder encoder;
    FieldDecoder decoder;
    decoder.push(encoder.push(pan(speed)).value());
    const double interval = test::LeafFields::kInterval * 1e-9;
    const double size = interval * std::hypot(speed, speed / 2);
    EXPECT_LE(largest_error(pan(speed), decoder.field()), std::max(0.201, 0.0701 * size)) << speed;
  }
}

TEST(FieldCodec, WhatWasNotMeasuredIsSilent) {
  MotionField field = pan(100);
  field.cells[5] = {};
  field.cells[6].confidence = 0.01F;
  FieldEncoder encoder;
  FieldDecoder decoder;
  decoder.push(encoder.push(field).value());
  EXPECT_EQ(decoder.field().cells[5], haptic::FieldCell{});
  EXPECT_GT(decoder.field().cells[6].confidence, 0) << "little, but not nothing";
}

TEST(FieldCodec, ConfidenceComesBackInLevelsThatDoNotFlicker) {
  FieldEncoder encoder;
  FieldDecoder decoder;
  std::map<float, int> levels;
  for (int i = 0; i < 60; ++i) {
    MotionField field = pan(static_cast<float>(100 + i));
    for (auto &cell : field.cells)
      cell.confidence = i % 2 == 0 ? 0.48F : 0.52F;
    decoder.push(encoder.push(field).value());
    ++levels[decoder.field().cells[0].confidence];
    EXPECT_NEAR(decoder.field().cells[0].confidence, 0.5, 0.15);
  }
  EXPECT_LE(levels.size(), 2U) << "one for each key field at most";
}

TEST(FieldCodec, EachSecondStandsForItself) {
  const auto all = coded(kFrames);
  int last_key = 0;
  for (int i = 0; i < kFrames; ++i)
    if (haptic::is_key_field(all[static_cast<std::size_t>(i)])) {
      EXPECT_LE(i - last_key, 30) << "a second after the one before";
      last_key = i;
    }
  EXPECT_GE(last_key, kFrames - 31);
}

TEST(FieldCodec, WhoComesLateHearsNothingUntilTheNextKeyAndThenEverything) {
  const auto all = coded(90);
  FieldDecoder whole;
  FieldDecoder late;
  bool begun = false;
  for (std::size_t i = 0; i < all.size(); ++i) {
    whole.push(all[i]);
    if (i < 40)
      continue;
    begun = begun || haptic::is_key_field(all[i]);
    EXPECT_EQ(late.push(all[i]), begun ? Result::field : Result::waiting);
    EXPECT_EQ(late.field().cells, begun ? whole.field().cells : std::vector<haptic::FieldCell>{});
  }
  EXPECT_TRUE(begun);
}

TEST(FieldCodec, AfterALossItIsSilentUntilTheNextKey) {
  const auto all = coded(90);
  for (std::size_t lost = 1; lost < 40; ++lost) {
    FieldDecoder whole;
    FieldDecoder lossy;
    bool silent = false;
    for (std::size_t i = 0; i < all.size(); ++i) {
      whole.push(all[i]);
      if (i == lost) {
        silent = true;
        continue;
      }
      silent = silent && !haptic::is_key_field(all[i]);
      ASSERT_EQ(lossy.push(all[i]), silent ? Result::missing : Result::field) << lost << " " << i;
      if (silent)
        EXPECT_TRUE(is_silent(lossy.field()));
      else
        EXPECT_EQ(lossy.field(), whole.field());
    }
  }
}

TEST(FieldCodec, WhereNothingMovesNothingIsSentButAKeyEachSecond) {
  FieldEncoder encoder;
  int sent = 0;
  for (int i = 0; i < kFrames; ++i)
    sent += encoder.push(pan(0)).has_value();
  EXPECT_EQ(sent, kSeconds);
}

TEST(FieldCodec, TheEndOfARestIsKnownSoThatNoMotionIsLedAcrossIt) {
  FieldEncoder encoder;
  FieldDecoder decoder;
  decoder.push(encoder.push(pan(50)).value());
  decoder.push(encoder.push(pan(0)).value());
  EXPECT_FALSE(decoder.rested());
  for (int i = 0; i < 45; ++i) // over a key field
    if (const auto bytes = encoder.push(pan(0)))
      decoder.push(*bytes);
  ASSERT_EQ(decoder.push(encoder.push(pan(50)).value()), Result::field);
  ASSERT_TRUE(decoder.rested());
  EXPECT_EQ(decoder.rest().cells[3].velocity_x, 0);
  EXPECT_NE(decoder.field().cells[3].velocity_x, 0);
  decoder.push(encoder.push(pan(55)).value());
  EXPECT_FALSE(decoder.rested());
}

TEST(FieldCodec, ACutAnotherSizeOrAnotherPaceBeginAnew) {
  FieldEncoder encoder;
  const auto begins = [&](const MotionField &field) {
    return haptic::is_key_field(encoder.push(field).value());
  };
  EXPECT_TRUE(begins(pan(10)));
  EXPECT_FALSE(begins(pan(20)));
  MotionField cut = pan(30);
  cut.flags = haptic::kMotionCut;
  EXPECT_TRUE(begins(cut));
  MotionField larger = pan(30);
  larger.frame_width = 1280;
  EXPECT_TRUE(begins(larger));
  EXPECT_TRUE(begins(pan(30)));
  EXPECT_TRUE(begins(pan(30, 16'666'667)));
  EXPECT_FALSE(begins(pan(40, 16'700'000)));
}

TEST(FieldCodec, TheWildestFieldStaysWithinItsBounds) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> speed(-1e6F, 1e6F);
  std::uniform_real_distribution<float> confidence(0, 1);
  MotionField field = pan(0);
  field.columns = 128;
  field.rows = 64;
  FieldEncoder encoder;
  FieldDecoder decoder;
  for (int i = 0; i < 3; ++i) {
    field.cells.assign(haptic::kMostFieldCells, {});
    for (auto &cell : field.cells)
      cell = {speed(random), speed(random), confidence(random)};
    field.cells[0] = {3e38F, -3e38F, 1};
    const auto bytes = encoder.push(field).value();
    EXPECT_LE(bytes.size(), haptic::kLargestCodedField);
    ASSERT_EQ(decoder.push(bytes), Result::field);
    const haptic::CodedField sent{bytes, 1, 2};
    EXPECT_EQ(haptic::read_text_line(haptic::write_text_line(sent)).field, sent);
    const auto klv = haptic::write_klv(sent);
    EXPECT_TRUE(std::ranges::equal(haptic::KlvReader(klv).next()->field, bytes));
  }
}

TEST(FieldCodec, ADamagedFieldIsKnownAndSilent) {
  const auto all = coded(6);
  FieldDecoder before;
  for (std::size_t i = 0; i < 5; ++i)
    before.push(all[i]);
  FieldDecoder whole = before;
  whole.push(all[5]);
  for (std::size_t at = 0; at < all[5].size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      FieldDecoder decoder = before;
      Bytes bytes = all[5];
      bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ 1U << bit);
      // The last bits may say what others would, too.
      const bool taken = decoder.push(bytes) == Result::field;
      EXPECT_TRUE(taken ? decoder.field() == whole.field() : is_silent(decoder.field()))
          << at << " " << bit;
    }
}

} // namespace
