// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion fields in files and packets: what goes in comes out, but for what cannot be felt.
#include "field-code/field-codec.hpp"
#include "leaf-fields.hpp"
#include "network/key-requests.hpp"
#include "track-pipeline.hpp"
#include "track-samples.hpp"

#include <cmath>
#include <cstdlib>

namespace hapticconvert_field_test {

using haptic::MotionField;
using test::Bytes;
using test::Packet;
using test::run;

constexpr GstClockTime kFrame = test::LeafFields::kInterval;
constexpr int kCount = 90;
const std::string kFieldIn =
    "appsrc name=in format=time caps=haptics/x-raw,modality=velocity,layout=field";
const std::string kPointIn =
    "appsrc name=in format=time caps=haptics/x-raw,modality=velocity,layout=point";
const std::string kKlvIn = "appsrc name=in format=time caps=meta/x-klv,parsed=true";
const std::string kOut =
    " ! hapticconvert name=convert ! haptics/x-raw ! appsink name=out sync=false";

Packet packet_of(const MotionField &field, GstClockTime pts) {
  Packet packet{Bytes(haptic::packed_size(field)), pts, kFrame, 0};
  haptic::pack_motion_field(field, packet.bytes);
  return packet;
}

MotionField field_of(const Packet &packet) {
  MotionField field;
  EXPECT_TRUE(haptic::unpack_motion_field(packet.bytes, field));
  return field;
}

MotionField resting() {
  MotionField field = test::LeafFields(1).next();
  field.interval = kFrame;
  field.flags = haptic::kMotionStill;
  for (auto &cell : field.cells)
    cell.confidence = 1;
  return field;
}

class HapticConvertField : public testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  HapticConvertField() {
    test::LeafFields leaves(1);
    for (int i = 0; i < kCount; ++i)
      track.push_back(packet_of(leaves.next(), i * kFrame));
  }

  void expect_felt_alike(const std::vector<Packet> &got, double time_error = 0) const {
    ASSERT_EQ(got.size(), track.size());
    for (std::size_t i = 0; i < got.size(); ++i) {
      const MotionField sent = field_of(track[i]);
      const MotionField back = field_of(got[i]);
      ASSERT_EQ(back.cells.size(), sent.cells.size());
      EXPECT_NEAR(static_cast<double>(got[i].pts - got[0].pts),
                  static_cast<double>(track[i].pts - track[0].pts), time_error);
      EXPECT_EQ((got[i].flags & GST_BUFFER_FLAG_GAP) != 0, i == 0) << i;
      for (std::size_t c = 0; c < sent.cells.size(); ++c)
        EXPECT_LE(std::hypot(back.cells[c].velocity_x - sent.cells[c].velocity_x,
                             back.cells[c].velocity_y - sent.cells[c].velocity_y) *
                      1e-9 * kFrame,
                  0.201)
            << i << " " << c;
    }
  }

  std::vector<Packet> coded(const char *caps) const {
    return run(kFieldIn + " ! hapticconvert ! " + caps + " ! appsink name=out sync=false", track)
        .packets;
  }

  std::string file(const char *name) const { return folder.file(name); }

  test::ScratchFolder folder;
  std::vector<Packet> track;
};

TEST_F(HapticConvertField, ATransportStreamGivesBackEveryField) {
  if (!test::has_elements({"mpegtsmux", "tsdemux"}))
    GTEST_SKIP() << "gstreamer1.0-plugins-bad is not installed";
  const auto made = run(
      kFieldIn + " ! hapticconvert ! meta/x-klv ! mpegtsmux ! filesink location=" + file("f.ts"),
      track);
  ASSERT_EQ(made.error, "");
  const auto got = run("filesrc location=" + file("f.ts") + " ! tsdemux ! meta/x-klv" + kOut);
  EXPECT_EQ(got.error, "");
  expect_felt_alike(got.packets, 0.02e6);
  std::printf("MPEG-TS: %.1f kbit/s in the file\n",
              8e-3 * static_cast<double>(test::read_file(file("f.ts")).size()) / (kCount / 30.0));
}

TEST_F(HapticConvertField, MatroskaTextGivesBackEveryField) {
  const auto made = run(
      kFieldIn + " ! hapticconvert ! text/x-raw ! matroskamux ! filesink location=" + file("f.mkv"),
      track);
  ASSERT_EQ(made.error, "");
  const auto got = run("filesrc location=" + file("f.mkv") + " ! matroskademux" + kOut);
  EXPECT_EQ(got.error, "");
  expect_felt_alike(got.packets, 1e6);
  std::printf("Matroska: %.1f kbit/s in the file\n",
              8e-3 * static_cast<double>(test::read_file(file("f.mkv")).size()) / (kCount / 30.0));
}

