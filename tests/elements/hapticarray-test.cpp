// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticarray makes channels of vibration from motion samples and fields.
#include "glue/gst-raii.hpp"
#include "samples/force-defaults.hpp"
#include "samples/motion-field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

namespace hapticarray_test {

constexpr GstClockTime kFrame = GST_SECOND / 30;
constexpr GstClockTime kLong = 10 * GST_SECOND; // what takes so long never comes

haptic::MotionSample moving(float x, float y, float pointer_x = 0.5F, float pointer_y = 0.5F) {
  haptic::MotionSample sample;
  sample.velocity_x = x;
  sample.velocity_y = y;
  sample.pointer_x = pointer_x;
  sample.pointer_y = pointer_y;
  sample.confidence = 1;
  sample.interval = kFrame;
  sample.frame_width = 352;
  sample.frame_height = 288;
  return sample;
}

// The left half of the frame moves.
haptic::MotionField half() {
  haptic::MotionField field;
  field.interval = kFrame;
  field.frame_width = 352;
  field.frame_height = 288;
  field.columns = 32;
  field.rows = 24;
  for (int cell = 0; cell < 32 * 24; ++cell)
    field.cells.push_back({cell % 32 < 16 ? 100.F : 0, 0, 1});
  return field;
}

// What the hand of the paper would feel, as a share of its maximum.
double level_of(double speed) {
  return 2 / std::numbers::pi * std::atan(haptic::kDefaultAlpha * speed);
}

class HapticArray : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }
  void TearDown() override {
    if (pipeline)
      gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  }

  // `after`: what follows the element, before the sink.
  void build(const std::string &properties, const char *caps = HAPTIC_MOTION_CAPS,
             const std::string &after = "") {
    const std::string line = std::string("appsrc name=in format=time caps=\"") + caps +
                             "\" ! hapticarray name=array " + properties + " ! " + after +
                             "appsink name=out sync=false";
    pipeline.reset(
        gst_parse_launch_full(line.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, nullptr));
    ASSERT_TRUE(pipeline);
    in.reset(gst_bin_get_by_name(GST_BIN(pipeline.get()), "in"));
    out.reset(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
    array.reset(gst_bin_get_by_name(GST_BIN(pipeline.get()), "array"));
    bus.reset(gst_pipeline_get_bus(GST_PIPELINE(pipeline.get())));
    next = 0;
  }
  void make_seekable() {
    g_object_set(in.get(), "stream-type", 1, nullptr);
    g_signal_connect(in.get(), "seek-data", G_CALLBACK(+[]() -> gboolean { return TRUE; }),
                     nullptr);
  }
  // While the pipeline plays. The next motion is at `time`.
  void seek(GstClockTime time) {
    ASSERT_TRUE(gst_element_seek_simple(pipeline.get(), GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH,
                                        static_cast<gint64>(time)));
    next = time;
  }
  // Running and stream time of the newest buffer.
  GstClockTime running() const {
    return gst_segment_to_running_time(&segment, GST_FORMAT_TIME, began);
  }
  GstClockTime stream() const {
    return gst_segment_to_stream_time(&segment, GST_FORMAT_TIME, began);
  }
  void play() { gst_element_set_state(pipeline.get(), GST_STATE_PLAYING); }

  template <typename Bytes>
  void push_bytes(const Bytes &bytes, GstClockTime duration = kFrame,
                  GstBufferFlags flags = GstBufferFlags{}) {
    GstBuffer *buffer = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
    gst_buffer_fill(buffer, 0, bytes.data(), bytes.size());
    GST_BUFFER_PTS(buffer) = next;
    GST_BUFFER_DURATION(buffer) = duration;
    GST_BUFFER_FLAG_SET(buffer, flags);
    next += kFrame;
    gst_app_src_push_buffer(GST_APP_SRC(in.get()), buffer);
  }
  void push(const haptic::MotionSample &sample, int frames) {
    for (int i = 0; i < frames; ++i)
      push_bytes(haptic::pack_motion_sample(sample));
  }
  void push(const haptic::MotionField &field, int frames) {
    std::vector<std::uint8_t> bytes(haptic::packed_size(field));
    haptic::pack_motion_field(field, bytes);
    for (int i = 0; i < frames; ++i)
      push_bytes(bytes);
  }

  // Takes one buffer of sound. Returns whether there was one.
  bool pull_sound() {
    const haptic::SamplePtr sample(gst_app_sink_try_pull_sample(GST_APP_SINK(out.get()), kLong));
    if (!sample)
      return false;
    GstBuffer *buffer = gst_sample_get_buffer(sample.get());
    const GstStructure *caps = gst_caps_get_structure(gst_sample_get_caps(sample.get()), 0);
    EXPECT_TRUE(gst_structure_get_int(caps, "channels", &channels));
    EXPECT_TRUE(gst_structure_get_int(caps, "rate", &rate));
    segment = *gst_sample_get_segment(sample.get());
    GstMapInfo map;
    EXPECT_TRUE(gst_buffer_map(buffer, &map, GST_MAP_READ));
    const auto *samples = reinterpret_cast<const float *>(map.data);
    sound.insert(sound.end(), samples, samples + map.size / sizeof(float));
    gst_buffer_unmap(buffer, &map);
    began = GST_BUFFER_PTS(buffer);
    expected = began + GST_BUFFER_DURATION(buffer);
    gaps += GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP) ? 1 : 0;
    ++buffers;
    return true;
  }
  bool pull() {
    const GstClockTime end = expected;
    if (!pull_sound())
      return false;
    EXPECT_EQ(began, end) << "the sound has a gap";
    return true;
  }
  // Whether there was a message of this type until now.
  bool was_said(GstMessageType type) const {
    return haptic::MessagePtr(gst_bus_pop_filtered(bus.get(), type)) != nullptr;
  }
  void pull_all() {
    gst_app_src_end_of_stream(GST_APP_SRC(in.get()));
    while (pull()) {
    }
    EXPECT_TRUE(gst_app_sink_is_eos(GST_APP_SINK(out.get())));
  }

  // Amplitude of the carrier on a channel between two times, s.
  double amplitude(int channel, double from, double to) const {
    double squares = 0;
    int count = 0;
    for (auto frame = static_cast<std::size_t>(from * rate);
         frame < static_cast<std::size_t>(to * rate); ++frame, ++count)
      squares += std::pow(
          sound.at(frame * static_cast<std::size_t>(channels) + static_cast<std::size_t>(channel)),
          2);
    return std::sqrt(2 * squares / count);
  }
  double energy(double from, double to) const {
    double energy = 0;
    for (int channel = 0; channel < channels; ++channel)
      energy += std::pow(amplitude(channel, from, to), 2);
    return energy;
  }

  // Motion, 10 frames of `gap`, and motion again.
  template <typename Gap>
  void expect_silence_in(const Gap &gap) {
    build("");
    play();
    push(moving(200, 0), 10);
    gap();
    push(moving(200, 0), 10);
    pull_all();
    EXPECT_GT(energy(0.2, 0.3), 0.1);
    EXPECT_EQ(energy(0.4, 0.6), 0);
    EXPECT_GT(energy(0.8, 0.9), 0.1);
    EXPECT_FALSE(was_said(GST_MESSAGE_WARNING));
  }

  // The text of the first message of this type.
  std::string message(GstMessageType type) {
    const haptic::MessagePtr found(gst_bus_timed_pop_filtered(bus.get(), kLong, type));
    if (!found)
      return "";
    GError *error = nullptr;
    if (type == GST_MESSAGE_ERROR)
      gst_message_parse_error(found.get(), &error, nullptr);
    else
      gst_message_parse_warning(found.get(), &error, nullptr);
    return haptic::ErrorPtr(error)->message;
  }

  haptic::ElementPtr pipeline;
  haptic::ElementPtr in;
  haptic::ElementPtr out;
  haptic::ElementPtr array;
  haptic::BusPtr bus;
  GstClockTime next = 0;
  std::vector<float> sound; // interleaved
  GstSegment segment = {};
  int channels = 0;
  int rate = 0;
  int buffers = 0;
  int gaps = 0;
  GstClockTime began = 0;    // the newest buffer
  GstClockTime expected = 0; // the next one
};

