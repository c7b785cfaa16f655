// SPDX-License-Identifier: LGPL-2.1-or-later
// RTP of one sender, whatever it sends.
#include "track-pipeline.hpp"

#include <algorithm>

namespace rtponesender_test {

using test::Packet;

// A packet of RTP (RFC 3550, section 5.1) of the sender 1, 10 ms after the one before.
Packet rtp_packet(int number, std::uint8_t payload_type) {
  const int time = number * 900;
  return {{0x80, payload_type, static_cast<std::uint8_t>(number >> 8),
           static_cast<std::uint8_t>(number), 0, 0, static_cast<std::uint8_t>(time >> 8),
           static_cast<std::uint8_t>(time), 0, 0, 0, 1, payload_type},
          static_cast<GstClockTime>(number) * 10 * GST_MSECOND};
}

TEST(RtpOneSender, ASenderMayChangeThePayloadType) {
  gst_init(nullptr, nullptr);
  if (!test::has_elements({"rtpbin"}))
    GTEST_SKIP() << "rtpbin is missing";
  std::vector<Packet> packets;
  for (int i = 0; i < 60; ++i)
    packets.push_back(rtp_packet(i, i < 30 ? 97 : 98));
  const auto outcome = test::run(
      "appsrc name=in format=time caps=application/x-rtp,media=application,clock-rate=90000,"
      "encoding-name=SMPTE336M ! identity sleep-time=5000 ! rtp.recv_rtp_sink_0 "
      "rtponesender name=rtp latency=0 rtp.recv_rtp_src_0 ! "
      "appsink name=out sync=false async=false",
      packets);
  EXPECT_EQ(outcome.error, "");
  EXPECT_EQ(outcome.warnings.size(), 0U);
  const auto of_type = [&](std::uint8_t type) {
    return std::ranges::count_if(outcome.packets,
                                 [&](const Packet &packet) { return packet.bytes[12] == type; });
  };
  EXPECT_GE(of_type(97), 28);
  EXPECT_GE(of_type(98), 28);
}

TEST(RtpOneSender, OfAnotherKindOfPayloadOneWarningSaysSo) {
  gst_init(nullptr, nullptr);
  if (!test::has_elements({"rtpbin"}))
    GTEST_SKIP() << "rtpbin is missing";
  std::vector<Packet> packets;
  for (int i = 0; i < 250; ++i)
    packets.push_back(rtp_packet(i, 115));
  const auto outcome = test::run(
      "appsrc name=in format=time caps=application/x-rtp,media=application,clock-rate=90000,"
      "encoding-name=SMPTE336M,payload=97 ! identity sleep-time=10000 ! rtp.recv_rtp_sink_0 "
      "rtponesender name=rtp latency=0 rtp.recv_rtp_src_0 ! "
      "appsink name=out sync=false async=false",
      packets);
  ASSERT_EQ(outcome.warnings.size(), 1U);
  EXPECT_NE(outcome.warnings[0].find("payload type 115, but this receiver takes type 97"),
            std::string::npos)
      << outcome.warnings[0];
}

TEST(RtpOneSender, SessionsThatEndWithoutASenderAreDifferentStreams) {
  gst_init(nullptr, nullptr);
  if (!test::has_elements({"rtpbin"}))
    GTEST_SKIP() << "rtpbin is missing";
  test::Pipeline pipeline("fakesrc num-buffers=0 ! rtp.recv_rtp_sink_0 "
                          "fakesrc num-buffers=0 ! rtp.recv_rtp_sink_1 rtponesender name=rtp "
                          "rtp.recv_rtp_src_0 ! fakesink name=first async=false "
                          "rtp.recv_rtp_src_1 ! fakesink name=second async=false");
  EXPECT_EQ(pipeline.run().error, "");
  const auto stream_of = [&](const char *sink) {
    const haptic::ElementPtr element(gst_bin_get_by_name(GST_BIN(pipeline.get()), sink));
    const haptic::PadPtr pad(gst_element_get_static_pad(element.get(), "sink"));
    const haptic::EventPtr begin(gst_pad_get_sticky_event(pad.get(), GST_EVENT_STREAM_START, 0));
    if (!begin)
      return std::string();
    guint group = GST_GROUP_ID_INVALID;
    EXPECT_TRUE(gst_event_parse_group_id(begin.get(), &group)) << sink;
    const gchar *id = nullptr;
    gst_event_parse_stream_start(begin.get(), &id);
    return std::string(id);
  };
  EXPECT_NE(stream_of("first"), stream_of("second"));
}

TEST(RtpOneSender, APadWithoutANumberGetsTheLowestFreeOne) {
  gst_init(nullptr, nullptr);
  if (!test::has_elements({"rtpbin"}))
    GTEST_SKIP() << "rtpbin is missing";
  const haptic::ElementPtr rtp(gst_element_factory_make("rtponesender", nullptr));
  for (const char *form : {"recv_rtp_sink_", "recv_rtp_src_"})
    for (const char *number : {"0", "1"}) {
      const haptic::PadPtr pad(
          gst_element_request_pad_simple(rtp.get(), (std::string(form) + "%u").c_str()));
      ASSERT_NE(pad, nullptr);
      EXPECT_EQ(haptic::GCharPtr(gst_pad_get_name(pad.get())).get(), std::string(form) + number);
    }
}

} // namespace rtponesender_test
