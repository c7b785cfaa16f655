// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-rtphmpgdepay
 *
 * Receives MPEG haptics over RTP. See docs/elements/rtphmpgdepay.md.
 *
 *     gst-launch-1.0 udpsrc port=5006
 *         caps=application/x-rtp,media=haptics,clock-rate=8000,encoding-name=HMPG
 *         ! rtpjitterbuffer latency=30 ! rtphmpgdepay ! hapticconvert ! hapticsink device=sim
 *
 * Standard: RFC 9993, sections 5.2 (payload header) and 5.3 (payload structures).
 */
#include "core/track-buffer.hpp"
#include "core/track-caps.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "mpeg-haptics/hmpg-rtp.hpp"
#include "network/key-requests.hpp"

#include <gst/rtp/gstrtpbasedepayload.h>
#include <gst/rtp/gstrtpbuffer.h>
#include <utility>
#include <vector>

G_DECLARE_FINAL_TYPE(GstRtpHmpgDepay, gst_rtp_hmpg_depay, GST, RTP_HMPG_DEPAY, GstRTPBaseDepayload)

GST_DEBUG_CATEGORY_STATIC(rtp_hmpg_depay_debug);
#define GST_CAT_DEFAULT rtp_hmpg_depay_debug

namespace {
using haptic::BufferPtr;
using haptic::guarded;
using haptic::kGuarded;

struct State {
  // Streaming thread, or while it is stopped.
  haptic::UnitAssembler assembler;
  haptic::KeyAsker key_asker; // for the initialization unit
};
} // namespace

struct _GstRtpHmpgDepay {
  GstRTPBaseDepayload parent;
  State *state; // made in _init, deleted in _finalize
};

G_DEFINE_TYPE_WITH_CODE(GstRtpHmpgDepay, gst_rtp_hmpg_depay, GST_TYPE_RTP_BASE_DEPAYLOAD,
                        GST_DEBUG_CATEGORY_INIT(rtp_hmpg_depay_debug, "rtphmpgdepay", 0,
                                                "MPEG haptics over RTP"))
GST_ELEMENT_REGISTER_DEFINE(rtphmpgdepay, "rtphmpgdepay", GST_RANK_SECONDARY,
                            gst_rtp_hmpg_depay_get_type())

namespace {

gboolean set_caps(GstRTPBaseDepayload *depayload, GstCaps *caps) {
  gint rate = 0;
  if (!gst_structure_get_int(gst_caps_get_structure(caps, 0), "clock-rate", &rate))
    return FALSE;
  depayload->clock_rate = static_cast<guint>(rate);
  const haptic::CapsPtr out = haptic::make_hmpg_caps(rate);
  return gst_pad_set_caps(GST_RTP_BASE_DEPAYLOAD_SRCPAD(depayload), out.get());
}

// The base class gives a time to the first unit of a packet only.
GstBuffer *make_unit(const std::vector<std::uint8_t> &unit, GstClockTime time, bool after_loss) {
  BufferPtr buffer = haptic::make_buffer(unit, time, GST_CLOCK_TIME_NONE);
  const auto header = haptic::read_unit_header(unit);
  if (header && header->type == haptic::UnitType::initialization)
    GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_HEADER);
  if (header && header->dependent)
    GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_DELTA_UNIT);
  if (after_loss)
    GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_DISCONT);
  return buffer.release();
}

GstBuffer *process(GstRTPBaseDepayload *depayload, GstRTPBuffer *rtp) {
  State &state = *GST_RTP_HMPG_DEPAY(depayload)->state;
  const auto result = state.assembler.push(
      gst_rtp_buffer_get_seq(rtp), {static_cast<const guint8 *>(gst_rtp_buffer_get_payload(rtp)),
                                    gst_rtp_buffer_get_payload_len(rtp)});
  if (result.problem)
    GST_INFO_OBJECT(depayload, "dropped %s", result.problem);
  if (result.waits)
    state.key_asker.ask(GST_RTP_BASE_DEPAYLOAD_SINKPAD(depayload), GST_BUFFER_PTS(rtp->buffer));
  bool after_loss = result.after_loss;
  for (const auto &unit : result.units)
    gst_rtp_base_depayload_push(
        depayload, make_unit(unit, GST_BUFFER_PTS(rtp->buffer), std::exchange(after_loss, false)));
  return nullptr;
}

gboolean handle_event(GstRTPBaseDepayload *depayload, GstEvent *event) {
  if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP)
    GST_RTP_HMPG_DEPAY(depayload)->state->assembler.reset();
  return GST_RTP_BASE_DEPAYLOAD_CLASS(gst_rtp_hmpg_depay_parent_class)
      ->handle_event(depayload, event);
}

GstStateChangeReturn change_state(GstElement *element, GstStateChange transition) {
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED)
    *GST_RTP_HMPG_DEPAY(element)->state = {};
  return GST_ELEMENT_CLASS(gst_rtp_hmpg_depay_parent_class)->change_state(element, transition);
}

} // namespace

static void gst_rtp_hmpg_depay_init(GstRtpHmpgDepay *self) {
  guarded(self, [&] { self->state = new State; });
}

static void gst_rtp_hmpg_depay_class_init(GstRtpHmpgDepayClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *depayload_class = GST_RTP_BASE_DEPAYLOAD_CLASS(klass);
  G_OBJECT_CLASS(klass)->finalize =
      haptic::delete_state<GstRtpHmpgDepay, gst_rtp_hmpg_depay_parent_class>;
  haptic::describe(element_class, "rtphmpgdepay", "RTP MPEG haptics depayloader",
                   "Codec/Depayloader/Network/RTP", "Receives MPEG haptics over RTP (RFC 9993)",
                   HAPTIC_HMPG_RTP_CAPS, HAPTIC_HMPG_CAPS);
  element_class->change_state = kGuarded<change_state>;
  depayload_class->set_caps = kGuarded<set_caps>;
  depayload_class->handle_event = kGuarded<handle_event>;
  depayload_class->process_rtp_packet = kGuarded<process>;
}