TEST_F(HapticArray, APointIsFeltAtItsPlaceAsStrongAsTheForceWouldBe) {
  build("map=point");
  play();
  push(moving(100, 0, 0, 0), 15); // top left: the first actuator
  pull_all();
  EXPECT_EQ(channels, 12);
  EXPECT_EQ(rate, 48000);
  EXPECT_NEAR(amplitude(0, 0.1, 0.4), level_of(100), 0.01 * level_of(100));
  for (int channel = 1; channel < channels; ++channel)
    EXPECT_EQ(amplitude(channel, 0.1, 0.4), 0) << channel;
}

TEST_F(HapticArray, TheEnergyIsTheSameAllAlongAStraightPath) {
  build("map=point");
  play();
  constexpr int kSteps = 60;
  for (int i = 0; i <= kSteps; ++i) {
    const float share = static_cast<float>(i) / kSteps;
    push(moving(100, 0, 0.05F + 0.9F * share, 0.1F + 0.7F * share), 1);
  }
  pull_all();
  const double whole = std::pow(level_of(100), 2);
  for (double from = 0.1; from < 1.95; from += 0.025) // four periods
    EXPECT_NEAR(energy(from, from + 0.025), whole, 0.01 * whole) << from;
}

TEST_F(HapticArray, WhatAnActuatorMayDoInAMinuteIsKeptOverRestarts) {
  build("map=point layout=coils-2");
  double used = 0; // amplitude², s
  for (int round = 0; round < 10; ++round) {
    next = expected = 0;
    sound.clear();
    play();
    push(moving(1e5, 0), 180);
    pull_all();
    used += 6 * std::pow(amplitude(0, 0, 5.9), 2);
    gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  }
  EXPECT_GT(used, 10);
  EXPECT_LT(used, 60 * std::pow(0.5, 2) * 1.02);
}

