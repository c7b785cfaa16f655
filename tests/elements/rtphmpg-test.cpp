// SPDX-License-Identifier: LGPL-2.1-or-later
// Full intra requests and aggregation packets of MPEG haptics over RTP.
#include "glue/gst-raii.hpp"
#include "mpeg-haptics/hmpg-track.hpp"

#include <gst/check/gstharness.h>
#include <gst/rtp/gstrtpbuffer.h>
#include <gtest/gtest.h>
#include <memory>

namespace rtphmpg_test {

using Bytes = std::vector<std::uint8_t>;

struct Teardown {
  void operator()(GstHarness *harness) const { gst_harness_teardown(harness); }
};
using Harness = std::unique_ptr<GstHarness, Teardown>;

constexpr char kUnits[] = "haptics/hmpg, stream-format=mihs, alignment=unit, rate=8000";
constexpr char kRtp[] = "application/x-rtp, media=haptics, encoding-name=HMPG, clock-rate=8000";

const Bytes &initialization() {
  static const Bytes unit =
      haptic::write_initialization_unit(haptic::track_experience("2026-01-01"));
  return unit;
}

class RtpHmpg : public testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  static void push(GstHarness *harness, const Bytes &bytes, GstClockTime pts) {
    GstBuffer *buffer = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
    gst_buffer_fill(buffer, 0, bytes.data(), bytes.size());
    GST_BUFFER_PTS(buffer) = pts;
    ASSERT_EQ(gst_harness_push(harness, buffer), GST_FLOW_OK);
  }

  // The first bytes of the payloads that were sent.
  static std::vector<int> headers(GstHarness *pay) {
    std::vector<int> all;
    while (GstBuffer *buffer = gst_harness_try_pull(pay)) {
      GstRTPBuffer rtp = GST_RTP_BUFFER_INIT;
      if (gst_rtp_buffer_map(buffer, GST_MAP_READ, &rtp)) {
        all.push_back(*static_cast<const guint8 *>(gst_rtp_buffer_get_payload(&rtp)));
        gst_rtp_buffer_unmap(&rtp);
      }
      gst_buffer_unref(buffer);
    }
    return all;
  }

  static void request(GstHarness *pay) {
    gst_harness_push_upstream_event(
        pay, gst_event_new_custom(GST_EVENT_CUSTOM_UPSTREAM,
                                  gst_structure_new("GstForceKeyUnit", "all-headers",
                                                    G_TYPE_BOOLEAN, TRUE, nullptr)));
  }

  const Bytes silent = haptic::write_silent_unit(800);
};

TEST_F(RtpHmpg, AFullIntraRequestBringsTheInitializationUnit) {
  const Harness pay(gst_harness_new_parse("rtphmpgpay config-interval=0"));
  gst_harness_set_src_caps_str(pay.get(), kUnits);
  push(pay.get(), initialization(), 0);
  push(pay.get(), silent, 0);
  push(pay.get(), silent, 100 * GST_MSECOND);
  EXPECT_EQ(headers(pay.get()), (std::vector{0x10, 0x40, 0x40}));
  request(pay.get());
  push(pay.get(), silent, 200 * GST_MSECOND);
  push(pay.get(), silent, 300 * GST_MSECOND);
  EXPECT_EQ(headers(pay.get()), (std::vector{0x10, 0x40, 0x40}));
}

TEST_F(RtpHmpg, AggregationSendsBothInOnePacket) {
  const Harness pay(gst_harness_new_parse("rtphmpgpay aggregate=true config-interval=0"));
  gst_harness_set_src_caps_str(pay.get(), kUnits);
  push(pay.get(), initialization(), 0);
  EXPECT_TRUE(headers(pay.get()).empty());
  push(pay.get(), silent, 0);
  push(pay.get(), silent, 100 * GST_MSECOND);
  request(pay.get());
  push(pay.get(), silent, 200 * GST_MSECOND);
  EXPECT_EQ(headers(pay.get()), (std::vector{0x50, 0x40, 0x50}));
}

