// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-rtphmpgpay
 *
 * Sends MPEG haptics over RTP. See docs/elements/rtphmpgpay.md.
 *
 *     gst-launch-1.0 videotestsrc is-live=true ! roitracker ! velocityavg ! hapticconvert
 *         ! rtphmpgpay ! udpsink host=127.0.0.1 port=5006 sync=false
 *
 * Standard: RFC 9993, sections 5.1 (marker), 5.2 (payload header), 5.3 (payload structures) and 5.4
 * (full intra requests).
 */
#include "core/track-buffer.hpp"
#include "core/track-caps.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/property-table.hpp"
#include "messages.hpp"
#include "mpeg-haptics/hmpg-rtp.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <gst/rtp/gstrtpbasepayload.h>
#include <gst/rtp/gstrtpbuffer.h>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

G_DECLARE_FINAL_TYPE(GstRtpHmpgPay, gst_rtp_hmpg_pay, GST, RTP_HMPG_PAY, GstRTPBasePayload)

GST_DEBUG_CATEGORY_STATIC(rtp_hmpg_pay_debug);
#define GST_CAT_DEFAULT rtp_hmpg_pay_debug

namespace {

using haptic::BufferPtr;
using haptic::guarded;
using haptic::HmpgPayload;
using haptic::kGuarded;
using haptic::ObjectLock;
using haptic::UnitType;

constexpr guint kDefaultConfigInterval = 1; // s
constexpr guint kLongestConfigInterval = 3600;

struct State {
  // Object lock.
  guint config_interval = kDefaultConfigInterval; // s, 0: never
  bool aggregate = false;

  std::atomic<bool> refresh = false; // a receiver asks for the initialization unit

  // Streaming thread only, or while it is stopped.
  std::vector<std::uint8_t> initialization;
  std::uint32_t first_tick = 0;                   // its time
  GstClockTime first_pts = GST_CLOCK_TIME_NONE;   // its PTS
  GstClockTime initialized = GST_CLOCK_TIME_NONE; // PTS at which it was sent last
  bool silent = true;
};

} // namespace

struct _GstRtpHmpgPay {
  GstRTPBasePayload parent;
  State *state; // made in _init, deleted in _finalize
};

G_DEFINE_TYPE_WITH_CODE(GstRtpHmpgPay, gst_rtp_hmpg_pay, GST_TYPE_RTP_BASE_PAYLOAD,
                        GST_DEBUG_CATEGORY_INIT(rtp_hmpg_pay_debug, "rtphmpgpay", 0,
                                                "MPEG haptics over RTP"))
GST_ELEMENT_REGISTER_DEFINE(rtphmpgpay, "rtphmpgpay", GST_RANK_SECONDARY,
                            gst_rtp_hmpg_pay_get_type())

namespace {

gboolean set_caps(GstRTPBasePayload *payload, GstCaps *caps) {
  gint rate = 0;
  if (!gst_structure_get_int(gst_caps_get_structure(caps, 0), "rate", &rate))
    return FALSE;
  gst_rtp_base_payload_set_options(payload, "haptics", TRUE, "HMPG", static_cast<guint32>(rate));
  return gst_rtp_base_payload_set_outcaps(payload, nullptr);
}

std::size_t largest_payload(GstRTPBasePayload *payload) {
  return gst_rtp_buffer_calc_payload_len(GST_RTP_BASE_PAYLOAD_MTU(payload), 0, 0);
}

// A buffer with one unit, which is mapped.
struct Unit {
  GstBuffer *buffer;
  std::span<const std::uint8_t> bytes;
};

// The packets of one push. Their payloads share the memory of the units.
class Packets {
public:
  explicit Packets(GstRTPBasePayload *payload)
      : payload_(payload), list_(gst_buffer_list_new(), gst_buffer_list_unref) {}