TEST_F(HapticArray, DamagedSamplesAreWarnedOfOnce) {
  build("");
  play();
  for (int i = 0; i < 5; ++i)
    push_bytes(std::array<std::uint8_t, 7>{});
  pull_all();
  EXPECT_TRUE(was_said(GST_MESSAGE_WARNING));
  EXPECT_FALSE(was_said(GST_MESSAGE_WARNING));
}

// With the latency that it reports: what is added between frame and sound.
TEST_F(HapticArray, AMotionIsHeardWithinABufferOfItsFrame) {
  build("map=point layout=coils-2");
  play();
  push(moving(0, 0), 10);
  push(moving(200, 0), 10);
  pull_all();
  const auto first = std::ranges::find_if(sound, [](float sample) { return sample != 0; });
  const auto frame = static_cast<int>((first - sound.begin()) / channels);
  EXPECT_GE(frame, 16000); // 10 frames of 30 a second
  EXPECT_LE(frame, 16000 + 128 + 1);
}

TEST_F(HapticArray, AStrokeRunsInTheDirectionOfTheMotionWithConstantEnergy) {
  build("map=stroke layout=ring-8");
  play();
  push(moving(300, 0), 90);
  pull_all();
  const double whole = std::pow(level_of(300), 2);
  for (double from = 0.2; from < 2.9; from += 0.05)
    EXPECT_NEAR(energy(from, from + 0.05), whole, 0.05 * whole) << from;
  // Seen from above, the second actuator stands an eighth of a turn to the right of the first. A
  // stroke runs to the right, and begins again on the left.
  int forward = 0;
  int back = 0;
  double before = 0;
  for (double from = 0.2; from < 2.9; from += 0.02) {
    double x = 0;
    for (int channel = 0; channel < channels; ++channel)
      x += std::pow(amplitude(channel, from, from + 0.02), 2) *
           std::sin(channel * std::numbers::pi / 4);
    forward += x > before;
    back += x < before;
    before = x;
  }
  EXPECT_GE(back, 1);
  EXPECT_GT(forward, 2 * back);
}

