// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/force-curve.hpp"
#include "mpeg-haptics/hjif.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace hjif_test {

using haptic::read_hjif;
using haptic::TrackSample;
using haptic::write_hjif;

constexpr std::uint64_t kFrame = 33'333'333;

std::vector<TrackSample> track(int count) {
  std::vector<TrackSample> samples;
  for (int i = 0; i < count; ++i) {
    TrackSample sample;
    sample.motion = haptic::motion_of_force({0.5 * std::sin(i / 9.0), 0.7 * std::cos(i / 5.0)});
    if (i / 30 % 4 == 3)
      sample.motion.confidence = 0;
    sample.time = static_cast<std::uint64_t>(i) * kFrame;
    sample.duration = kFrame;
    samples.push_back(sample);
  }
  return samples;
}

TEST(Hjif, TheForceComesBack) {
  const auto sent = track(900); // half a minute
  const auto got = read_hjif(write_hjif(sent, "2026-01-01"));
  ASSERT_EQ(got.error, "");
  auto at = got.samples.begin();
  for (const auto &sample : sent) {
    if (sample.motion.confidence == 0)
      continue;
    while (at != got.samples.end() && at->motion.confidence == 0)
      ++at;
    ASSERT_NE(at, got.samples.end());
    const auto a = haptic::force_of_motion(sample.motion);
    const auto b = haptic::force_of_motion(at->motion);
    EXPECT_NEAR(a.x, b.x, 1e-4);
    EXPECT_NEAR(a.y, b.y, 1e-4);
    EXPECT_NEAR(static_cast<double>(sample.time), static_cast<double>(at->time), 0.13e6);
    ++at;
  }
  EXPECT_EQ(got.samples.back().motion.confidence, 0) << "it ends in silence";
}

