// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/field-track.hpp"

#include "depth-scene.hpp"
#include "leaf-track.hpp"

#include <gtest/gtest.h>

namespace field_track_test {

using haptic::CodedField;
using haptic::FieldKind;
using haptic::MotionField;
using haptic::ReliefField;
using test::DepthScene;

constexpr std::uint64_t kInterval = test::LeafFields::kInterval;
constexpr std::size_t kCount = 100; // three times as long as a pair of key fields lasts

template <typename Field>
using Timed = std::vector<std::pair<std::uint64_t, Field>>;

Timed<MotionField> fields_of(const std::vector<CodedField> &track) {
  Timed<MotionField> fields;
  haptic::for_each_field(track, [&](const MotionField &field, std::uint64_t time) {
    fields.emplace_back(time, field);
  });
  return fields;
}

Timed<ReliefField> reliefs_of(const std::vector<CodedField> &track) {
  Timed<ReliefField> reliefs;
  haptic::for_each_relief(track, [&](const ReliefField &relief, std::uint64_t time) {
    reliefs.emplace_back(time, relief);
  });
  return reliefs;
}

std::vector<CodedField> relief_track() {
  haptic::ReliefEncoder encoder;
  std::vector<CodedField> track;
  for (std::size_t i = 0; i < kCount; ++i)
    track.push_back({encoder.push(DepthScene::relief(static_cast<int>(i), 16)).value(),
                     i * kInterval, haptic::kNoTime, FieldKind::relief});
  return track;
}

template <typename Field>
Timed<Field> within(const Timed<Field> &all, std::uint64_t from, std::uint64_t to) {
  Timed<Field> part;
  for (const auto &[time, field] : all)
    if (time >= from && time < to)
      part.emplace_back(time - from, field);
  return part;
}

// Uniform motion of the whole frame, one frame width a second at `speed` 1.
MotionField pan(float speed) {
  MotionField field;
  field.interval = kInterval;
  field.frame_width = 640;
  field.frame_height = 360;
  field.columns = 8;
  field.rows = 4;
  field.cells.assign(32, {speed * 640, 0, 1});
  return field;
}

TEST(FieldTrack, EachFieldComesOnceAtItsTime) {
  const auto track = test::leaf_track(kCount);
  const auto fields = fields_of(track);
  ASSERT_EQ(fields.size(), kCount);
  haptic::FieldDecoder decoder;
  for (std::size_t i = 0; i < kCount; ++i) {
    ASSERT_EQ(decoder.push(track[i].bytes), haptic::FieldDecoder::Result::field);
    EXPECT_EQ(fields[i].first, track[i].time);
    EXPECT_EQ(fields[i].second, decoder.field()) << i;
  }
}

TEST(FieldTrack, FieldsAtRestThatWereLeftOutEndAtRest) {
  haptic::FieldEncoder encoder;
  std::vector<CodedField> track;
  for (std::size_t i = 0; i < 20; ++i)
    if (auto bytes = encoder.push(pan(i >= 2 && i < 18 ? 0.F : 0.5F)))
      track.push_back({*bytes, i * kInterval});
  ASSERT_LT(track.size(), 20U) << "some are left out";
  bool is_at_rest_before = false;
  for (const auto &[time, field] : fields_of(track)) {
    const double energy = haptic::field_energy(field);
    is_at_rest_before = is_at_rest_before || (time / kInterval == 17 && energy == 0);
    EXPECT_EQ(energy > 0, time / kInterval < 2 || time / kInterval >= 18) << time;
  }
  EXPECT_TRUE(is_at_rest_before) << "no line leads from the old motion to the new one";
}

TEST(FieldTrack, APartIsTheSameToTheBitFromAKeyFieldOn) {
  const auto track = test::leaf_track(kCount);
  const std::uint64_t from = 20 * kInterval; // amid a pair of key fields
  const std::uint64_t to = 80 * kInterval;
  const auto part = haptic::cut_fields(track, from, to);
  ASSERT_FALSE(part.empty());
  EXPECT_TRUE(haptic::is_key_field(part.front().bytes));
  EXPECT_EQ(fields_of(part), within(fields_of(track), from, to)) << "to the bit";
  for (const CodedField &coded : track) { // beside a key frame of a film
    if (!haptic::begins_pair(coded.bytes) || coded.time < from || coded.time >= to)
      continue;
    const auto same = std::ranges::find(part, coded.time - from, &CodedField::time);
    ASSERT_NE(same, part.end());
    EXPECT_TRUE(haptic::begins_pair(same->bytes));
  }
}

TEST(FieldTrack, ThingsStayWithTheirFieldsInAPartAndUnderOtherKeys) {
  auto track = test::leaf_track(kCount);
  for (std::size_t i = 0; i < kCount; ++i) {
    const haptic::FieldThing thing{3, haptic::HoldState::held, static_cast<float>(i) / 100, 0, 0};
    track[i].things.resize(haptic::packed_size(std::span(&thing, 1)));
    haptic::pack_field_things(std::span(&thing, 1), track[i].things);
  }
  const auto check = [&](const std::vector<CodedField> &part, std::size_t first) {
    for (const auto &[time, field] : fields_of(part)) {
      ASSERT_EQ(field.things.size(), 1U);
      EXPECT_NEAR(field.things[0].x, static_cast<float>(first + time / kInterval) / 100, 1e-5);
    }
  };
  check(track, 0);
  check(haptic::cut_fields(track, 20 * kInterval, 80 * kInterval), 20);
  check(haptic::with_keys_at(track, std::vector<std::uint64_t>{7 * kInterval}), 0);
}

TEST(FieldTrack, APartOfReliefsIsTheSameToTheBit) {
  const auto track = relief_track();
  const auto part = haptic::cut_fields(track, 20 * kInterval, 80 * kInterval);
  ASSERT_FALSE(part.empty());
  EXPECT_TRUE(haptic::is_key_field(part.front().bytes));
  EXPECT_EQ(reliefs_of(part), within(reliefs_of(track), 20 * kInterval, 80 * kInterval));
}

TEST(FieldTrack, KeyFieldsMoveAndNoValueDoes) {
  auto track = test::leaf_track(kCount);
  const auto reliefs = relief_track();
  track.insert(track.end(), reliefs.begin(), reliefs.end());
  std::ranges::stable_sort(track, {}, &CodedField::time);
  const std::vector<CodedField> motions = test::leaf_track(kCount);
  const std::vector<std::uint64_t> times = {0, 7 * kInterval + 1, 50 * kInterval};
  const auto all = haptic::with_keys_at(track, times);
  ASSERT_EQ(all.size(), track.size());
  std::vector<CodedField> of_kind[2];
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].time, track[i].time);
    EXPECT_EQ(all[i].kind, track[i].kind);
    of_kind[all[i].kind == FieldKind::relief ? 1 : 0].push_back(all[i]);
  }
  EXPECT_EQ(fields_of(of_kind[0]), fields_of(motions));
  EXPECT_EQ(reliefs_of(of_kind[1]), reliefs_of(reliefs));
  for (const auto &kind : of_kind)
    for (const std::size_t i : {0U, 8U, 50U})
      EXPECT_TRUE(haptic::is_key_field(kind[i].bytes)) << i;
}