TEST_F(HapticArray, AFieldIsFeltWhereItMoves) {
  build("map=field layout=shakers-2", HAPTIC_FIELD_CAPS);
  play();
  push(half(), 15);
  pull_all();
  EXPECT_NEAR(amplitude(0, 0.1, 0.4), level_of(100), 0.01 * level_of(100));
  EXPECT_EQ(amplitude(1, 0.1, 0.4), 0);
}

TEST_F(HapticArray, ThePointerPointsIntoAField) {
  build("map=point pointer-x=0.9 layout=coils-2", HAPTIC_FIELD_CAPS);
  play();
  push(half(), 15);
  pull_all();
  EXPECT_EQ(energy(0, 0.5), 0);
}

TEST_F(HapticArray, StillnessIsDigitalZeroAndAGap) {
  build("");
  play();
  push(moving(0, 0), 15);
  pull_all();
  EXPECT_TRUE(std::ranges::all_of(sound, [](float sample) { return sample == 0; }));
  EXPECT_EQ(gaps, buffers);
}

TEST_F(HapticArray, TheSoundIsAsLongAsTheMotionAndEndsInSilence) {
  build("");
  play();
  push(moving(200, 0), 30);
  pull_all();
  const double seconds = static_cast<double>(sound.size()) / channels / rate;
  EXPECT_GE(seconds, 1);
  EXPECT_LE(seconds, 1.05);
  for (std::size_t i = sound.size() - static_cast<std::size_t>(channels); i < sound.size(); ++i)
    EXPECT_NEAR(sound[i], 0, 1e-3);
}

TEST_F(HapticArray, TheLastMotionLastsNoLongerThanAnyOther) {
  build("");
  play();
  push(moving(200, 0), 10);
  push_bytes(haptic::pack_motion_sample(moving(200, 0)), 1000 * GST_SECOND);
  gst_app_src_end_of_stream(GST_APP_SRC(in.get()));
  while (sound.size() < 12UL * 48000 * 5 && pull()) {
  }
  EXPECT_TRUE(gst_app_sink_is_eos(GST_APP_SINK(out.get())));
}

TEST_F(HapticArray, WithoutNewMotionItFallsSilent) {
  build("");
  play();
  push(moving(200, 0), 10);
  next += GST_SECOND; // lost
  push(moving(200, 0), 10);
  pull_all();
  EXPECT_GT(energy(0.2, 0.3), 0.1);
  EXPECT_EQ(energy(0.6, 1.3), 0);
  EXPECT_GT(energy(1.5, 1.6), 0.1);
}

TEST_F(HapticArray, AGapIsSilentAndNoDamage) {
  expect_silence_in([&] {
    gst_element_send_event(in.get(), gst_event_new_gap(next, 10 * kFrame));
    next += 10 * kFrame;
  });
}

TEST_F(HapticArray, ABufferOfAGapIsSilentWhateverItsBytesSay) {
  expect_silence_in([&] {
    for (int i = 0; i < 9; ++i)
      push_bytes(haptic::pack_motion_sample(moving(200, 0)), kFrame, GST_BUFFER_FLAG_GAP);
    push_bytes(std::string("no sample"), kFrame, GST_BUFFER_FLAG_GAP);
  });
}

TEST_F(HapticArray, TheRateIsThatOfTheOutput) {
  build("", HAPTIC_MOTION_CAPS, "audio/x-raw,rate=44100 ! ");
  play();
  push(moving(200, 0), 30);
  pull_all();
  EXPECT_EQ(rate, 44100);
  EXPECT_NEAR(static_cast<double>(sound.size()) / channels / rate, 1, 0.05);
}