  // Adds a packet for each payload, whose part is one of the unit. `marker` is of the first.
  void add(const std::vector<HmpgPayload> &payloads, const Unit &unit, bool marker) {
    for (const HmpgPayload &payload : payloads) {
      BufferPtr packet(gst_rtp_base_payload_allocate_output_buffer(
          payload_, static_cast<guint>(payload.head.size()), 0, 0));
      GstRTPBuffer rtp = GST_RTP_BUFFER_INIT;
      if (!gst_rtp_buffer_map(packet.get(), GST_MAP_READWRITE, &rtp))
        return;
      std::ranges::copy(payload.head, static_cast<guint8 *>(gst_rtp_buffer_get_payload(&rtp)));
      gst_rtp_buffer_set_marker(&rtp, std::exchange(marker, false));
      gst_rtp_buffer_unmap(&rtp);
      packet.reset(gst_buffer_append(
          packet.release(),
          gst_buffer_copy_region(unit.buffer, GST_BUFFER_COPY_MEMORY,
                                 static_cast<gsize>(payload.part.data() - unit.bytes.data()),
                                 payload.part.size())));
      GST_BUFFER_PTS(packet.get()) = GST_BUFFER_PTS(unit.buffer);
      GST_BUFFER_DURATION(packet.get()) = GST_BUFFER_DURATION(unit.buffer);
      gst_buffer_list_add(list_.get(), packet.release());
    }
  }

  GstFlowReturn push() { return gst_rtp_base_payload_push_list(payload_, list_.release()); }

private:
  GstRTPBasePayload *payload_;
  std::unique_ptr<GstBufferList, decltype(&gst_buffer_list_unref)> list_;
};

// Returns whether the initialization unit is to be sent again. A receiver cannot begin without it.
bool initialization_is_due(GstRtpHmpgPay *self, GstClockTime pts) {
  State &state = *self->state;
  if (!state.initialization.empty() && state.refresh.exchange(false))
    return true;
  const ObjectLock lock(self);
  return !state.initialization.empty() && state.config_interval > 0 &&
         GST_CLOCK_TIME_IS_VALID(pts) &&
         (!GST_CLOCK_TIME_IS_VALID(state.initialized) || pts < state.initialized ||
          pts - state.initialized >= state.config_interval * GST_SECOND);
}

void keep_initialization(State &state, std::span<const std::uint8_t> unit, GstClockTime pts) {
  state.initialization.assign(unit.begin(), unit.end());
  const auto experience = haptic::read_unit(unit, nullptr).experience;
  state.first_pts = experience ? pts : GST_CLOCK_TIME_NONE;
  state.first_tick = experience ? experience->time : 0;
}

// The unit names the time of what follows it.
void set_time(State &state, guint rate, GstClockTime pts) {
  if (!GST_CLOCK_TIME_IS_VALID(state.first_pts) || pts < state.first_pts)
    return;
  const auto ticks = gst_util_uint64_scale_round(pts - state.first_pts, rate, GST_SECOND);
  haptic::set_initialization_time(state.initialization,
                                  static_cast<std::uint32_t>(state.first_tick + ticks));
}

bool aggregates(GstRtpHmpgPay *self) {
  const ObjectLock lock(self);
  return self->state->aggregate;
}

GstFlowReturn handle_unit(GstRTPBasePayload *payload, const Unit &unit) {
  GstRtpHmpgPay *self = GST_RTP_HMPG_PAY(payload);
  State &state = *self->state;
  const GstClockTime pts = GST_BUFFER_PTS(unit.buffer);
  const auto header = haptic::read_unit_header(unit.bytes);
  if (!header || unit.bytes.size() != haptic::kUnitHeaderSize + header->length) {
    GST_ELEMENT_ERROR(payload, STREAM, FORMAT, ("%s", haptic::messages::kHmpgIsNoUnit),
                      ("%" G_GSIZE_FORMAT " bytes", unit.bytes.size()));
    return GST_FLOW_ERROR;
  }
  const std::size_t largest = largest_payload(payload);
  Packets packets(payload);
  bool marker = false;
  if (header->type == UnitType::initialization) {
    keep_initialization(state, unit.bytes, pts);
    state.initialized = pts;
    if (aggregates(self)) {
      state.refresh = true; // with the next unit, which has the same time
      return GST_FLOW_OK;
    }
  } else {
    const bool silent = header->type == UnitType::silent;
    marker = std::exchange(state.silent, silent) && !silent;
    if (initialization_is_due(self, pts)) {
      state.initialized = pts;
      set_time(state, payload->clock_rate, pts);
      const std::array<std::span<const std::uint8_t>, 2> both = {state.initialization, unit.bytes};
      if (const auto shared =
              aggregates(self) ? haptic::aggregate_units(both, largest) : std::nullopt) {
        packets.add({*shared}, unit, marker);
        return packets.push();
      }
      const BufferPtr buffer = haptic::make_buffer(state.initialization, pts, 0);
      const haptic::ReadableBuffer readable(buffer.get());
      packets.add(haptic::packetize_unit(readable.bytes(), largest),
                  {buffer.get(), readable.bytes()}, false);
    }
  }
  packets.add(haptic::packetize_unit(unit.bytes, largest), unit, marker);
  return packets.push();
}

GstFlowReturn handle_buffer(GstRTPBasePayload *payload, GstBuffer *raw) {
  const BufferPtr buffer(raw);
  const haptic::ReadableBuffer readable(buffer.get());
  return readable ? handle_unit(payload, {buffer.get(), readable.bytes()}) : GST_FLOW_ERROR;
}

// A full intra request of RTCP (RFC 5104), which rtpsession turns into this event of video.
gboolean src_event(GstRTPBasePayload *payload, GstEvent *event) {
  if (gst_event_has_name(event, "GstForceKeyUnit"))
    GST_RTP_HMPG_PAY(payload)->state->refresh = true;
  return GST_RTP_BASE_PAYLOAD_CLASS(gst_rtp_hmpg_pay_parent_class)->src_event(payload, event);
}

GstStateChangeReturn change_state(GstElement *element, GstStateChange transition) {
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED) {
    State &state = *GST_RTP_HMPG_PAY(element)->state;
    state.initialization.clear();
    state.first_pts = GST_CLOCK_TIME_NONE;
    state.initialized = GST_CLOCK_TIME_NONE;
    state.silent = true;
    state.refresh = false;
  }
  return GST_ELEMENT_CLASS(gst_rtp_hmpg_pay_parent_class)->change_state(element, transition);
}

