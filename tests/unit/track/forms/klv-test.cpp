// SPDX-License-Identifier: LGPL-2.1-or-later
#include "forms/klv.hpp"
#include "track-samples.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace klv_test {

using haptic::KlvKind;
using haptic::KlvReader;
using haptic::TrackPointer;
using haptic::TrackSample;
using Bytes = std::vector<std::uint8_t>;

haptic::KlvItem read_one(const Bytes &bytes) {
  KlvReader reader(bytes);
  const auto item = reader.next();
  EXPECT_TRUE(item.has_value());
  return item.value_or(haptic::KlvItem{});
}

void append(Bytes &bytes, const Bytes &more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

TEST(Klv, SamplesComeBackToTheBit) {
  test::TrackSamples samples(1);
  for (int i = 0; i < 1000; ++i) {
    const TrackSample sample = samples.next();
    const auto item = read_one(write_klv(sample));
    ASSERT_EQ(item.kind, KlvKind::motion);
    EXPECT_EQ(item.sample, sample);
  }
}

TEST(Klv, TimesMayBeUnknown) {
  TrackSample sample = test::TrackSamples(2).next();
  sample.time = sample.duration = haptic::kNoTime;
  EXPECT_EQ(read_one(write_klv(sample)).sample, sample);
}

TEST(Klv, BeginsAsSt336DemandsWithTheExperimentalClass) {
  const Bytes bytes = write_klv(test::TrackSamples(3).next());
  const Bytes label = {0x06, 0x0E, 0x2B, 0x34, 0x02, 0x0B, 0x01, 0x01,
                       0x0F, 0x48, 0x41, 0x50, 0x54, 0x49, 0x43, 0x01};
  EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 16), label);
  EXPECT_EQ(bytes[16], 0x82); // two bytes of length follow
  EXPECT_EQ(bytes[17] * 256U + bytes[18], bytes.size() - 19);
  EXPECT_EQ(bytes[19], 1); // the version comes first
  EXPECT_EQ(bytes[20], 1);
  EXPECT_EQ(bytes[21], 1);
}

TEST(Klv, ATruncatedSampleIsRefusedAtEveryByte) {
  const Bytes whole = write_klv(test::TrackSamples(4).next());
  for (std::size_t size = 1; size < whole.size(); ++size) {
    const Bytes part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    KlvReader reader(part);
    const auto item = reader.next();
    ASSERT_TRUE(item);
    EXPECT_EQ(item->kind, KlvKind::damaged) << size;
    EXPECT_STRNE(item->error, "");
    EXPECT_LT(item->offset, part.size());
    EXPECT_FALSE(reader.next());
  }
}

TEST(Klv, SetsOfOtherOriginArePassedOver) {
  Bytes foreign = {0x06, 0x0E, 0x2B, 0x34, 0x02, 0x0B, 0x01, 0x01, 0x0E, 0x01,
                   0x03, 0x01, 0x01, 0x00, 0x00, 0x00, 3,    2,    1,    7};
  const TrackSample sample = test::TrackSamples(5).next();
  append(foreign, write_klv(sample));
  KlvReader reader(foreign);
  EXPECT_EQ(reader.next()->kind, KlvKind::foreign);
  const auto item = reader.next();
  EXPECT_EQ(item->kind, KlvKind::motion);
  EXPECT_EQ(item->sample, sample);
  EXPECT_FALSE(reader.next());
}

TEST(Klv, AfterDamageTheNextSampleIsFound) {
  const TrackSample sample = test::TrackSamples(6).next();
  Bytes bytes = {1, 2, 3, 6, 14, 43, 52};
  append(bytes, write_klv(sample));
  KlvReader reader(bytes);
  EXPECT_EQ(reader.next()->kind, KlvKind::damaged);
  EXPECT_EQ(reader.next()->sample, sample);
}

TEST(Klv, UnknownTagsAreSkippedAndMissingOrDoubleOnesRefused) {
  TrackSample sample = test::TrackSamples(7).next();
  sample.motion.held = {};
  const Bytes whole = write_klv(sample);
  const auto with = [&](const Bytes &more) {
    Bytes bytes = whole;
    append(bytes, more);
    bytes[18] = static_cast<std::uint8_t>(bytes[18] + more.size());
    return read_one(bytes);
  };
  EXPECT_EQ(with({100, 2, 0, 0}).kind, KlvKind::motion);
  EXPECT_EQ(with({0x81, 0x01, 1, 0}).kind, KlvKind::motion); // a tag of two bytes
  EXPECT_EQ(with({1, 1, 1}).kind, KlvKind::damaged);         // the version again
  EXPECT_EQ(with({100, 9, 0}).kind, KlvKind::damaged);       // longer than the set
  EXPECT_EQ(with({100, 0x80}).kind, KlvKind::damaged);       // of indefinite length
  Bytes shorter(whole.begin(), whole.end() - 3);             // without the model
  shorter[18] = static_cast<std::uint8_t>(shorter[18] - 3);
  const auto item = read_one(shorter);
  EXPECT_EQ(item.kind, KlvKind::damaged);
  EXPECT_STREQ(item.error, "a value is missing");
}