TEST(FieldTrack, AHandFeelsEachFieldAndNothingBetween) {
  haptic::FieldEncoder encoder;
  std::vector<CodedField> track;
  for (std::size_t i = 0; i < 10; ++i)
    track.push_back({encoder.push(pan(0.1F * static_cast<float>(i + 1))).value(), i * kInterval});
  const auto fields = fields_of(track);
  const auto samples = haptic::samples_at_hand(track, {{0, 0.25F, 0.5F, 0}, {10, 0.25F, 0.5F, 0}});
  ASSERT_EQ(samples.size(), fields.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].time, track[i].time);
    EXPECT_FLOAT_EQ(samples[i].motion.velocity_x, fields[i].second.cells[0].velocity_x) << i;
    EXPECT_EQ(samples[i].motion.pointer_x, 0.25F);
  }
}

TEST(FieldTrack, TheAmountOfMotionIsItsSpeedSquaredWhereItIsSure) {
  EXPECT_EQ(haptic::field_energy(pan(0)), 0);
  EXPECT_NEAR(haptic::field_energy(pan(0.5F)), 0.25, 1e-6);
  MotionField half = pan(0.5F);
  for (std::size_t i = 0; i < 16; ++i)
    half.cells[i].confidence = 0;
  EXPECT_NEAR(haptic::field_energy(half), 0.125, 1e-6);
}

} // namespace field_track_test