TEST_F(HapticArray, AnotherRateGoesOnWhereTheSoundIs) {
  build("map=point", HAPTIC_MOTION_CAPS, "capsfilter name=rate caps=audio/x-raw,rate=48000 ! ");
  g_object_set(out.get(), "max-buffers", 1, nullptr);
  play();
  push(moving(200, 0, 0, 0), 60);
  while (expected < GST_SECOND)
    ASSERT_TRUE(pull());
  const haptic::ElementPtr filter(gst_bin_get_by_name(GST_BIN(pipeline.get()), "rate"));
  const haptic::CapsPtr caps(gst_caps_from_string("audio/x-raw,rate=16000"));
  g_object_set(filter.get(), "caps", caps.get(), nullptr);
  gst_app_src_end_of_stream(GST_APP_SRC(in.get()));
  GstClockTime last = expected;
  while (pull_sound()) {
    EXPECT_NEAR(static_cast<double>(began), static_cast<double>(last), GST_SECOND / 16000.0);
    last = expected;
  }
  EXPECT_EQ(rate, 16000);
  EXPECT_NEAR(static_cast<double>(last), 2e9, 0.05e9);
}

TEST_F(HapticArray, TheSoundBeginsWithTheMotionOnRequest) {
  build("start-time-selection=first");
  play();
  next = expected = GST_SECOND;
  push(moving(200, 0), 15);
  pull_all();
  EXPECT_GT(energy(0.1, 0.4), 0.1);
}

TEST_F(HapticArray, ASeeksRateIsThatOfTheMotion) {
  for (const double speed : {2.0, -2.0}) {
    build("map=point");
    make_seekable();
    play();
    push(moving(200, 0), 10);
    expected = 0;
    ASSERT_TRUE(pull());
    ASSERT_TRUE(gst_element_seek(pipeline.get(), speed, GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH,
                                 GST_SEEK_TYPE_SET, 0, GST_SEEK_TYPE_SET, GST_SECOND));
    sound.clear();
    for (int i = 0; i < 30; ++i) {
      next = (speed > 0 ? i : 29 - i) * kFrame;
      push(moving(200, 0), 1);
    }
    expected = 0;
    ASSERT_TRUE(pull());
    EXPECT_EQ(segment.rate, 1);
    EXPECT_EQ(segment.applied_rate, speed);
    EXPECT_EQ(gst_segment_to_stream_time(&segment, GST_FORMAT_TIME, 0), speed > 0 ? 0 : GST_SECOND);
    pull_all();
    EXPECT_NEAR(static_cast<double>(sound.size()) / channels / rate, 0.5, 0.05);
    EXPECT_GT(energy(0.3, 0.4), 0.1);
    if (speed < 0) { // sinks cut off what is behind the segment
      const auto last = gst_util_uint64_scale(segment.stop, static_cast<guint64>(rate), GST_SECOND);
      for (std::size_t i = last * static_cast<std::size_t>(channels); i < sound.size(); ++i)
        ASSERT_EQ(sound[i], 0);
    }
    TearDown();
  }
}

// A sink tells its position from the segment of the sound.
TEST_F(HapticArray, APositionAtHalfSpeedBackwardsIsThatOfTheMotion) {
  build("map=point");
  make_seekable();
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  push(moving(200, 0), 3);
  const auto wait_for_preroll = [this] {
    gst_element_get_state(pipeline.get(), nullptr, nullptr, GST_CLOCK_TIME_NONE);
  };
  wait_for_preroll();
  g_object_set(out.get(), "sync", TRUE, nullptr);
  ASSERT_TRUE(gst_element_seek(pipeline.get(), -0.5, GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH,
                               GST_SEEK_TYPE_SET, 0, GST_SEEK_TYPE_SET, 4 * GST_SECOND));
  for (int i = 0; i < 30; ++i) {
    next = 4 * GST_SECOND - static_cast<GstClockTime>(i + 1) * kFrame;
    push(moving(200, 0), 1);
  }
  wait_for_preroll();
  gint64 position = 0;
  ASSERT_TRUE(gst_element_query_position(out.get(), GST_FORMAT_TIME, &position));
  EXPECT_NEAR(static_cast<double>(position) / GST_SECOND, 4, 0.06);
  g_object_set(out.get(), "sync", FALSE, nullptr);
  play();
  expected = 0;
  for (int i = 0; i < 100; ++i) { // a second
    ASSERT_TRUE(pull());
    ASSERT_NEAR(static_cast<double>(stream()) / GST_SECOND,
                4 - static_cast<double>(running()) / GST_SECOND / 2, 0.001);
  }
}