TEST(Klv, AHeldThingIsAppendedInTagsThatEarlierReadersSkip) {
  TrackSample sample = test::TrackSamples(7).next();
  sample.motion.held = {};
  const Bytes without = write_klv(sample);
  sample.motion.held = {haptic::HoldState::about, 0.25F, 0.5F, 1, 0x0102};
  Bytes with = write_klv(sample);
  EXPECT_EQ(without.size(), 134U);
  EXPECT_EQ(Bytes(with.begin() + 134, with.end()), (Bytes{17, 1, 2,                               //
                                                          18, 8, 0x3E, 0x80, 0, 0, 0x3F, 0, 0, 0, //
                                                          19, 4, 0x3F, 0x80, 0, 0,                //
                                                          20, 8, 0,    0,    0, 0, 0,    0, 1, 2}));
  with.resize(134);
  with[18] = without[18]; // the length
  EXPECT_EQ(with, without);
}

TEST(Klv, AHeldThingWithoutItsPlaceOrOutOfRangeIsRefused) {
  TrackSample sample = test::TrackSamples(7).next();
  sample.motion.held = {haptic::HoldState::held, 0.25F, 0.5F, 1, 0x0102};
  Bytes bytes = write_klv(sample);
  bytes[134] = 21; // a later tag instead of the state: nothing is held
  EXPECT_EQ(read_one(bytes).sample.motion.held, haptic::HeldPlace{});
  bytes[134] = 17;
  bytes[136] = 6; // the state
  EXPECT_STREQ(read_one(bytes).error, "a value is out of its range");
  bytes[136] = 1;
  EXPECT_EQ(read_one(bytes).kind, KlvKind::motion);
  for (const std::size_t tag : {137, 147, 153}) {
    Bytes changed = bytes;
    changed[tag] = 21;
    EXPECT_STREQ(read_one(changed).error, "a value is missing") << tag;
  }
}

TEST(Klv, OtherVersionsAndKindsAreToldFromDamage) {
  Bytes bytes = write_klv(test::TrackSamples(8).next());
  bytes[21] = 2;
  EXPECT_EQ(read_one(bytes).kind, KlvKind::other_version);
  bytes[21] = 1;
  bytes[24] = 3; // the kind
  EXPECT_EQ(read_one(bytes).kind, KlvKind::other_sample);
  bytes[24] = 1; // a field, but of none of its bytes
  EXPECT_EQ(read_one(bytes).kind, KlvKind::damaged);
}

TEST(Klv, NumbersThatCannotBeAreRefused) {
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    TrackSample sample = test::TrackSamples(9).next();
    sample.motion.velocity_x = value;
    EXPECT_EQ(read_one(write_klv(sample)).kind, KlvKind::damaged);
  }
  TrackSample sample = test::TrackSamples(9).next();
  sample.motion.confidence = 1.5F;
  EXPECT_EQ(read_one(write_klv(sample)).kind, KlvKind::damaged);
}

TEST(KlvPointer, ComesBackToTheBit) {
  const TrackPointer pointer{4'000'000'000U, 0.1, 1.0 / 3, -0.7, true, "SPIDAR-G6 3L"};
  EXPECT_EQ(haptic::read_klv_pointer(write_klv(pointer)), pointer);
}

TEST(KlvPointer, OutOfRangeTruncatedOrForeignIsNone) {
  const Bytes whole = write_klv(TrackPointer{});
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(haptic::read_klv_pointer(std::span(whole).first(size))) << size;
  for (const double x : {-0.1, 1.1, std::nan("")})
    EXPECT_FALSE(haptic::read_klv_pointer(write_klv(TrackPointer{.x = x})));
  EXPECT_FALSE(haptic::read_klv_pointer(write_klv(test::TrackSamples(1).next())));
}

TEST(Klv, AFieldComesBackWithItsTimes) {
  for (const std::size_t size : {1, 127, 128, 5000}) {
    const haptic::CodedField field{std::vector<std::uint8_t>(size, 7), 123,
                                   size % 2 ? 456 : haptic::kNoTime};
    const auto bytes = write_klv(field);
    const auto item = KlvReader(bytes).next();
    ASSERT_EQ(item->kind, KlvKind::field);
    EXPECT_EQ((haptic::CodedField{{item->field.begin(), item->field.end()},
                                  item->sample.time,
                                  item->sample.duration}),
              field);
  }
}

TEST(Klv, ThingsOfAFieldStandInATagThatEarlierReadersSkip) {
  haptic::CodedField field{{1, 2, 3}, 123, 456};
  const Bytes without = write_klv(field);
  field.things = {1, 0, 0, 0, 7, 0, 1, 0, 0, 0x40, 0, 0x80, 0, 8, 0, 0};
  Bytes with = write_klv(field);
  EXPECT_EQ(coded_field_of(read_one(with)), field);
  // Another tag is all that is new.
  ASSERT_EQ(with.size(), without.size() + 2 + field.things.size());
  EXPECT_EQ(with[without.size()], 34);
  with.resize(without.size());
  with[18] = without[18];
  EXPECT_EQ(with, without);
}

TEST(Klv, ThingsThatAreNoneAreRefused) {
  haptic::CodedField field{{1, 2, 3}, 123, 456};
  for (const Bytes &things : {Bytes{1}, Bytes{1, 0, 0, 0}, Bytes{33, 0, 0, 0}, Bytes(28, 4)}) {
    field.things = things;
    EXPECT_EQ(read_one(write_klv(field)).kind, KlvKind::damaged);
  }
}

} // namespace klv_test
