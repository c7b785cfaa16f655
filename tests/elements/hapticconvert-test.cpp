// SPDX-License-Identifier: LGPL-2.1-or-later
// Haptic tracks in files and packets: what goes in comes out.
#include "forms/klv.hpp"
#include "mpeg-haptics/force-curve.hpp"
#include "mpeg-haptics/hmpg-track.hpp"
#include "track-pipeline.hpp"
#include "track-samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <gst/base/gstbasetransform.h>
#include <gst/base/gsttypefindhelper.h>
#include <gst/check/gstharness.h>
#include <memory>

namespace hapticconvert_test {

using haptic::MotionSample;
using test::Bytes;
using test::Packet;
using test::run;
using test::sample_of;

constexpr GstClockTime kFrame = 33'333'333;
constexpr int kCount = 90;
const std::string kIn =
    "appsrc name=in format=time caps=haptics/x-raw,modality=velocity,layout=point";
const std::string kKlvIn = "appsrc name=in format=time caps=meta/x-klv,parsed=true";
const std::string kOut =
    " ! hapticconvert name=convert ! haptics/x-raw ! appsink name=out sync=false";

class HapticConvert : public testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  HapticConvert() {
    test::TrackSamples samples(1);
    for (int i = 0; i < kCount; ++i) {
      MotionSample sample = samples.next().motion;
      if (i % 10 == 9)
        sample.confidence = 0;
      track.push_back(test::packet_of(sample, i * kFrame, kFrame));
    }
  }

  void expect_exact(const std::vector<Packet> &got) const {
    ASSERT_EQ(got.size(), track.size());
    for (std::size_t i = 0; i < got.size(); ++i) {
      EXPECT_EQ(got[i].bytes, track[i].bytes) << i;
      EXPECT_EQ(got[i].duration, kFrame) << i;
      EXPECT_EQ(got[i].flags & GST_BUFFER_FLAG_GAP, track[i].flags & GST_BUFFER_FLAG_GAP) << i;
    }
  }

  // The largest difference between the time stamps, ms; a constant does not count.
  double time_error(const std::vector<Packet> &got) const {
    double largest = 0;
    for (std::size_t i = 0; i < got.size(); ++i)
      largest = std::max(largest, std::abs(static_cast<double>(static_cast<gint64>(
                                      (got[i].pts - got[0].pts) - (track[i].pts - track[0].pts)))));
    return largest / 1e6;
  }

  std::string file(const char *name) const { return folder.file(name); }

  // The track beside a video, which makes the file a usual one.
  void record_ts(const std::string &path) {
    if (!test::has_elements({"mpegtsmux", "x264enc", "h264parse", "tsdemux"}))
      GTEST_SKIP() << "gstreamer1.0-plugins-bad or -ugly is not installed";
    const auto outcome =
        run(kIn +
                " ! hapticconvert ! meta/x-klv ! queue ! mux. videotestsrc num-buffers=90 ! "
                "video/x-raw,width=64,height=48,framerate=30/1 ! x264enc tune=zerolatency ! "
                "h264parse ! queue ! mux. mpegtsmux name=mux ! hapticmark ! filesink location=" +
                path,
            track);
    ASSERT_EQ(outcome.error, "");
  }

  test::ScratchFolder folder;
  std::vector<Packet> track;
};

TEST_F(HapticConvert, ATransportStreamGivesBackEverySample) {
  record_ts(file("session.ts"));
  if (IsSkipped())
    return;
  const auto got = run("filesrc location=" + file("session.ts") + " ! tsdemux ! meta/x-klv" + kOut);
  EXPECT_EQ(got.error, "");
  expect_exact(got.packets);
  const double error = time_error(got.packets);
  RecordProperty("largest_time_error_ms", std::to_string(error));
  std::printf("MPEG-TS: largest error of a time stamp %.4f ms\n", error);
  EXPECT_LE(error, 0.02);
  const auto video = run("filesrc location=" + file("session.ts") +
                         " ! tsdemux ! video/x-h264 ! appsink name=out sync=false");
  ASSERT_FALSE(video.packets.empty());
  EXPECT_NEAR(static_cast<double>(video.packets[0].pts), static_cast<double>(got.packets[0].pts),
              0.02e6)
      << "the first frame and its sample stay together";
}

