// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"
#include "forms/text-line.hpp"
#include "leaf-fields.hpp"

#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <map>

namespace field_codec_test {

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

// A hand feels widths per second: 1.1 px/s of a frame 352 px wide, whatever the width of the frame
// and the interval of its fields.
TEST(FieldCodec, SlowMotionIsKeptAsFinelyAsAHandFeelsIt) {
  for (const std::uint64_t interval : {100'000'000U, 33'333'333U, 16'666'667U, 8'333'333U})
    for (const std::uint32_t width : {176U, 352U, 640U, 1920U, 7680U})
      for (double speed = 0.2; speed < 40; speed *= 1.1) { // px/s of a frame 352 px wide
        const double scale = width / 352.0;
        MotionField sent = pan(static_cast<float>(speed * scale), interval);
        sent.frame_width = width;
        FieldEncoder encoder;
        FieldDecoder decoder;
        const Bytes bytes = encoder.push(sent).value();
        EXPECT_TRUE(haptic::begins_pair(bytes));
        ASSERT_EQ(decoder.push(bytes), Result::field);
        const haptic::FieldCell &got = decoder.field().cells[0];
        const double error = std::hypot(got.velocity_x - sent.cells[0].velocity_x,
                                        got.velocity_y - sent.cells[0].velocity_y);
        EXPECT_LE(error, scale * std::max(1.101, 0.0701 * std::hypot(speed, speed / 2)))
            << interval << " ns, " << width << " px, " << speed << " px/s";
      }
}

// Its scale is that of the interval, whatever the rate.
TEST(FieldCodec, ATrackOfVersion02WithManyFieldsIsDecoded) {
  constexpr std::uint64_t kInterval = 16'667'000;
  FieldEncoder encoder;
  FieldDecoder now;
  ASSERT_EQ(now.push(encoder.push(pan(120, kInterval)).value()), Result::field);
  FieldDecoder::State before = now.state();
  before.scale = kInterval;
  FieldDecoder decoder;
  FieldEncoder again;
  ASSERT_EQ(decoder.push(again.push_held(before, false)), Result::field);
  const double ratio = static_cast<double>(now.state().scale) / kInterval;
  EXPECT_NEAR(decoder.field().cells[0].velocity_x, ratio * now.field().cells[0].velocity_x, 0.01);
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

TEST(FieldCodec, ALostFieldCostsOneSampleAndALostKeyFieldEverySecondOneUntilTheNextPair) {
  const auto all = coded(90);
  for (std::size_t lost = 0; lost < 40; ++lost) {
    FieldDecoder whole;
    FieldDecoder lossy;
    std::size_t missing = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      whole.push(all[i]);
      if (i == lost)
        continue;
      const Result result = lossy.push(all[i]);
      EXPECT_EQ(lossy.lost(), i == lost + 1 && lost > 0);
      const bool depends = haptic::is_key_field(all[lost]) && lost / 30 == i / 30 && i > lost &&
                           !haptic::is_key_field(all[i]) && i % 2 == lost % 2;
      ASSERT_EQ(result, depends ? Result::missing : Result::field) << lost << " " << i;
      missing += result == Result::missing;
      if (result == Result::field) {
        EXPECT_EQ(lossy.field(), whole.field());
      }
    }
    EXPECT_LE(missing, haptic::is_key_field(all[lost]) ? 14U : 0U);
  }
}

TEST(FieldCodec, ASenderThatBeginsAnewHasLostNothing) {
  FieldDecoder decoder;
  for (const int count : {40, 7, 1, 3})
    for (const Bytes &bytes : coded(count)) {
      EXPECT_EQ(decoder.push(bytes), Result::field);
      EXPECT_FALSE(decoder.lost());
    }
}

// As hapticsink does it: a field is felt until the next one, but no longer than three intervals
// beyond its own.
double share_felt(const std::vector<Bytes> &sent, double loss, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> chance(0, 1);
  FieldDecoder decoder;
  std::size_t felt = 0;
  std::size_t age = 5;
  for (const Bytes &bytes : sent) {
    ++age;
    if (chance(random) >= loss && decoder.push(bytes) == Result::field)
      age = 0;
    felt += age <= 3;
  }
  return static_cast<double>(felt) / static_cast<double>(sent.size());
}

// docs/formats/field-code.md has this table.
TEST(FieldCodec, LeavesAreFeltThroughLosses) {
  const char *wanted = std::getenv("LOSSES");
  const unsigned seeds = wanted ? static_cast<unsigned>(std::atoi(wanted)) : 10;
  constexpr int kSent = 30 * 20;
  for (const double key_interval : {0.25, 0.5, 1.0, 2.0}) {
    test::LeafFields leaves(2);
    FieldEncoder encoder(static_cast<std::uint64_t>(1e9 * key_interval));
    std::vector<Bytes> sent;
    std::size_t size = 0;
    for (int i = 0; i < kSent; ++i) {
      sent.push_back(encoder.push(leaves.next()).value());
      size += size_as_klv(sent.back(), i);
    }
    std::printf("keys each %.2f s: %.1f kbit/s", key_interval,
                8e-3 * static_cast<double>(size) / 20);
    for (const double loss : {0.01, 0.05}) {
      double mean = 0;
      double least = 1;
      for (unsigned seed = 0; seed < seeds; ++seed) {
        const double felt = share_felt(sent, loss, seed);
        mean += felt / seeds;
        least = std::min(least, felt);
      }
      std::printf(", %.0f %% lost: %.1f %% felt, at least %.1f", 100 * loss, 100 * mean,
                  100 * least);
      if (encoder.key_interval() == haptic::kKeyInterval) {
        EXPECT_GE(mean, loss > 0.01 ? 0.95 : 0.99);
      }
    }
    std::printf("\n");
  }
}

TEST(FieldCodec, ATrackOfVersion01IsDecoded) {
  std::ifstream file(SOURCE_ROOT "/tests/data/golden-field.klv", std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  haptic::KlvReader reader(bytes);
  test::LeafFields leaves(5);
  FieldDecoder decoder;
  int count = 0;
  double largest = 0;
  while (const auto item = reader.next()) {
    ASSERT_EQ(decoder.push(item->field), Result::field) << count;
    largest = std::max(largest, largest_error(leaves.next(), decoder.field()));
    ++count;
  }
  EXPECT_EQ(count, 40);
  EXPECT_LE(largest, 0.201);
}

TEST(FieldCodec, InATrackOfVersion01ALossIsSilentUntilTheNextKey) {
  std::ifstream file(SOURCE_ROOT "/tests/data/golden-field.klv", std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  haptic::KlvReader reader(bytes);
  FieldDecoder decoder;
  for (int i = 0; const auto item = reader.next(); ++i) {
    if (i == 7)
      continue;
    EXPECT_EQ(decoder.push(item->field), i > 7 && i < 30 ? Result::missing : Result::field) << i;
  }
}

TEST(FieldCodec, WhereNothingMovesNothingIsSentButAKeyFieldEachSecond) {
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
    return haptic::begins_pair(encoder.push(field).value());
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
  EXPECT_FALSE(begins(pan(50, 16'700'000)));
}

TEST(FieldCodec, KeyFieldsCanBeMovedAndNoValueChanges) {
  test::LeafFields leaves(3);
  FieldEncoder first;
  FieldEncoder again;
  FieldDecoder before;
  FieldDecoder after;
  FieldDecoder late; // begins at each of the new key fields
  for (int i = 0; i < kFrames; ++i) {
    MotionField field = i % 100 < 20 ? pan(i % 100 < 10 ? 40 : 0) : leaves.next();
    field.interval += static_cast<std::uint64_t>(i % 3) * 11'000; // not that of the scale
    const auto bytes = first.push(field);
    if (!bytes)
      continue;
    ASSERT_EQ(before.push(*bytes), Result::field) << i;
    const bool restarted = i % 100 == 7 || i % 100 == 55;
    if (restarted) {
      again.restart();
      late.forget();
    }
    const Bytes moved = again.push_held(before.state(), before.rested());
    ASSERT_EQ(after.push(moved), Result::field) << i;
    EXPECT_FALSE(after.lost());
    EXPECT_EQ(after.rested(), before.rested()) << i;
    EXPECT_EQ(late.push(moved), Result::field) << i;
    for (const FieldDecoder *decoder : {&after, &late}) {
      EXPECT_EQ(decoder->state().scale, before.state().scale) << i;
      EXPECT_EQ(decoder->field(), before.field()) << i;
    }
    EXPECT_TRUE(!restarted || haptic::is_key_field(moved)) << i;
  }
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

TEST(FieldCodec, ADamagedFieldIsKnownAndHarmsNoOther) {
  const auto all = coded(7);
  FieldDecoder before;
  for (std::size_t i = 0; i < 5; ++i)
    before.push(all[i]);
  FieldDecoder whole = before;
  whole.push(all[5]);
  FieldDecoder after = whole;
  after.push(all[6]);
  for (std::size_t at = 0; at < all[5].size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      FieldDecoder decoder = before;
      Bytes bytes = all[5];
      bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ 1U << bit);
      // The last bits may say what others would, too.
      const bool taken = decoder.push(bytes) == Result::field;
      EXPECT_EQ(decoder.field(), taken ? whole.field() : before.field()) << at << " " << bit;
      EXPECT_EQ(decoder.push(all[6]), Result::field);
      EXPECT_EQ(decoder.field(), after.field());
    }
}

} // namespace field_codec_test
