// SPDX-License-Identifier: LGPL-2.1-or-later
#include "forms/text-line.hpp"
#include "track-samples.hpp"

#include <gtest/gtest.h>

namespace text_line_test {

using haptic::read_text_line;
using haptic::TrackSample;
using haptic::write_text_line;

TEST(TextLine, SamplesComeBackToTheBit) {
  test::TrackSamples samples(1);
  for (int i = 0; i < 1000; ++i) {
    const TrackSample sample = samples.next();
    const auto line = read_text_line(write_text_line(sample));
    ASSERT_TRUE(line.sample) << line.error;
    EXPECT_EQ(*line.sample, sample);
  }
}

TEST(TextLine, IsForPeopleToo) {
  TrackSample sample;
  sample.time = 1'033'333'333;
  sample.duration = 33'333'333;
  auto &s = sample.motion;
  s.interval = 33'333'333;
  s.velocity_x = 12.5F;
  s.velocity_y = -3;
  s.confidence = 1;
  s.frame_width = 352;
  s.frame_height = 288;
  s.points = 17;
  s.model = haptic::MotionModel::similarity;
  s.flags = haptic::kMotionDuplicate | haptic::kMotionAperture;
  EXPECT_EQ(write_text_line(sample),
            "hv1 point t=1.033333333 d=0.033333333 i=0.033333333 vx=12.5 vy=-3 spin=0 div=0 x=0.5 "
            "y=0.5 w=0 h=0 conf=1 pic=352x288 par=1:1 n=17 model=similarity "
            "flags=duplicate,aperture");
  s.held = {haptic::HoldState::about, 0.25F, 0.5F, 0.125F, 2'500'000'000};
  const std::string line = write_text_line(sample);
  const std::string held =
      " held=about hold-x=0.25 hold-y=0.5 hold-radius=0.125 hold-time=2.500000000";
  ASSERT_NE(line.find(held + ' '), std::string::npos) << line;
  EXPECT_EQ(read_text_line(line).sample, sample);
  s.held = {};
  EXPECT_EQ(read_text_line(std::string(line).erase(line.find(held), held.size())).sample, sample)
      << "a reader that skips these names reads the same motion";
}

TEST(TextLine, HoldsNothingThatMarkupEscapes) {
  test::TrackSamples samples(2);
  for (int i = 0; i < 1000; ++i)
    EXPECT_EQ(write_text_line(samples.next()).find_first_of("\"'&<>\n"), std::string::npos);
}

TEST(TextLine, WhatIsAroundItAndUnknownWordsAreIgnored) {
  const TrackSample sample = test::TrackSamples(3).next();
  const std::string line = write_text_line(sample);
  EXPECT_EQ(read_text_line("  " + line + " later=1 word \r\n" + std::string(1, '\0')).sample,
            sample);
}

TEST(TextLine, SaysWhatIsWrong) {
  const std::string line = write_text_line(test::TrackSamples(4).next());
  const auto error = [](std::string_view text) { return read_text_line(text).error; };
  EXPECT_EQ(error(""), "this is not a motion sample");
  EXPECT_EQ(error("Hello"), "this is not a motion sample");
  EXPECT_EQ(error("hv2 point"), "another version of the format");
  EXPECT_EQ(error("hv1 sound"), "another kind of sample");
  EXPECT_EQ(error("hv1 field t=1"), "the value b is missing");
  for (const char *b : {"b=", "b=AQI", "b=A===", "b=AQ=I", "b=A-_=", "b=AQID b=AQID"})
    EXPECT_EQ(error(std::string("hv1 field ") + b), "the value b cannot be read") << b;
  EXPECT_EQ(error("hv1 field t=x b=AQID"), "the value t cannot be read");
  EXPECT_EQ(error("hv1 field t=1 b=AQID t=500"), "the value t is there twice");
  EXPECT_EQ(error("hv1 field t=1 b=" + std::string(88'000, 'A')),
            "the value b is too long"); // KLV has no place
  EXPECT_EQ(error("hv1 field d=1 d=1 b=AQID"), "the value d is there twice");
  EXPECT_EQ(error("hv1 point"), "the value i is missing");
  EXPECT_EQ(error(line + " vx=1"), "the value vx is there twice");
  EXPECT_EQ(error("hv1 point vx=fast"), "the value vx cannot be read");
  EXPECT_EQ(error("hv1 point vx=1e999"), "the value vx cannot be read");
  EXPECT_EQ(error("hv1 point conf"), "the value conf cannot be read");
  const std::string_view point =
      "hv1 point i=0 vx=0 vy=0 spin=0 div=0 x=0 y=0 w=0 h=0 conf=1 pic=1x1 par=1:1 n=0 model=none ";
  const auto held = [&](std::string_view words) { return error(std::string(point).append(words)); };
  EXPECT_EQ(held("hold-x=7"), "") << "nothing is held";
  EXPECT_EQ(held("held=held hold-x=0 hold-y=0 hold-radius=0"), "the value hold-time is missing");
  EXPECT_EQ(held("held=gone"), "the value held cannot be read");
  EXPECT_EQ(held("held=lost hold-x=0 hold-y=2 hold-radius=0 hold-time=0"),
            "a value is out of its range");
  EXPECT_EQ(error("hv1 point i=0 vx=nan vy=0 spin=0 div=0 x=0 y=0 w=0 h=0 conf=1 pic=1x1 par=1:1 "
                  "n=0 model=none"),
            "a value is out of its range");
}

TEST(TextLine, NoTruncationIsTakenForWholeUnlessOnlyTheFlagsAreGone) {
  TrackSample sample = test::TrackSamples(5).next();
  sample.motion.flags = 0;
  sample.motion.model = haptic::MotionModel::translation;
  const std::string line = write_text_line(sample);
  for (std::size_t size = 0; size < line.size(); ++size)
    EXPECT_FALSE(read_text_line(line.substr(0, size)).sample) << size;
}

TEST(TextLine, AFieldComesBackWithoutCharactersThatMarkUpEscapes) {
  const haptic::CodedField field{{0, 1, 0xFB, 0xEF, 0xFF}, 1'033'333'333, 5};
  const std::string line = write_text_line(field);
  EXPECT_EQ(line, "hv1 field t=1.033333333 d=0.000000005 b=AAH77/8=");
  EXPECT_EQ(read_text_line(line + "\n").field, field);
  EXPECT_EQ(read_text_line("hv1 field b=AAH77/8= later=1").field,
            (haptic::CodedField{field.bytes}));
}

TEST(TextLine, ThingsOfAFieldAreAWordThatEarlierReadersSkip) {
  haptic::CodedField field{{0, 1}, 7};
  field.things = {1, 0, 0, 0, 7, 0, 1, 0, 0, 0x40, 0, 0x80, 0, 8, 0, 0};
  const std::string line = write_text_line(field);
  EXPECT_EQ(line, "hv1 field t=0.000000007 b=AAE= things=AQAAAAcAAQAAQACAAAgAAA==");
  EXPECT_EQ(read_text_line(line).field, field);
  EXPECT_FALSE(read_text_line("hv1 field b=AAE= things=AQAAAA==").field);
  EXPECT_TRUE(read_text_line("hv1 relief b=AAE= things=AQAAAA==").field);
}

} // namespace text_line_test