// ---- properties ---------------------------------------------------------------------------------

std::span<const haptic::Property<State>> properties() {
  using Rows = haptic::Rows<State>;
  static const haptic::Property<State> table[] = {
      Rows::number<&State::config_interval>(
          "config-interval", "Config Interval",
          "Seconds after which the initialization unit is sent again, for late receivers; 0: never",
          0, kLongestConfigInterval),
      Rows::flag<&State::aggregate>(
          "aggregate", "Aggregate",
          "Send the initialization unit in one packet with the unit that follows"),
  };
  return table;
}

} // namespace

static void gst_rtp_hmpg_pay_init(GstRtpHmpgPay *self) {
  guarded(self, [&] { self->state = new State; });
}

static void gst_rtp_hmpg_pay_class_init(GstRtpHmpgPayClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *payload_class = GST_RTP_BASE_PAYLOAD_CLASS(klass);
  object_class->finalize = haptic::delete_state<GstRtpHmpgPay, gst_rtp_hmpg_pay_parent_class>;
  haptic::install_properties<properties>(
      object_class, [](GObject *object) -> State & { return *GST_RTP_HMPG_PAY(object)->state; });
  haptic::describe(element_class, "rtphmpgpay", "RTP MPEG haptics payloader",
                   "Codec/Payloader/Network/RTP", "Sends MPEG haptics over RTP (RFC 9993)",
                   HAPTIC_HMPG_CAPS, HAPTIC_HMPG_RTP_CAPS);
  element_class->change_state = kGuarded<change_state>;
  payload_class->set_caps = kGuarded<set_caps>;
  payload_class->src_event = kGuarded<src_event>;
  payload_class->handle_buffer = kGuarded<handle_buffer>;
}
