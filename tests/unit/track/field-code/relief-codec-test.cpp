// SPDX-License-Identifier: LGPL-2.1-or-later
#include "depth-scene.hpp"
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"
#include "forms/text-line.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <random>

namespace relief_codec_test {

using haptic::CodedField;
using haptic::FieldKind;
using haptic::ReliefCell;
using haptic::ReliefDecoder;
using haptic::ReliefEncoder;
using haptic::ReliefField;
using Bytes = std::vector<std::uint8_t>;
using Result = ReliefDecoder::Result;
using test::DepthScene;

constexpr int kSeconds = 6;
constexpr int kFrames = 30 * kSeconds;

// Of the cells that have a surface.
double largest_error(const ReliefField &sent, const ReliefField &got) {
  double largest = 0;
  for (std::size_t i = 0; i < sent.cells.size(); ++i)
    if (sent.cells[i].validity > 0)
      largest = std::max(largest, std::abs(static_cast<double>(sent.cells[i].height) -
                                           static_cast<double>(got.cells[i].height)));
  return largest;
}

// A slope with a hole, in two materials.
ReliefField slope() {
  ReliefField relief;
  relief.interval = DepthScene::kInterval;
  relief.frame_width = 320;
  relief.frame_height = 180;
  relief.columns = 16;
  relief.rows = 9;
  for (int i = 0; i < 16 * 9; ++i) {
    const auto place = static_cast<float>(i % 16);
    relief.cells.push_back(
        {0.001F * place - 0.008F, i % 16 < 8 ? 100.F : 1500.F, i % 16 < 8 ? 0.2F : 0.85F, 1});
  }
  relief.cells[40] = {};
  return relief;
}

std::vector<Bytes> coded(int frames) {
  ReliefEncoder encoder;
  std::vector<Bytes> all;
  for (int i = 0; i < frames; ++i)
    all.push_back(encoder.push(DepthScene::relief(i)).value());
  return all;
}

TEST(ReliefCodec, AMovingSceneComesBackWithinTwoPercentOfItsRangeIn100KilobitsASecond) {
  ReliefEncoder encoder;
  ReliefDecoder decoder;
  double largest = 0;
  std::size_t size = 0;
  for (int i = 0; i < kFrames; ++i) {
    const ReliefField sent = DepthScene::relief(i);
    const auto bytes = encoder.push(sent);
    ASSERT_TRUE(bytes);
    size += haptic::write_klv(
                CodedField{*bytes, i * DepthScene::kInterval, haptic::kNoTime, FieldKind::relief})
                .size();
    ASSERT_EQ(decoder.push(*bytes), Result::field) << i;
    ASSERT_TRUE(is_valid(decoder.field()));
    largest = std::max(largest, largest_error(sent, decoder.field()));
  }
  const double rate = 8e-3 * static_cast<double>(size) / kSeconds;
  std::printf("64 columns: %.1f kbit/s as KLV, largest error %.2f %% of %.0f mm\n", rate,
              100 * largest / DepthScene::kRange, 1000 * DepthScene::kRange);
  EXPECT_LE(rate, 100);
  EXPECT_LE(largest, 0.02 * DepthScene::kRange);
}

TEST(ReliefCodec, WhatStandsStillStaysToTheBit) {
  ReliefEncoder encoder;
  ReliefDecoder decoder;
  decoder.push(encoder.push(slope()).value());
  const auto first = decoder.field().cells;
  for (int i = 1; i < 70; ++i) { // over two pairs of key fields
    ReliefField noisy = slope();
    for (ReliefCell &cell : noisy.cells)
      cell.height += (i % 2 == 0 ? 1.F : -1.F) * 2e-5F; // less than half a step
    decoder.push(encoder.push(noisy).value());
    ASSERT_EQ(decoder.field().cells, first) << i;
  }
}

TEST(ReliefCodec, MaterialsAndHolesComeBack) {
  ReliefEncoder encoder;
  ReliefDecoder decoder;
  ASSERT_EQ(decoder.push(encoder.push(slope()).value()), Result::field);
  const ReliefField sent = slope();
  for (std::size_t i = 0; i < sent.cells.size(); ++i) {
    const ReliefCell &wanted = sent.cells[i];
    const ReliefCell &got = decoder.field().cells[i];
    if (i == 40) {
      EXPECT_EQ(got, ReliefCell{});
      continue;
    }
    EXPECT_NEAR(got.height, wanted.height, 0.02 * 0.015) << i;
    EXPECT_NEAR(got.stiffness / wanted.stiffness, 1, 0.09) << i;
    EXPECT_NEAR(got.friction, wanted.friction, 0.05) << i;
    EXPECT_EQ(got.validity, 1) << i;
  }
}

TEST(ReliefCodec, TheExtremesOfAReliefComeBack) {
  ReliefField relief = slope();
  relief.cells[0] = {1, 1e5F, 10, 1};
  relief.cells[1] = {-1, 0, 0, 0.01F};
  ReliefEncoder encoder;
  ReliefDecoder decoder;
  ASSERT_EQ(decoder.push(encoder.push(relief).value()), Result::field);
  EXPECT_TRUE(is_valid(decoder.field()));
  EXPECT_NEAR(decoder.field().cells[0].height, 1, 0.04);
  EXPECT_NEAR(decoder.field().cells[0].stiffness, 1e5, 9e3);
  EXPECT_EQ(decoder.field().cells[0].friction, 10);
  EXPECT_NEAR(decoder.field().cells[1].height, -1, 0.04);
  EXPECT_GT(decoder.field().cells[1].validity, 0) << "little, but not nothing";
}

TEST(ReliefCodec, ALostReliefCostsNoneButItself) {
  const auto all = coded(30);
  ReliefDecoder whole;
  ReliefDecoder lossy;
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_EQ(whole.push(all[i]), Result::field);
    if (i == 7 || i == 12 || i == 13)
      continue;
    ASSERT_EQ(lossy.push(all[i]), Result::field) << i;
    ASSERT_EQ(lossy.field(), whole.field()) << i;
  }
}