TEST_F(HapticConvertField, RtpCarriesIt) {
  if (!test::has_elements({"rtpklvpay", "rtpklvdepay"}))
    GTEST_SKIP() << "gstreamer1.0-plugins-good is not installed";
  const auto got =
      run(kFieldIn + " ! hapticconvert ! meta/x-klv ! rtpklvpay ! rtpklvdepay" + kOut, track);
  EXPECT_EQ(got.error, "");
  expect_felt_alike(got.packets, 0.02e6);
}

TEST_F(HapticConvertField, KlvBecomesTextAndBackToTheByte) {
  const auto klv = coded("meta/x-klv");
  const auto got = run(kKlvIn + " ! hapticconvert ! text/x-raw ! hapticconvert ! meta/x-klv ! "
                                "appsink name=out sync=false",
                       klv);
  ASSERT_EQ(got.packets.size(), klv.size());
  for (std::size_t i = 0; i < klv.size(); ++i)
    EXPECT_EQ(got.packets[i].bytes, klv[i].bytes);
}

TEST_F(HapticConvertField, KeySamplesCanBeSoughtTheOthersDepend) {
  for (const char *caps : {"meta/x-klv", "text/x-raw"}) {
    const auto got = coded(caps);
    ASSERT_EQ(got.size(), track.size());
    std::vector<GstClockTime> keys;
    for (const auto &packet : got)
      if (!(packet.flags & GST_BUFFER_FLAG_DELTA_UNIT))
        keys.push_back(packet.pts);
    EXPECT_EQ(keys, (std::vector<GstClockTime>{0, kFrame, 30 * kFrame, 31 * kFrame, 60 * kFrame,
                                               61 * kFrame}));
  }
}

TEST_F(HapticConvertField, ALostFieldHarmsNoOtherAndIsReported) {
  auto klv = coded("meta/x-klv");
  klv.erase(klv.begin() + 40);
  const auto got = run(kKlvIn + kOut, klv);
  track.erase(track.begin() + 40);
  expect_felt_alike(got.packets);
  ASSERT_EQ(got.warnings.size(), 1U);
  EXPECT_NE(got.warnings[0].find("lost"), std::string::npos);
}

TEST_F(HapticConvertField, WhoBeginsInTheMiddleFeelsFromTheNextKey) {
  auto klv = coded("meta/x-klv");
  klv.erase(klv.begin(), klv.begin() + 40);
  const auto got = run(kKlvIn + kOut, klv);
  ASSERT_EQ(got.packets.size(), 30U);
  EXPECT_EQ(got.packets[0].pts, 60 * kFrame);
  EXPECT_TRUE(got.warnings.empty());
}

TEST_F(HapticConvertField, FieldsThatRestAreLeftOutAndTheirEndComesBack) {
  std::vector<Packet> track_with_rest;
  for (int i = 0; i < 20; ++i)
    track_with_rest.push_back(packet_of(i < 19 ? resting() : field_of(track[20]), i * kFrame));
  const auto klv = run(kFieldIn + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false",
                       track_with_rest);
  ASSERT_EQ(klv.packets.size(), 2U) << "the first, and the one that moves";
  const auto got = run(kKlvIn + kOut, klv.packets);
  ASSERT_EQ(got.packets.size(), 3U);
  EXPECT_EQ(got.packets[1].pts, 19 * kFrame - 33'333'000) << "the interval, to the microsecond";
  for (const auto &cell : field_of(got.packets[1]).cells)
    EXPECT_EQ(cell.velocity_x, 0);
}

TEST_F(HapticConvertField, AMuxerNeverWaitsForOneThatRests) {
  if (!test::has_elements({"mpegtsmux", "x264enc", "h264parse"}))
    GTEST_SKIP() << "gstreamer1.0-plugins-bad or -ugly is not installed";
  std::vector<Packet> still;
  for (int i = 0; i < 90; ++i)
    still.push_back(packet_of(resting(), i * kFrame));
  const std::string video =
      "videotestsrc num-buffers=90 ! video/x-raw,width=64,height=48,framerate=30/1 ! x264enc "
      "tune=zerolatency ! h264parse ! queue max-size-buffers=2 ! mux. ";
  for (const char *mux :
       {"meta/x-klv ! queue ! mux. mpegtsmux", "text/x-raw ! queue ! mux. matroskamux"}) {
    const auto made = run(video + kFieldIn + " ! hapticconvert ! " + mux +
                              " name=mux ! filesink location=" + file("still"),
                          still);
    EXPECT_EQ(made.error, "");
    EXPECT_GT(test::read_file(file("still")).size(), 1000U);
  }
}