// Felt without a pause for longer than the force is summed at once.
TEST(Hjif, WhatIsWrittenOfAnHourCanBeRead) {
  std::vector<TrackSample> sent = track(30 * 3600);
  for (TrackSample &sample : sent)
    sample.motion.confidence = 1;
  const auto got = read_hjif(write_hjif(sent, "2026-01-01"));
  ASSERT_EQ(got.error, "");
  ASSERT_GE(got.samples.size(), sent.size());
  auto at = got.samples.begin();
  for (const TrackSample &sample : sent) {
    while (at != got.samples.end() && at->time + 200'000 < sample.time)
      ++at;
    ASSERT_NE(at, got.samples.end());
    ASSERT_NEAR(haptic::force_of_motion(sample.motion).y, haptic::force_of_motion(at->motion).y,
                1e-3)
        << sample.time;
  }
}

// Positions of the effects and of their last keyframes, in the order of the text.
TEST(Hjif, NoTickHasTwoEffects) {
  const auto sent = std::vector<TrackSample>(track(30));
  std::vector<TrackSample> longer; // than an effect may be
  for (int i = 0; i < 900; ++i) {
    longer.push_back(sent[static_cast<std::size_t>(i) % 30]);
    longer.back().time = static_cast<std::uint64_t>(i) * kFrame;
  }
  const std::string text = write_hjif(longer, "2026-01-01");
  const std::string effect = "\"position\":";
  const std::string keyframe = "\"relative_position\":";
  int effects = 0;
  long end = -1;
  for (auto at = text.find(effect); at != std::string::npos; ++effects) {
    const auto next = text.find(effect, at + 1);
    const long begin = std::stol(text.substr(at + effect.size()));
    if (begin > 0) { // in one channel
      EXPECT_GT(begin, end);
    }
    const auto last = text.rfind(keyframe, next);
    end = begin + std::stol(text.substr(last + keyframe.size()));
    at = next;
  }
  EXPECT_EQ(effects, 8);
}

TEST(Hjif, TheForceHoldsUntilTheLastSampleIsOver) {
  const auto got = read_hjif(write_hjif(track(10), "2026-01-01"));
  EXPECT_EQ(got.samples.back().motion.confidence, 0);
  EXPECT_NEAR(static_cast<double>(got.samples.back().time), 10.0 * kFrame, 0.13e6);
}

TEST(Hjif, NoTruncationIsTakenForWhole) {
  const std::string text = write_hjif(track(10), "2026-01-01");
  for (std::size_t size = 0; size + 1 < text.size(); ++size)
    EXPECT_NE(read_hjif(text.substr(0, size)).error, "") << size;
}

TEST(Hjif, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(read_hjif("[]").error, "an object is expected");
  EXPECT_EQ(read_hjif("{}").error, "there is no version: this is not MPEG haptics");
  EXPECT_EQ(read_hjif("{\"version\":\"2023\"}").error, "the timescale is missing or impossible");
  EXPECT_EQ(read_hjif("{\"version\":\"2023\",\"timescale\":1000}").error,
            "there is no perception of force");
  EXPECT_EQ(read_hjif("{\"version\":\"2023\",\"timescale\":1e9}").error,
            "the timescale is missing or impossible");
  const std::string deep = std::string(100, '[');
  EXPECT_EQ(read_hjif("{\"x\":" + deep).error, "nested too deeply");
  EXPECT_EQ(read_hjif("{\"version\":7}").offset, 11U);
}

// What the reference software rejects. `change` replaces the first text by the second.
TEST(Hjif, WhatIsMalformedIsRefused) {
  const std::string text =
      R"({"version":"2025","level":1,"timescale":1000,"perceptions":[{"perception_modality":"Force",)"
      R"("channels":[{"gain":1,"direction":{"X":0,"Y":127,"Z":0},"bands":[{"band_type":"Curve",)"
      R"("curve_type":"Linear","effects":[{"effect_type":"Reference","id":3,"position":5}]}]}],)"
      R"("effect_library":[{"id":3,"effect_type":"Basis","position":0,"keyframes":[)"
      R"({"relative_position":0,"amplitude_modulation":1}]}]}]})";
  const auto error_of = [&](const std::string &from, const std::string &to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    return read_hjif(changed).error;
  };
  EXPECT_EQ(read_hjif(text).error, "");
  EXPECT_EQ(error_of(R"("effect_type":"Reference",)", ""), "an effect of no known type");
  EXPECT_EQ(error_of(R"("Basis")", R"("Bass")"), "an effect of no known type");
  EXPECT_EQ(error_of(R"("band_type":"Curve",)", ""), "a band of no known type");
  EXPECT_EQ(error_of(R"("id":3)", R"("id":4)"), "a reference to no effect of the library");
  EXPECT_EQ(error_of(R"("Y":127)", R"("Y":100)"), "a direction whose length is not 127");
  EXPECT_EQ(error_of(R"("gain":1)", R"("gain":-1)"), "a negative gain");
  std::string bands;
  for (int i = 0; i < 7; ++i)
    bands += R"({"band_type":"Transient","effects":[]},)";
  const std::string start = R"("bands":[)";
  EXPECT_EQ(error_of(start, start + bands), "more channels, or bands of one, than level 1 has");
}

TEST(Hjif, OtherModalitiesAndBandsArePassedOver) {
  const std::string text =
      "{\"version\":\"2025\",\"timescale\":1000,\"perceptions\":["
      "{\"perception_modality\":\"Vibrotactile\",\"channels\":[{\"bands\":[{\"effects\":[]}]}]},"
      "{\"channels\":[{\"bands\":[{\"effects\":[{\"keyframes\":[{\"amplitude_modulation\":0.5,"
      "\"relative_position\":10},{\"amplitude_modulation\":1,\"relative_position\":20}],"
      "\"position\":5,\"effect_type\":\"Basis\"}],\"band_type\":\"Curve\"},"
      "{\"band_type\":\"Transient\",\"effects\":[{\"effect_type\":\"Basis\",\"keyframes\":["
      "{\"relative_position\":1,\"amplitude_modulation\":1,\"frequency_modulation\":70}]}]}],"
      "\"direction\":{\"X\":0,\"Y\":127,\"Z\":0},\"gain\":0.5}],"
      "\"perception_modality\":\"Force\",\"other\":[{\"a\":null,\"b\":true}]}]}";
  const auto got = read_hjif(text);
  ASSERT_EQ(got.error, "");
  ASSERT_EQ(got.samples.size(), 3U);
  EXPECT_EQ(got.samples[0].time, 15'000'000U);
  EXPECT_NEAR(haptic::force_of_motion(got.samples[0].motion).y, 0.25, 1e-5);
  EXPECT_NEAR(haptic::force_of_motion(got.samples[1].motion).y, 0.5, 1e-5);
}

} // namespace hjif_test
