// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"
#include "forms/text-line.hpp"
#include "forms/track-form.hpp"
#include "leaf-fields.hpp"
#include "mpeg-haptics/hmpg-form.hpp"
#include "track-samples.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <optional>

namespace track_form_test {

using haptic::InputPacket;
using haptic::kNoTime;
using haptic::MotionField;
using haptic::TimedField;
using haptic::TimedRest;
using haptic::TimedSample;
using haptic::TrackForm;
using haptic::TrackItem;
using haptic::TrackLayout;
using haptic::TrackOutput;
using haptic::TrackProblem;
using haptic::TrackProblemKind;
using haptic::TrackSample;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t kFrame = test::LeafFields::kInterval;

std::vector<TrackItem> read(TrackForm &form, const InputPacket &packet) {
  std::vector<TrackItem> items;
  form.read(packet, items);
  return items;
}

TrackProblemKind problem_in(const std::vector<TrackItem> &items) {
  EXPECT_EQ(items.size(), 1U);
  const auto *problem = std::get_if<TrackProblem>(&items.at(0));
  EXPECT_NE(problem, nullptr);
  return problem ? problem->kind : TrackProblemKind::without_time;
}

TrackOutput written(TrackForm &form, const TimedSample &sample) {
  TrackOutput output;
  form.write(sample, output);
  return output;
}

TimedSample some_sample(std::uint64_t time = 7 * kFrame) {
  TimedSample item{test::TrackSamples(1).next(), time};
  item.sample.motion.confidence = 0.5F;
  item.sample.duration = kFrame;
  return item;
}

Bytes packed(const MotionField &field) {
  Bytes bytes(haptic::packed_size(field));
  haptic::pack_motion_field(field, bytes);
  return bytes;
}

// ---- points -------------------------------------------------------------------------------------

TEST(TrackForm, EveryFormGivesBackAPoint) {
  const TimedSample sent = some_sample();
  for (const auto &make : {haptic::make_klv_form, haptic::make_text_form}) {
    const auto output = written(*make(), sent);
    ASSERT_EQ(output.packets.size(), 1U);
    const auto &packet = output.packets[0];
    EXPECT_EQ(packet.time, sent.time);
    EXPECT_EQ(packet.duration, sent.sample.duration);
    EXPECT_FALSE(packet.gap || packet.delta || packet.header);
    const auto items = read(*make(), {packet.bytes, packet.time, packet.duration});
    ASSERT_EQ(items.size(), 1U);
    const auto got = std::get<TimedSample>(items[0]);
    EXPECT_EQ(got.sample, sent.sample) << "with the sender's time";
    EXPECT_EQ(got.time, sent.time);
  }
}

TEST(TrackForm, PackedSamplesHaveTheTimesOfTheirBuffers) {
  const auto form = haptic::make_raw_form(TrackLayout::point);
  const TimedSample sent = some_sample();
  const auto output = written(*form, sent);
  ASSERT_EQ(output.packets.size(), 1U);
  const auto items = read(*form, {output.packets[0].bytes, sent.time, kFrame});
  ASSERT_EQ(items.size(), 1U);
  const auto got = std::get<TimedSample>(items[0]);
  EXPECT_EQ(got.sample.motion, sent.sample.motion);
  EXPECT_EQ(got.time, sent.time);
  EXPECT_EQ(got.sample.duration, kFrame);
  EXPECT_EQ(got.sample.time, kNoTime) << "packed samples carry no time of their own";
  EXPECT_FALSE(form->carries_time());
}

TEST(TrackForm, AGapHasNoConfidence) {
  const auto form = haptic::make_raw_form(TrackLayout::point);
  const auto bytes = haptic::pack_motion_sample(some_sample().sample.motion);
  const auto items = read(*form, {bytes, 0, kFrame, true});
  ASSERT_EQ(items.size(), 1U);
  const auto got = std::get<TimedSample>(items[0]);
  EXPECT_EQ(got.sample.motion.confidence, 0);
  EXPECT_TRUE(written(*form, got).packets.at(0).gap);
  EXPECT_TRUE(read(*form, {{}, 0, kFrame, true}).empty()) << "an empty gap is no damage";
}

TEST(TrackForm, SetsInOnePacketKeepTheirDistance) {
  TimedSample first = some_sample();
  first.sample.time = 100 * kFrame;
  TimedSample second = first;
  second.sample.time += 3 * kFrame;
  Bytes bytes = haptic::write_klv(first.sample);
  const Bytes more = haptic::write_klv(second.sample);
  bytes.insert(bytes.end(), more.begin(), more.end());
  const auto items = read(*haptic::make_klv_form(), {bytes, 5 * kFrame, kFrame});
  ASSERT_EQ(items.size(), 2U);
  EXPECT_EQ(std::get<TimedSample>(items[0]).time, 5 * kFrame);
  EXPECT_EQ(std::get<TimedSample>(items[1]).time, 8 * kFrame);
}

TEST(TrackForm, OnlyTheFirstLineHasTheTimeOfTheBuffer) {
  const std::string line = haptic::write_text_line(some_sample().sample);
  const std::string text = "\n" + line + "\n" + line + "\n";
  const Bytes bytes(text.begin(), text.end());
  const auto items = read(*haptic::make_text_form(), {bytes, kFrame, kFrame});
  ASSERT_EQ(items.size(), 2U);
  EXPECT_EQ(std::get<TimedSample>(items[0]).time, kFrame);
  EXPECT_EQ(std::get<TimedSample>(items[1]).time, kNoTime);
}

TEST(TrackForm, UnitsAreSentWhenTheyAreOver) {
  const auto form = haptic::make_hmpg_form(100'000'000);
  std::vector<haptic::OutputPacket> packets;
  const auto append = [&](const TrackOutput &output) {
    packets.insert(packets.end(), output.packets.begin(), output.packets.end());
  };
  for (std::uint64_t i = 0; i < 5; ++i)
    append(written(*form, some_sample(i * kFrame)));
  ASSERT_GE(packets.size(), 2U);
  EXPECT_TRUE(packets[0].header);
  EXPECT_FALSE(packets[1].header);
  TrackOutput rest;
  form->finish(rest);
  append(rest);
  const auto reader = haptic::make_hmpg_form(100'000'000);
  std::size_t samples = 0;
  for (const auto &packet : packets)
    for (const auto &item : read(*reader, {packet.bytes, packet.time, packet.duration}))
      samples += std::holds_alternative<TimedSample>(item);
  EXPECT_EQ(samples, 6U) << "five and silence";
}

TEST(TrackForm, AUnitNeedsATime) {
  const auto output = written(*haptic::make_hmpg_form(1'000'000), some_sample(kNoTime));
  EXPECT_TRUE(output.packets.empty());
  ASSERT_EQ(output.problems.size(), 1U);
  EXPECT_EQ(output.problems[0].kind, TrackProblemKind::damaged);
}

// ---- fields -------------------------------------------------------------------------------------

TEST(TrackForm, FieldsGoThroughEveryFormThatHoldsThem) {
  for (const auto &make : {haptic::make_klv_form, haptic::make_text_form}) {
    test::LeafFields leaves(1);
    const auto source = haptic::make_raw_form(TrackLayout::field);
    const auto target = haptic::make_raw_form(TrackLayout::field);
    const auto form = make();
    for (std::uint64_t i = 0; i < 40; ++i) {
      const MotionField sent = leaves.next();
      auto items = read(*source, {packed(sent), i * kFrame, kFrame});
      ASSERT_EQ(items.size(), 1U);
      TrackOutput coded;
      EXPECT_TRUE(form->write(std::get<TimedField>(items[0]), coded));
      ASSERT_EQ(coded.packets.size(), 1U);
      EXPECT_EQ(coded.packets[0].delta, i % 30 > 1) << "two key fields each second: " << i;
      items = read(*form, {coded.packets[0].bytes, i * kFrame, kFrame});
      ASSERT_EQ(items.size(), 1U);
      TrackOutput output;
      EXPECT_TRUE(target->write(std::get<TimedField>(items[0]), output));
      ASSERT_EQ(output.packets.size(), 1U);
      EXPECT_EQ(output.packets[0].time, i * kFrame);
      MotionField got;
      ASSERT_TRUE(haptic::unpack_motion_field(output.packets[0].bytes, got));
      EXPECT_EQ(got.cells.size(), sent.cells.size());
    }
  }
}

TEST(TrackForm, AFieldThatRestsAsBeforeIsARest) {
  const auto form = haptic::make_raw_form(TrackLayout::field);
  MotionField field = test::LeafFields(1).next();
  field.flags = 0;
  field.interval = kFrame;
  const Bytes bytes = packed(field);
  EXPECT_TRUE(std::holds_alternative<TimedField>(read(*form, {bytes, 0, kFrame}).at(0)));
  const auto items = read(*form, {bytes, kFrame, kFrame});
  ASSERT_EQ(items.size(), 1U);
  EXPECT_EQ(std::get<TimedRest>(items[0]).time, kFrame);
  EXPECT_TRUE(std::holds_alternative<TimedField>(
      read(*form, {bytes, 2 * kFrame, kFrame, false, true}).at(0)))
      << "after a discontinuity a key field comes";
}

TEST(TrackForm, ThingsGoThroughEveryFormAndEndARestWhenTheyChange) {
  for (const auto &make : {haptic::make_klv_form, haptic::make_text_form}) {
    const auto source = haptic::make_raw_form(TrackLayout::field);
    const auto target = haptic::make_raw_form(TrackLayout::field);
    const auto form = make();
    MotionField field = test::LeafFields(1).next();
    field.flags = 0;
    field.interval = kFrame;
    std::ranges::fill(field.cells, haptic::FieldCell{});
    const auto through = [&](std::uint64_t number) -> std::optional<MotionField> {
      const auto items = read(*source, {packed(field), number * kFrame, kFrame});
      const auto *timed = std::get_if<TimedField>(&items.at(0));
      if (!timed)
        return std::nullopt;
      TrackOutput coded;
      EXPECT_TRUE(form->write(*timed, coded));
      TrackOutput output;
      target->write(std::get<TimedField>(read(*form, {coded.packets.at(0).bytes}).at(0)), output);
      EXPECT_EQ(output.packets.at(0).gap, field.things.empty());
      MotionField got;
      EXPECT_TRUE(haptic::unpack_motion_field(output.packets.at(0).bytes, got));
      return got;
    };
    EXPECT_TRUE(through(0).value().things.empty());
    EXPECT_FALSE(through(1));
    field.things = {{5, haptic::HoldState::held, 1, 0, 0}};
    EXPECT_EQ(through(3).value().things, field.things);
    EXPECT_FALSE(through(4)) << "the thing rests, too";
    field.things.clear();
    EXPECT_TRUE(through(5).value().things.empty());
  }
}

TEST(TrackForm, AFieldBeforeTheFirstKeyFieldSaysNothing) {
  test::LeafFields leaves(1);
  haptic::FieldEncoder encoder;
  encoder.push(leaves.next());
  encoder.push(leaves.next());
  const TimedField third{{*encoder.push(leaves.next())}, 2 * kFrame, kFrame};
  TrackOutput output;
  EXPECT_FALSE(haptic::make_raw_form(TrackLayout::field)->write(third, output));
  EXPECT_TRUE(output.packets.empty());
  EXPECT_TRUE(output.problems.empty());
}

TEST(TrackForm, ALostFieldIsReportedOnceAndWhatDependsOnItIsPassedOver) {
  test::LeafFields leaves(1);
  haptic::FieldEncoder encoder;
  const auto form = haptic::make_raw_form(TrackLayout::field);
  TrackOutput output;
  for (std::uint64_t i = 0; i < 10; ++i) {
    const TimedField field{{*encoder.push(leaves.next())}, i * kFrame, kFrame};
    if (i == 1) // the second key field
      continue;
    EXPECT_EQ(form->write(field, output), i % 2 == 0) << i;
  }
  ASSERT_EQ(output.problems.size(), 1U);
  EXPECT_EQ(output.problems[0].kind, TrackProblemKind::missing);
  EXPECT_EQ(output.packets.size(), 5U);
}

// ---- problems -----------------------------------------------------------------------------------

TEST(TrackForm, WhatIsNoTrackIsNamed) {
  const Bytes noise = {1, 2, 3, 4, 5};
  const auto klv = haptic::make_klv_form();
  EXPECT_EQ(problem_in(read(*klv, {noise})), TrackProblemKind::damaged);
  EXPECT_EQ(problem_in(read(*haptic::make_text_form(), {noise})), TrackProblemKind::foreign_text);
  EXPECT_EQ(problem_in(read(*haptic::make_hmpg_form(1'000'000), {noise})),
            TrackProblemKind::damaged);
  for (const auto layout : {TrackLayout::point, TrackLayout::field})
    EXPECT_EQ(problem_in(read(*haptic::make_raw_form(layout), {noise})), TrackProblemKind::damaged);
  EXPECT_EQ(problem_in(read(*klv, {haptic::write_klv(haptic::TrackPointer{})})),
            TrackProblemKind::foreign_klv);
}

TEST(TrackForm, OtherVersionsAndKindsAreNamed) {
  const auto klv = haptic::make_klv_form();
  Bytes set = haptic::write_klv(some_sample().sample);
  constexpr std::size_t kVersionValue = 16 + 3 + 2; // key, length, tag and length
  set[kVersionValue] = 9;
  EXPECT_EQ(problem_in(read(*klv, {set})), TrackProblemKind::other_version);
  set[kVersionValue] = 1;
  set[kVersionValue + 3] = 9;
  EXPECT_EQ(problem_in(read(*klv, {set})), TrackProblemKind::other_kind);
}

} // namespace track_form_test