TEST_F(HapticConvert, MatroskaTextGivesBackEverySample) {
  const auto outcome =
      run(kIn + " ! hapticconvert ! text/x-raw ! matroskamux ! filesink location=" +
              file("session.mkv"),
          track);
  EXPECT_EQ(outcome.error, "");
  const auto got = run("filesrc location=" + file("session.mkv") + " ! matroskademux" + kOut);
  EXPECT_EQ(got.error, "");
  expect_exact(got.packets);
  std::printf("Matroska: largest error of a time stamp %.4f ms\n", time_error(got.packets));
  EXPECT_LE(time_error(got.packets), 1);
}

TEST_F(HapticConvert, AGapBehindASampleGoesToMuxersOnly) {
  const Bytes klv = haptic::write_klv(test::TrackSamples(1).next());
  const auto gaps_in = [&](const char *out) {
    const std::unique_ptr<GstHarness, decltype(&gst_harness_teardown)> harness(
        gst_harness_new("hapticconvert"), gst_harness_teardown);
    gst_harness_set_sink_caps_str(harness.get(), out);
    gst_harness_set_src_caps_str(harness.get(), "meta/x-klv,parsed=true");
    GstBuffer *buffer = gst_buffer_new_memdup(klv.data(), klv.size());
    GST_BUFFER_PTS(buffer) = 0;
    EXPECT_EQ(gst_harness_push(harness.get(), buffer), GST_FLOW_OK);
    gst_harness_push_event(harness.get(), gst_event_new_gap(2 * GST_SECOND, 0));
    int gaps = 0;
    while (const haptic::EventPtr event{gst_harness_try_pull_event(harness.get())})
      gaps += GST_EVENT_TYPE(event.get()) == GST_EVENT_GAP ? 1 : 0;
    return gaps;
  };
  EXPECT_EQ(gaps_in("text/x-raw,format=utf8"), 1);
  EXPECT_EQ(gaps_in(HAPTIC_MOTION_CAPS), 0) << "a resting field would become unmeasured";
}

// tests/pipelines/remux-test.sh has the other copies.
TEST_F(HapticConvert, ACopyByFfmpegKeepsEverySampleAndItsTime) {
  if (std::system("command -v ffmpeg >/dev/null") != 0)
    GTEST_SKIP() << "ffmpeg is not installed";
  record_ts(file("session.ts"));
  if (IsSkipped())
    return;
  const std::string command = "ffmpeg -nostdin -v error -y -i " + file("session.ts") +
                              " -map 0 -c copy -f mpegts " + file("remuxed.ts");
  ASSERT_EQ(std::system(command.c_str()), 0);
  const auto got = run("filesrc location=" + file("remuxed.ts") + " ! tsdemux ! meta/x-klv" + kOut);
  EXPECT_EQ(got.error, "");
  expect_exact(got.packets);
  EXPECT_LE(time_error(got.packets), 0.02);
  EXPECT_TRUE(got.warnings.empty()) << "no time stamp was lost";
}