TEST(ReliefCodec, ASceneThatGetsFlatterIsStillKeptToTwoPercent) {
  ReliefEncoder encoder;
  ReliefDecoder decoder;
  for (int i = 0; i < 60; ++i) {
    ReliefField relief = DepthScene::relief(i);
    const float part = std::pow(0.93F, static_cast<float>(i));
    float lowest = 1;
    float highest = -1;
    for (ReliefCell &cell : relief.cells) {
      cell.height *= part;
      lowest = std::min(lowest, cell.height);
      highest = std::max(highest, cell.height);
    }
    decoder.push(encoder.push(relief).value());
    // Never below 1.3 of the least step, 0.05 mm.
    ASSERT_LE(largest_error(relief, decoder.field()),
              std::max(0.02 * static_cast<double>(highest - lowest), 6.6e-5))
        << i;
  }
}

// A decoded relief is rounded: its range may ask for another step where that of the film did not.
TEST(ReliefCodec, AReliefCodedAgainHasItsKeyFieldsWhereItHadThem) {
  ReliefEncoder first;
  ReliefEncoder again;
  ReliefDecoder decoder;
  for (int i = 0; i < 20; ++i) {
    ReliefField relief = slope();
    const float lowest = i == 0 ? 0 : 0.16e-3F;
    const float range = i == 0 ? 10e-3F : 6.66e-3F;
    for (std::size_t cell = 0; cell < relief.cells.size(); ++cell)
      relief.cells[cell].height = lowest + range * static_cast<float>(cell % 16) / 15;
    relief.cells[20].height = i % 2 ? 2e-3F : 5e-3F; // so that it does not rest
    const Bytes bytes = first.push(relief).value();
    ASSERT_EQ(decoder.push(bytes), Result::field);
    const Bytes moved = again.push_held(decoder.state(), decoder.rested());
    EXPECT_EQ(haptic::is_key_field(moved), haptic::is_key_field(bytes)) << i;
  }
}

TEST(ReliefCodec, AStepOfNothingIsDamage) {
  ReliefEncoder encoder;
  ReliefDecoder decoder;
  ASSERT_EQ(decoder.push(encoder.push(slope()).value()), Result::field);
  haptic::CodedRelief held = decoder.state();
  held.step = 0;
  EXPECT_EQ(decoder.push(ReliefEncoder().push_held(held, false)), Result::damaged);
}