TEST_F(HapticArray, MotionInASegmentThatDoesNotCountInTimeIsFeltAtOnce) {
  build("map=point");
  g_object_set(in.get(), "format", GST_FORMAT_BYTES, nullptr);
  play();
  push(moving(200, 0), 15);
  pull_all();
  EXPECT_GT(energy(0.02, 0.03), 0.01);
}

TEST_F(HapticArray, ASeekWhileItPlaysLeavesNoVibration) {
  build("map=point");
  make_seekable();
  play();
  push(moving(200, 0), 30);
  while (sound.size() < 12UL * 24000)
    ASSERT_TRUE(pull());
  EXPECT_GT(energy(0.3, 0.4), 0.1);
  const haptic::QueryPtr query(gst_query_new_seeking(GST_FORMAT_TIME));
  gboolean seekable = FALSE;
  ASSERT_TRUE(gst_element_query(out.get(), query.get()));
  gst_query_parse_seeking(query.get(), nullptr, &seekable, nullptr, nullptr);
  EXPECT_TRUE(seekable);
  seek(10 * GST_SECOND);
  sound.clear();
  expected = 0;
  push(moving(0, 0), 10);
  push(moving(200, 0), 10);
  ASSERT_TRUE(pull());
  EXPECT_EQ(running(), 0);
  EXPECT_EQ(stream(), 10 * GST_SECOND);
  pull_all();
  EXPECT_EQ(energy(0, 0.33), 0);
  EXPECT_GT(energy(0.4, 0.6), 0.1);
}

// A demuxer answers such a seek with a segment whose base is the running time so far. It comes
// later than what is queued, so that the sound before keeps its times.
TEST_F(HapticArray, ASeekThatDoesNotFlushGoesOnWithoutAGap) {
  constexpr GstClockTime kSought = 15 * kFrame; // running time
  build("map=point");
  g_object_set(in.get(), "handle-segment-change", TRUE, nullptr);
  const haptic::PadPtr source(gst_element_get_static_pad(in.get(), "src"));
  gst_pad_add_probe(
      source.get(), GST_PAD_PROBE_TYPE_EVENT_UPSTREAM,
      [](GstPad *, GstPadProbeInfo *info, gpointer) {
        const bool seeks = GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_SEEK;
        return seeks ? GST_PAD_PROBE_DROP : GST_PAD_PROBE_OK;
      },
      nullptr, nullptr);
  play();
  push(moving(200, 0), 15);
  while (expected < GST_SECOND / 4)
    ASSERT_TRUE(pull());
  gst_element_seek_simple(out.get(), GST_FORMAT_TIME, GST_SEEK_FLAG_NONE, 10 * GST_SECOND);
  GstSegment after;
  gst_segment_init(&after, GST_FORMAT_TIME);
  after.base = kSought;
  after.start = after.time = after.position = next = 10 * GST_SECOND;
  const haptic::CapsPtr caps(gst_caps_from_string(HAPTIC_MOTION_CAPS));
  const haptic::SamplePtr marker(gst_sample_new(nullptr, caps.get(), &after, nullptr));
  gst_app_src_push_sample(GST_APP_SRC(in.get()), marker.get());
  push(moving(0, 0), 15);
  gst_app_src_end_of_stream(GST_APP_SRC(in.get()));
  while (pull()) { // the time stamps go on: it checks that
    EXPECT_EQ(running(), began);
    if (segment.base > 0) {
      EXPECT_NEAR(static_cast<double>(segment.base), kSought, 128e9 / 48000);
      EXPECT_EQ(stream(), 10 * GST_SECOND + running() - kSought);
    } else {
      EXPECT_EQ(stream(), running());
    }
  }
  EXPECT_GT(segment.base, 0);
  EXPECT_GT(energy(0.1, 0.5), 0.1);
  EXPECT_EQ(energy(0.6, 0.9), 0);
}