TEST_F(HapticConvert, SamplesWithoutTimeStampsGetThoseInside) {
  auto klv =
      run(kIn + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false", track).packets;
  for (std::size_t i = 0; i < klv.size(); ++i)
    if (i != 0)
      klv[i].pts = GST_CLOCK_TIME_NONE;
  const auto got = run(kKlvIn + kOut, klv);
  expect_exact(got.packets);
  EXPECT_LE(time_error(got.packets), 1e-6);
  EXPECT_EQ(got.warnings.size(), 1U) << "once";
}

TEST_F(HapticConvert, ASenderThatIsStartedAnewGoesOnWhereTheOldOneEnded) {
  auto klv =
      run(kIn + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false", track).packets;
  auto both = klv;
  both.insert(both.end(), klv.begin(), klv.end());
  for (std::size_t i = 1; i < both.size(); ++i)
    both[i].pts = GST_CLOCK_TIME_NONE;
  const auto got = run(kKlvIn + kOut, both).packets;
  ASSERT_EQ(got.size(), both.size());
  for (const auto &packet : got)
    EXPECT_TRUE(GST_CLOCK_TIME_IS_VALID(packet.pts));
}

TEST_F(HapticConvert, ATrackThatLostAllTimeStampsIsNotFeltAndSaidSo) {
  auto klv =
      run(kIn + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false", track).packets;
  for (auto &packet : klv)
    packet.pts = GST_CLOCK_TIME_NONE;
  klv.resize(5);
  const auto lost = run(kKlvIn + kOut, klv);
  EXPECT_TRUE(lost.packets.empty());
  ASSERT_EQ(lost.warnings.size(), 1U);
  EXPECT_NE(lost.warnings[0].find("nothing ties it to the picture"), std::string::npos);
  const auto asked = run(
      kKlvIn + " ! hapticconvert start-untied=true ! haptics/x-raw ! appsink name=out sync=false",
      klv);
  EXPECT_EQ(asked.packets.size(), klv.size()) << "on request it begins with the stream";
}

TEST_F(HapticConvert, WhatComesBeforeTheFirstTimeStampIsLeftOutWithoutAWarning) {
  auto klv =
      run(kIn + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false", track).packets;
  for (std::size_t i = 0; i < 20; ++i)
    klv[i].pts = GST_CLOCK_TIME_NONE;
  const auto got = run(kKlvIn + kOut, klv);
  EXPECT_TRUE(got.warnings.empty()) << got.warnings[0];
  ASSERT_EQ(got.packets.size(), klv.size() - 20);
  EXPECT_EQ(got.packets[0].pts, klv[20].pts);
}

TEST_F(HapticConvert, AFileThatIsCutOffIsPlayedUpToThere) {
  record_ts(file("session.ts"));
  if (IsSkipped())
    return;
  const Bytes whole = test::read_file(file("session.ts"));
  for (std::size_t part = 0; part <= 20; ++part) {
    test::write_file(file("cut.ts"), std::span(whole).first(whole.size() * part / 20));
    const auto got =
        run("filesrc location=" + file("cut.ts") + " ! tsdemux ! meta/x-klv" + kOut).packets;
    ASSERT_LE(got.size(), track.size());
    for (std::size_t i = 0; i < got.size(); ++i)
      EXPECT_EQ(got[i].bytes, track[i].bytes);
  }
}

TEST_F(HapticConvert, EachTruncationOfAPacketIsLeftOut) {
  const auto klv =
      run(kIn + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false", track).packets;
  std::vector<Packet> input;
  for (std::size_t size = 1; size < klv[0].bytes.size(); ++size)
    input.push_back(
        {Bytes(klv[0].bytes.begin(), klv[0].bytes.begin() + static_cast<std::ptrdiff_t>(size)),
         size * kFrame, kFrame, 0});
  input.push_back(klv[0]);
  const auto got = run(kKlvIn + kOut, input);
  ASSERT_EQ(got.packets.size(), 1U);
  EXPECT_EQ(got.packets[0].bytes, track[0].bytes);
  ASSERT_EQ(got.warnings.size(), 1U);
  EXPECT_NE(got.warnings[0].find("damaged"), std::string::npos);
}

TEST_F(HapticConvert, KlvOfOtherOriginIsNotFeltAndSaidSo) {
  const Bytes foreign = {0x06, 0x0E, 0x2B, 0x34, 0x02, 0x0B, 0x01, 0x01, 0x0E, 0x01,
                         0x03, 0x01, 0x01, 0x00, 0x00, 0x00, 3,    2,    1,    7};
  const auto got = run(kKlvIn + kOut, {{foreign, 0, kFrame, 0}, {foreign, kFrame, kFrame, 0}});
  EXPECT_EQ(got.packets.size(), 0U);
  ASSERT_EQ(got.warnings.size(), 1U);
  EXPECT_NE(got.warnings[0].find("not a haptic track"), std::string::npos);
}

TEST_F(HapticConvert, MpegHapticsGivesBackTheForce) {
  std::vector<Packet> motion;
  for (int i = 0; i < kCount; ++i) {
    MotionSample sample;
    sample.velocity_x = static_cast<float>(200 * std::sin(i / 8.0));
    sample.velocity_y = static_cast<float>(90 * std::cos(i / 5.0));
    sample.confidence = 1;
    sample.frame_width = 704;
    sample.frame_height = 576;
    motion.push_back(test::packet_of(sample, i * kFrame, kFrame));
  }
  const auto made = run(
      kIn + " ! hapticconvert ! haptics/hmpg ! filesink location=" + file("track.hmpg"), motion);
  EXPECT_EQ(made.error, "");
  const auto got = run("filesrc location=" + file("track.hmpg") + " ! hmpgparse" + kOut);
  ASSERT_EQ(got.packets.size(), motion.size() + 1) << "and silence at the end";
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const auto a = haptic::force_of_motion(sample_of(motion[i]));
    const auto b = haptic::force_of_motion(sample_of(got.packets[i]));
    EXPECT_NEAR(a.x, b.x, 0.0079) << i;
    EXPECT_NEAR(a.y, b.y, 0.0079) << i;
    EXPECT_NEAR(static_cast<double>(got.packets[i].pts), static_cast<double>(motion[i].pts),
                0.13e6);
  }
  EXPECT_TRUE(got.packets.back().flags & GST_BUFFER_FLAG_GAP);
}

TEST_F(HapticConvert, TheStandardsFilesAreKnownByTheirContent) {
  const auto type_of = [&](const char *golden) {
    const Bytes bytes = test::read_file(std::string(SOURCE_ROOT "/tests/data/") + golden);
    haptic::CapsPtr caps(
        gst_type_find_helper_for_data(nullptr, bytes.data(), bytes.size(), nullptr));
    return caps ? std::string(gst_structure_get_name(gst_caps_get_structure(caps.get(), 0))) : "";
  };
  EXPECT_EQ(type_of("golden.hmpg"), "haptics/hmpg");
  EXPECT_EQ(type_of("golden.hjif"), "haptics/hjif");
}

// Each unit is found by its time, and has that time.
void expect_exact_seeks(GstElement *pipeline, GstAppSink *sink, const std::vector<Packet> &whole) {
  for (const auto flags : {GST_SEEK_FLAG_NONE, GST_SEEK_FLAG_ACCURATE, GST_SEEK_FLAG_KEY_UNIT})
    for (const std::size_t unit : {56, 15, 78, 0, 2}) {
      const GstClockTime time = whole[unit].pts;
      ASSERT_TRUE(gst_element_seek_simple(pipeline, GST_FORMAT_TIME,
                                          static_cast<GstSeekFlags>(GST_SEEK_FLAG_FLUSH | flags),
                                          static_cast<gint64>(time)));
      GstSample *sample = gst_app_sink_try_pull_preroll(sink, 10 * GST_SECOND);
      ASSERT_NE(sample, nullptr);
      const Packet first = test::packet_of_buffer(gst_sample_get_buffer(sample));
      gst_sample_unref(sample);
      EXPECT_LE(first.pts, time);
      EXPECT_TRUE(first.pts + first.duration > time || time == 0) << "it contains " << time;
      EXPECT_TRUE(std::ranges::any_of(whole, [&](const Packet &packet) {
        return packet.pts == first.pts && packet.bytes == first.bytes;
      })) << "its time is right";
    }
}

TEST_F(HapticConvert, AnHmpgFileHasADurationAndSeeksToTheUnitOfThatTime) {
  const auto made = run(kIn +
                            " ! hapticconvert unit-duration=33 ! haptics/hmpg ! "
                            "filesink location=" +
                            file("track.hmpg"),
                        track);
  ASSERT_EQ(made.error, "");
  for (const std::string source : {"", " ! queue"}) { // by pulling and by pushing
    const std::string line = "filesrc location=" + file("track.hmpg") + source +
                             " ! hmpgparse ! appsink name=out sync=false";
    const auto whole = run(line).packets;
    const test::Pipeline pipeline(line);
    const haptic::ElementPtr out(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
    auto *sink = GST_APP_SINK(out.get());
    if (!source.empty()) { // the places become known
      gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
      while (GstSample *sample = gst_app_sink_try_pull_sample(sink, 10 * GST_SECOND))
        gst_sample_unref(sample);
      ASSERT_TRUE(gst_app_sink_is_eos(sink));
    }
    gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
    ASSERT_EQ(gst_element_get_state(pipeline.get(), nullptr, nullptr, 10 * GST_SECOND),
              GST_STATE_CHANGE_SUCCESS);
    gint64 duration = 0;
    EXPECT_TRUE(gst_element_query_duration(pipeline.get(), GST_FORMAT_TIME, &duration));
    if (source.empty()) {
      EXPECT_EQ(static_cast<GstClockTime>(duration), whole.back().pts + whole.back().duration);
    }
    expect_exact_seeks(pipeline.get(), sink, whole);
  }
}

// The ids of the effects are used up after 32 768 units: other bands follow.
TEST_F(HapticConvert, ASeekOverAChangeOfBandsIsFelt) {
  constexpr std::uint64_t kUnit = GST_MSECOND;
  haptic::HmpgEncoder encoder(kUnit, "2026-01-01");
  MotionSample motion = sample_of(track[0]);
  motion.confidence = 1;
  Bytes bytes;
  const auto append = [&](const std::vector<haptic::CodedUnit> &units) {
    for (const auto &unit : units)
      bytes.insert(bytes.end(), unit.bytes.begin(), unit.bytes.end());
  };
  for (std::uint64_t i = 0; i < 34'000; ++i)
    append(encoder.push(motion, i * kUnit, kUnit));
  append(encoder.finish());
  test::write_file(file("long.hmpg"), bytes);
  const test::Pipeline pipeline("filesrc location=" + file("long.hmpg") + " ! hmpgparse" + kOut);
  const haptic::ElementPtr out(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  gst_element_get_state(pipeline.get(), nullptr, nullptr, 10 * GST_SECOND);
  for (const gint64 time : {33'500 * GST_MSECOND, 1'000 * GST_MSECOND, 33'000 * GST_MSECOND}) {
    ASSERT_TRUE(
        gst_element_seek_simple(pipeline.get(), GST_FORMAT_TIME, GST_SEEK_FLAG_FLUSH, time));
    GstSample *sample = gst_app_sink_try_pull_preroll(GST_APP_SINK(out.get()), 10 * GST_SECOND);
    ASSERT_NE(sample, nullptr);
    const Packet first = test::packet_of_buffer(gst_sample_get_buffer(sample));
    gst_sample_unref(sample);
    EXPECT_NEAR(static_cast<double>(first.pts), static_cast<double>(time), 2e6);
    EXPECT_GT(sample_of(first).confidence, 0) << time;
  }
}

TEST_F(HapticConvert, TheLatencyIsOneUnitAndWhatALiveReaderHoldsBack) {
  for (const bool live : {false, true}) {
    test::Pipeline pipeline(kIn + (live ? " is-live=true" : "") +
                            " ! hapticconvert unit-duration=40 ! haptics/hmpg" + kOut);
    EXPECT_EQ(pipeline.run(track).error, "");
    const haptic::ElementPtr convert(gst_bin_get_by_name(GST_BIN(pipeline.get()), "convert"));
    const haptic::PadPtr pad(gst_element_get_static_pad(convert.get(), "src"));
    const haptic::QueryPtr query(gst_query_new_latency());
    ASSERT_TRUE(gst_pad_query(pad.get(), query.get()));
    gboolean is_live = FALSE;
    GstClockTime least = 0;
    gst_query_parse_latency(query.get(), &is_live, &least, nullptr);
    EXPECT_EQ(is_live != FALSE, live);
    EXPECT_EQ(least, (live ? 290 : 40) * GST_MSECOND);
  }
}

TEST_F(HapticConvert, WhatOfMpegHapticsGivesNoForceIsSaidOnce) {
  haptic::HmpgExperience experience = haptic::track_experience("2026-01-01");
  experience.perceptions.push_back({1, 6, 0, "vibrotactile"});
  experience.channels.push_back({2, 1, 1, {}, "at the wrist"});
  const auto made = run(kIn + " ! hapticconvert ! haptics/hmpg ! appsink name=out", track).packets;
  std::vector<Packet> input = {made};
  input.insert(input.begin() + 1, Packet{haptic::write_initialization_unit(experience), 0, 0, 0});
  const auto got = run(
      "appsrc name=in format=time caps=haptics/hmpg,stream-format=mihs,alignment=unit,rate=8000" +
          kOut,
      input);
  EXPECT_EQ(got.error, "");
  EXPECT_GT(got.packets.size(), track.size() / 2) << "the rest is felt";
  ASSERT_EQ(got.warnings.size(), 1U);
  EXPECT_NE(got.warnings[0].find("parts that give no force here"), std::string::npos);
}

TEST_F(HapticConvert, ADamagedHmpgFileIsPlayedAroundTheDamage) {
  const auto made =
      run(kIn + " ! hapticconvert ! haptics/hmpg ! filesink location=" + file("track.hmpg"), track);
  const Bytes whole = test::read_file(file("track.hmpg"));
  const std::string line = "filesrc location=" + file("bad.hmpg") + " ! hmpgparse" + kOut;
  test::write_file(file("bad.hmpg"), whole);
  const std::size_t all = run(line).packets.size();
  Bytes bad = whole;
  for (std::size_t i = 0; i < 40; ++i)
    bad[whole.size() / 2 + i] = 0xFF;
  test::write_file(file("bad.hmpg"), bad);
  const auto got = run(line);
  EXPECT_EQ(got.error, "");
  EXPECT_LT(got.packets.size(), all);
  EXPECT_GT(got.packets.size(), all / 2);
  EXPECT_FALSE(got.warnings.empty());
  for (std::size_t size = 0; size < whole.size(); size += whole.size() / 37) {
    test::write_file(file("bad.hmpg"), std::span(whole).first(size));
    EXPECT_LE(run(line).packets.size(), all) << size;
  }
}

TEST_F(HapticConvert, RtpCarriesKlvToTheBit) {
  if (!test::has_elements({"rtpklvpay", "rtpklvdepay"}))
    GTEST_SKIP() << "gstreamer1.0-plugins-good is not installed";
  const auto got =
      run(kIn + " ! hapticconvert ! meta/x-klv ! rtpklvpay ! rtpklvdepay" + kOut, track);
  EXPECT_EQ(got.error, "");
  expect_exact(got.packets);
}

TEST_F(HapticConvert, RepeatedInitializationUnitsNameTheTimeOfWhatFollows) {
  const auto got = run(kIn + " ! hapticconvert unit-duration=33 ! rtphmpgpay ! rtphmpgdepay ! "
                             "appsink name=out sync=false",
                       track);
  EXPECT_EQ(got.error, "");
  haptic::HmpgDecoder decoder; // as of a file: without the time stamps
  int initializations = 0;
  GstClockTime end = 0;
  for (const auto &packet : got.packets) {
    const auto unit = haptic::read_unit(packet.bytes, nullptr);
    if (unit.experience) {
      ++initializations;
      EXPECT_EQ(haptic::ns_of(unit.experience->time, unit.experience->timescale), packet.pts);
    }
    for (const auto &sample : decoder.push(packet.bytes, haptic::kNoTime).samples) {
      EXPECT_GE(sample.time, end);
      end = sample.time;
    }
  }
  EXPECT_EQ(initializations, 3) << "one a second";
  EXPECT_GE(end + kFrame, kCount * kFrame - GST_MSECOND);
}

TEST_F(HapticConvert, RtpCarriesMpegHapticsInPiecesAndWithLoss) {
  const std::string line = kIn +
                           " ! hapticconvert unit-duration=33 ! rtphmpgpay mtu=60 name=pay ! "
                           "rtphmpgdepay" +
                           kOut;
  const auto whole = run(line, track).packets;
  EXPECT_GT(whole.size(), 50U);
  test::Pipeline pipeline(line);
  GstElement *pay = gst_bin_get_by_name(GST_BIN(pipeline.get()), "pay");
  GstPad *pad = gst_element_get_static_pad(pay, "src");
  gst_pad_add_probe(
      pad, GST_PAD_PROBE_TYPE_BUFFER_LIST,
      [](GstPad *, GstPadProbeInfo *info, gpointer) {
        static int count = 0;
        auto *list = gst_buffer_list_make_writable(GST_PAD_PROBE_INFO_BUFFER_LIST(info));
        for (guint i = 0; i < gst_buffer_list_length(list);)
          if (++count % 20 == 10)
            gst_buffer_list_remove(list, i, 1);
          else
            ++i;
        GST_PAD_PROBE_INFO_DATA(info) = list;
        return gst_buffer_list_length(list) == 0 ? GST_PAD_PROBE_DROP : GST_PAD_PROBE_OK;
      },
      nullptr, nullptr);
  gst_object_unref(pad);
  gst_object_unref(pay);
  const auto got = pipeline.run(track);
  EXPECT_EQ(got.error, "");
  EXPECT_LT(got.packets.size(), whole.size());
  EXPECT_GT(got.packets.size(), whole.size() / 2);
  std::size_t at = 0;
  for (const auto &packet : got.packets) {
    while (at < whole.size() && whole[at].pts != packet.pts)
      ++at;
    ASSERT_LT(at, whole.size());
    EXPECT_EQ(haptic::force_of_motion(sample_of(whole[at])).x,
              haptic::force_of_motion(sample_of(packet)).x);
  }
}

// Calls the functions of the class as they come at a restart while upstream pushes on: the pad
// takes caps and samples before start(), and samples after stop() meet the caps of before.
TEST_F(HapticConvert, ARestartMeetsAStreamThatHasBegun) {
  const std::unique_ptr<GstHarness, decltype(&gst_harness_teardown)> harness(
      gst_harness_new("hapticconvert"), gst_harness_teardown);
  gst_harness_set_src_caps_str(harness.get(), HAPTIC_MOTION_CAPS);
  gst_harness_set_sink_caps_str(harness.get(), "meta/x-klv");
  const auto push = [&](std::size_t i) {
    GstBuffer *buffer = gst_buffer_new_memdup(track[i].bytes.data(), track[i].bytes.size());
    GST_BUFFER_PTS(buffer) = track[i].pts;
    return gst_harness_push(harness.get(), buffer);
  };
  EXPECT_EQ(push(0), GST_FLOW_OK);
  auto *convert = GST_BASE_TRANSFORM(harness->element);
  GstBaseTransformClass *of_convert = GST_BASE_TRANSFORM_GET_CLASS(convert);
  of_convert->start(convert);
  EXPECT_EQ(push(1), GST_FLOW_OK);
  EXPECT_EQ(gst_harness_buffers_received(harness.get()), 2U);
  if (of_convert->stop)
    of_convert->stop(convert);
  EXPECT_EQ(push(2), GST_FLOW_NOT_NEGOTIATED);
}

TEST_F(HapticConvert, ASegmentNeedNotCountInTime) {
  const std::string bytes =
      "appsrc name=in format=bytes caps=haptics/x-raw,modality=velocity,layout=point";
  const auto outcome =
      run(bytes + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false", track);
  EXPECT_EQ(outcome.error, "");
  EXPECT_EQ(outcome.packets.size(), track.size());
}

TEST_F(HapticConvert, HapticmarkMarksTheHeaderInTheCaps) {
  test::Pipeline pipeline(kIn + " ! hapticconvert ! text/x-raw ! matroskamux streamable=true ! "
                                "hapticmark ! appsink name=out sync=false");
  ASSERT_EQ(pipeline.run(track).error, "");
  const haptic::ElementPtr out(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  const haptic::PadPtr pad(gst_element_get_static_pad(out.get(), "sink"));
  const haptic::CapsPtr caps(gst_pad_get_current_caps(pad.get()));
  ASSERT_NE(caps, nullptr);
  const GValue *headers =
      gst_structure_get_value(gst_caps_get_structure(caps.get(), 0), "streamheader");
  ASSERT_NE(headers, nullptr);
  const Bytes header =
      test::packet_of_buffer(gst_value_get_buffer(gst_value_array_get_value(headers, 0))).bytes;
  EXPECT_NE(std::string(header.begin(), header.end()).find(std::string("\x88\x81\0Sn", 5)),
            std::string::npos)
      << "the text track is not the default, and has a name";
}

TEST_F(HapticConvert, HapticmarkRefusesBytesWithoutCaps) {
  EXPECT_NE(run("appsrc name=in format=time ! hapticmark ! fakesink", track).error, "");
}

TEST_F(HapticConvert, NoTrackExceedsTheLocalMaxForce) {
  if (!test::has_elements({"hapticsink"}))
    GTEST_SKIP() << "hapticsink is not built";
  std::vector<Packet> wild;
  test::TrackSamples samples(3);
  for (int i = 0; i < 40; ++i) {
    haptic::TrackSample sample = samples.next();
    sample.motion.velocity_x = i % 2 ? 9e5F : -9e5F;
    sample.motion.velocity_y = 3e38F * static_cast<float>(i % 5 == 0);
    sample.motion.spin = 3e38F * static_cast<float>(i % 7 == 0);
    sample.motion.confidence = 1;
    sample.motion.interval = kFrame;
    wild.push_back({haptic::write_klv(sample), i * kFrame, kFrame, 0});
  }
  const auto outcome = run(kKlvIn +
                               " ! hapticconvert ! hapticsink device=sim max-force=0.3 "
                               "max-push=0.3 slew-rate=1000 log-location=" +
                               file("log.csv"),
                           wild);
  EXPECT_EQ(outcome.error, "");
  std::ifstream log(file("log.csv"));
  std::string row;
  std::getline(log, row);
  double strongest = 0;
  while (std::getline(log, row)) {
    double v[10] = {};
    ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &v[0], &v[1],
                          &v[2], &v[3], &v[4], &v[5], &v[6], &v[7], &v[8], &v[9]),
              10);
    strongest = std::max(strongest, std::hypot(v[7], v[8], v[9]));
  }
  EXPECT_LE(strongest, 0.3 * 1.000001);
  EXPECT_GT(strongest, 0.1) << "it was felt";
}

} // namespace hapticconvert_test