TEST(ReliefCodec, DamageIsRefusedOrSeen) {
  const auto all = coded(4);
  std::mt19937 random(5);
  int accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    ReliefDecoder decoder;
    for (Bytes bytes : all) {
      bytes[random() % bytes.size()] ^= static_cast<std::uint8_t>(1U << random() % 8);
      accepted += decoder.push(bytes) == Result::field;
      ASSERT_TRUE(decoder.state().cells.empty() || is_valid(decoder.field()));
    }
  }
  EXPECT_LE(accepted, 8); // of 8000: bits behind the last one that counts
}

// The golden track, which tests/web/decoder-test.mjs reads, too. WRITE_GOLDEN=FOLDER writes one.
TEST(ReliefCodec, AGoldenTrackIsDecoded) {
  constexpr int kColumns = 16;
  constexpr int kReliefs = 40; // over two pairs of key fields
  if (const char *folder = std::getenv("WRITE_GOLDEN")) {
    ReliefEncoder encoder;
    std::ofstream file(folder + std::string("/golden-relief.klv"), std::ios::binary);
    for (int i = 0; i < kReliefs; ++i) {
      const Bytes set = haptic::write_klv(
          CodedField{encoder.push(DepthScene::relief(i, kColumns)).value(),
                     i * DepthScene::kInterval, haptic::kNoTime, FieldKind::relief});
      file.write(reinterpret_cast<const char *>(set.data()),
                 static_cast<std::streamsize>(set.size()));
    }
  }
  std::ifstream file(SOURCE_ROOT "/tests/data/golden-relief.klv", std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), {}};
  haptic::KlvReader reader(bytes);
  ReliefDecoder decoder;
  int count = 0;
  double largest = 0;
  while (const auto item = reader.next()) {
    ASSERT_EQ(item->field_kind, FieldKind::relief);
    ASSERT_EQ(decoder.push(item->field), Result::field) << count;
    largest =
        std::max(largest, largest_error(DepthScene::relief(count, kColumns), decoder.field()));
    ++count;
  }
  EXPECT_EQ(count, kReliefs);
  EXPECT_LE(largest, 0.02 * DepthScene::kRange);
}

// haptic-track package codes tracks anew with key fields where segments begin.
TEST(ReliefCodec, WithOtherKeyFieldsEachValueStays) {
  ReliefEncoder encoder;
  ReliefEncoder again;
  ReliefDecoder decoder;
  ReliefDecoder other;
  int keys = 0;
  for (int i = 0; i < 90; ++i) {
    ReliefField sent = DepthScene::relief(i, 16);
    const float scale = 0.4F + 0.01F * static_cast<float>(i); // the step changes on the way
    for (ReliefCell &cell : sent.cells)
      cell.height *= scale;
    ASSERT_EQ(decoder.push(encoder.push(sent).value()), Result::field);
    if (i == 50)
      again.restart();
    const Bytes bytes = again.push_held(decoder.state(), false);
    keys += haptic::is_key_field(bytes);
    EXPECT_TRUE(i != 50 || haptic::begins_pair(bytes));
    ASSERT_EQ(other.push(bytes), Result::field) << i;
    ASSERT_EQ(other.field().cells, decoder.field().cells) << i;
  }
  EXPECT_LE(keys, 12); // a pair each second, where the step changes, and at 50
}

TEST(ReliefCodec, AReliefIsNoMotionFieldInKlvAndText) {
  const CodedField sent{coded(1)[0], 5'000'000'000, haptic::kNoTime, FieldKind::relief};
  const Bytes klv = haptic::write_klv(sent);
  const auto item = haptic::KlvReader(klv).next();
  ASSERT_TRUE(item);
  EXPECT_EQ(item->kind, haptic::KlvKind::field);
  EXPECT_EQ(coded_field_of(*item), sent);
  const auto line = haptic::read_text_line(haptic::write_text_line(sent));
  ASSERT_TRUE(line.field) << line.error;
  EXPECT_EQ(*line.field, sent);
}

} // namespace relief_codec_test