TEST_F(HapticConvertField, AStreamThatTurnsFromPointsToFieldsIsNegotiatedAnew) {
  test::TrackSamples points(1);
  const auto point = run(kPointIn + " ! hapticconvert ! meta/x-klv ! appsink name=out sync=false",
                         {test::packet_of(points.next().motion, 0, kFrame)})
                         .packets;
  auto klv = coded("meta/x-klv");
  klv.insert(klv.begin(), point[0]);
  klv.push_back(point[0]);
  const auto got = run(kKlvIn + kOut, klv);
  EXPECT_EQ(got.error, "");
  ASSERT_EQ(got.packets.size(), track.size() + 2);
  test::sample_of(got.packets.front());
  field_of(got.packets[1]);
  test::sample_of(got.packets.back());
}

TEST_F(HapticConvertField, WhoTakesPointsOnlyIsToldWhy) {
  const auto klv = coded("meta/x-klv");
  for (const char *caps : {"haptics/x-raw,layout=point", "haptics/hmpg"}) {
    const auto got =
        run(kKlvIn + " ! hapticconvert ! " + caps + " ! appsink name=out sync=false", klv);
    EXPECT_NE(got.error.find("fields of the whole frame"), std::string::npos) << got.error;
  }
  const auto direct =
      run(kFieldIn + " ! hapticconvert ! haptics/hmpg ! appsink name=out sync=false", track);
  EXPECT_NE(direct.error, "");
}

// An encoder of video answers the same event.
TEST_F(HapticConvertField, AKeyFieldComesWhereItIsAskedFor) {
  constexpr int kAsked = 17;
  test::Pipeline pipeline(
      kFieldIn + " ! hapticconvert name=convert ! meta/x-klv ! appsink name=out sync=false");
  const haptic::ElementPtr convert(gst_bin_get_by_name(GST_BIN(pipeline.get()), "convert"));
  const haptic::PadPtr src(gst_element_get_static_pad(convert.get(), "src"));
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  gst_pad_send_event(src.get(), haptic::make_key_request(kAsked * kFrame));
  test::LeafFields fields(1);
  std::vector<Packet> input;
  for (int i = 0; i < 25; ++i)
    input.push_back(packet_of(fields.next(), static_cast<GstClockTime>(i) * kFrame));
  std::vector<int> keys;
  const auto got = pipeline.run(input).packets;
  for (std::size_t i = 0; i < got.size(); ++i)
    if (!(got[i].flags & GST_BUFFER_FLAG_DELTA_UNIT))
      keys.push_back(static_cast<int>(i));
  EXPECT_EQ(keys, (std::vector{0, 1, kAsked, kAsked + 1})) << "pairs";
}

// The first key fields are lost. Only the sender's next ones, a second later, would end the wait.
TEST_F(HapticConvertField, AReceiverWithoutAKeyFieldAsksTheSenderForOne) {
  if (!test::has_elements({"rtpbin", "rtpklvpay", "rtpklvdepay"}))
    GTEST_SKIP() << "gstreamer1.0-plugins-good is not installed";
  test::Pipeline pipeline(
      "rtpbin name=here rtp-profile=avpf  rtponesender name=there latency=0 " + kFieldIn +
      " is-live=true ! hapticconvert name=sender ! meta/x-klv ! rtpklvpay ! here.send_rtp_sink_0 "
      "here.send_rtp_src_0 ! identity name=network ! capssetter "
      "caps=application/x-rtp,rtcp-fb-ccm-fir=true ! there.recv_rtp_sink_0 "
      "there.send_rtcp_src_0 ! queue ! here.recv_rtcp_sink_0 "
      "there.recv_rtp_src_0 ! rtpklvdepay ! hapticconvert ! haptics/x-raw ! "
      "appsink name=out sync=false async=false");
  const haptic::ElementPtr in(gst_bin_get_by_name(GST_BIN(pipeline.get()), "in"));
  const haptic::ElementPtr out(gst_bin_get_by_name(GST_BIN(pipeline.get()), "out"));
  const haptic::ElementPtr network(gst_bin_get_by_name(GST_BIN(pipeline.get()), "network"));
  g_object_set(network.get(), "drop-probability", 1.0F, nullptr);
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  // Their times advance more slowly than the clock, so that no key field comes by itself.
  test::LeafFields leaves(1);
  GstSample *felt = nullptr;
  for (GstClockTime i = 0; i < 100 && !felt; ++i) {
    if (i == 5)
      g_object_set(network.get(), "drop-probability", 0.0F, nullptr);
    MotionField field = leaves.next();
    field.interval = GST_MSECOND;
    for (auto &cell : field.cells)
      cell.velocity_x *= kFrame / GST_MSECOND;
    test::push(GST_APP_SRC(in.get()), packet_of(field, i * GST_MSECOND));
    felt = gst_app_sink_try_pull_sample(GST_APP_SINK(out.get()), 50 * GST_MSECOND);
  }
  ASSERT_NE(felt, nullptr);
  gst_sample_unref(felt);
}

} // namespace hapticconvert_field_test