TEST_F(RtpHmpg, BothUnitsOfAPacketHaveTheTimeAtTheReceiver) {
  const Harness pay(gst_harness_new_parse("rtphmpgpay aggregate=true config-interval=0"));
  gst_harness_set_src_caps_str(pay.get(), kUnits);
  push(pay.get(), initialization(), 0);
  push(pay.get(), silent, 0);
  const Harness depay(gst_harness_new("rtphmpgdepay"));
  gst_harness_set_src_caps_str(depay.get(), kRtp);
  GstBuffer *packet = gst_harness_pull(pay.get());
  constexpr GstClockTime kThere = 60 * GST_SECOND; // it has run for so long
  GST_BUFFER_PTS(packet) = kThere;
  ASSERT_EQ(gst_harness_push(depay.get(), packet), GST_FLOW_OK);
  for (int unit = 0; unit < 2; ++unit) {
    const haptic::BufferPtr buffer(gst_harness_try_pull(depay.get()));
    ASSERT_TRUE(buffer) << unit;
    EXPECT_EQ(GST_BUFFER_PTS(buffer.get()), kThere) << unit;
  }
}

TEST_F(RtpHmpg, AUnitIsOneListOfPacketsThatShareItsMemory) {
  const Harness pay(gst_harness_new_parse("rtphmpgpay config-interval=0 mtu=64"));
  gst_harness_set_src_caps_str(pay.get(), kUnits);
  std::vector<GstBufferList *> lists;
  gst_pad_add_probe(
      pay->sinkpad, static_cast<GstPadProbeType>(GST_PAD_PROBE_TYPE_BUFFER_LIST),
      [](GstPad *, GstPadProbeInfo *info, gpointer data) {
        static_cast<std::vector<GstBufferList *> *>(data)->push_back(
            gst_buffer_list_ref(GST_PAD_PROBE_INFO_BUFFER_LIST(info)));
        return GST_PAD_PROBE_OK;
      },
      &lists, nullptr);
  const haptic::BufferPtr unit(
      gst_buffer_new_memdup(initialization().data(), initialization().size()));
  ASSERT_EQ(gst_harness_push(pay.get(), gst_buffer_ref(unit.get())), GST_FLOW_OK);
  ASSERT_EQ(lists.size(), 1U);
  GstMemory *whole = gst_buffer_peek_memory(unit.get(), 0);
  const guint count = gst_buffer_list_length(lists[0]);
  EXPECT_GT(count, 3U);
  for (guint i = 0; i < count; ++i) {
    GstBuffer *packet = gst_buffer_list_get(lists[0], i);
    const GstMemory *part = gst_buffer_peek_memory(packet, gst_buffer_n_memory(packet) - 1);
    EXPECT_EQ(part->parent, whole) << "packet " << i;
  }
  gst_buffer_list_unref(lists[0]);
}

TEST_F(RtpHmpg, AReceiverThatWaitsAsksAndAgainAfterHalfASecond) {
  const Harness pay(gst_harness_new("rtphmpgpay"));
  gst_harness_set_src_caps_str(pay.get(), kUnits);
  const Harness depay(gst_harness_new("rtphmpgdepay"));
  gst_harness_set_src_caps_str(depay.get(), kRtp);
  for (int i = 0; i < 9; ++i) { // the sender has begun before
    push(pay.get(), silent, i * 100 * GST_MSECOND);
    gst_harness_push(depay.get(), gst_harness_pull(pay.get()));
  }
  int requests = 0;
  while (GstEvent *event = gst_harness_try_pull_upstream_event(depay.get())) {
    requests += gst_event_has_name(event, "GstForceKeyUnit") ? 1 : 0;
    gst_event_unref(event);
  }
  EXPECT_EQ(requests, 2) << "at 0 and 0.5 s of 0.9 s";
  EXPECT_EQ(gst_harness_buffers_in_queue(depay.get()), 0U);
}

} // namespace rtphmpg_test