TEST_F(HapticArray, AFlushBeginsAnewFromSilence) {
  build("map=point");
  play();
  push(moving(200, 0), 30);
  while (sound.size() < 12UL * 24000)
    ASSERT_TRUE(pull());
  gst_element_send_event(in.get(), gst_event_new_flush_start());
  gst_element_send_event(in.get(), gst_event_new_flush_stop(TRUE));
  sound.clear();
  next = 0;
  expected = 0;
  push(moving(0, 0), 15);
  pull_all();
  EXPECT_EQ(energy(0, 0.4), 0);
}

TEST_F(HapticArray, LiveItReportsItsLatencyAndGoesOnWithoutMotion) {
  build("layout=coils-2");
  g_object_set(in.get(), "is-live", TRUE, "min-latency", static_cast<gint64>(kFrame), nullptr);
  play();
  push(moving(200, 0), 1);
  for (int i = 0; i < 200; ++i) // more than half a second of sound from one sample
    ASSERT_TRUE(pull());
  const haptic::QueryPtr query(gst_query_new_latency());
  const haptic::PadPtr pad(gst_element_get_static_pad(array.get(), "src"));
  ASSERT_TRUE(gst_pad_query(pad.get(), query.get()));
  gboolean live = FALSE;
  GstClockTime least = 0;
  gst_query_parse_latency(query.get(), &live, &least, nullptr);
  EXPECT_TRUE(live);
  EXPECT_EQ(least - kFrame, gst_util_uint64_scale(128, GST_SECOND, 48000));
  EXPECT_EQ(energy(0.4, 0.5), 0); // the sample is old
}

TEST_F(HapticArray, WhatCannotBeIsSaidWithItsCure) {
  build("layout=jacket");
  play();
  EXPECT_NE(message(GST_MESSAGE_ERROR).find("no layout \"jacket\""), std::string::npos);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  build("", HAPTIC_MOTION_CAPS, "audio/x-raw,channels=2 ! ");
  play();
  push(moving(0, 0), 2);
  EXPECT_NE(message(GST_MESSAGE_ERROR).find("12 channels"), std::string::npos);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  build("", HAPTIC_MOTION_CAPS,
        "audioconvert ! audio/x-raw,channels=2 ! "); // it mixes no actuators
  play();
  push(moving(0, 0), 2);
  EXPECT_NE(message(GST_MESSAGE_ERROR).find("12 channels"), std::string::npos);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  build("map=field");
  play();
  push(moving(0, 0), 2);
  EXPECT_NE(message(GST_MESSAGE_WARNING).find("needs a motion field"), std::string::npos);
  push_bytes(std::string("not a sample"));
  EXPECT_NE(message(GST_MESSAGE_WARNING).find("damaged"), std::string::npos);
}

// The device's sink says what happened; what comes after finds silence.
TEST_F(HapticArray, AnOutputThatVanishesEndsTheStreamAndBeginsAgainFromSilence) {
  build("map=point", HAPTIC_MOTION_CAPS, "identity name=device error-after=100 ! ");
  play();
  push(moving(200, 0, 0, 0), 30);
  while (pull()) {
  }
  const haptic::MessagePtr error(gst_bus_timed_pop_filtered(bus.get(), kLong, GST_MESSAGE_ERROR));
  ASSERT_TRUE(error);
  EXPECT_STREQ(GST_MESSAGE_SRC_NAME(error.get()), "device");
  EXPECT_EQ(buffers, 99);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  const haptic::ElementPtr device(gst_bin_get_by_name(GST_BIN(pipeline.get()), "device"));
  g_object_set(device.get(), "error-after", -1, nullptr); // it is back
  play();
  sound.clear();
  next = expected = 0;
  push(moving(0, 0), 15);
  pull_all();
  EXPECT_EQ(energy(0, 0.4), 0);
}

} // namespace hapticarray_test
