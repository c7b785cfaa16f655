// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-rtponesender
 *
 * Receives RTP of one sender a session, in step by RTCP. See docs/elements/rtponesender.md.
 *
 *     gst-launch-1.0 rtponesender name=rtp
 *         udpsrc port=5002
 * caps=application/x-rtp,media=application,clock-rate=90000,encoding-name=SMPTE336M !
 * rtp.recv_rtp_sink_0  udpsrc port=5003 ! rtp.recv_rtcp_sink_0 rtp.recv_rtp_src_0 ! rtpklvdepay !
 * hapticconvert ! hapticsink device=sim
 *
 * Standard: RFC 3550, sections 6.4.1 (sender reports) and 8 (SSRC); RFC 4585 (early feedback).
 */
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/property-table.hpp"
#include "messages.hpp"
#include "network/one-sender.hpp"
#include "network/stream-sync.hpp"

#include <cstdio>
#include <gst/gst.h>
#include <gst/net/gstnetaddressmeta.h>
#include <gst/rtp/gstrtcpbuffer.h>
#include <gst/rtp/gstrtpbuffer.h>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

G_DECLARE_FINAL_TYPE(GstRtpOneSender, gst_rtp_one_sender, GST, RTP_ONE_SENDER, GstBin)

GST_DEBUG_CATEGORY_STATIC(rtp_one_sender_debug);
#define GST_CAT_DEFAULT rtp_one_sender_debug

namespace {

using haptic::ElementPtr;
using haptic::guarded;
using haptic::kGuarded;
using haptic::OneSender;
using haptic::PadPtr;

constexpr guint kDefaultLatency = 30; // ms

struct Session {
  GstPad *out = nullptr; // the ghost pad, of which the bin is the owner
  OneSender senders;
  std::uint64_t unread = 0; // ns of a steady clock, the first packet; 0: none
  bool is_read = false;     // rtpbin knows the payload, or it was asked why not
};

struct State {
  GstElement *rtpbin = nullptr; // the bin is its owner; nullptr if there is none
  // Object lock.
  guint latency = kDefaultLatency; // ms

  std::mutex mutex; // never held while calling another element
  std::map<guint, Session> sessions;
  haptic::StreamSync sync;
};

} // namespace

struct _GstRtpOneSender {
  GstBin parent;
  State *state; // made in _init, deleted in _finalize
};

static GstStaticPadTemplate rtp_sink_template = GST_STATIC_PAD_TEMPLATE(
    "recv_rtp_sink_%u", GST_PAD_SINK, GST_PAD_REQUEST, GST_STATIC_CAPS("application/x-rtp"));
static GstStaticPadTemplate rtcp_sink_template = GST_STATIC_PAD_TEMPLATE(
    "recv_rtcp_sink_%u", GST_PAD_SINK, GST_PAD_REQUEST, GST_STATIC_CAPS("application/x-rtcp"));
static GstStaticPadTemplate rtcp_src_template = GST_STATIC_PAD_TEMPLATE(
    "send_rtcp_src_%u", GST_PAD_SRC, GST_PAD_REQUEST, GST_STATIC_CAPS("application/x-rtcp"));
static GstStaticPadTemplate rtp_src_template = GST_STATIC_PAD_TEMPLATE(
    "recv_rtp_src_%u", GST_PAD_SRC, GST_PAD_REQUEST, GST_STATIC_CAPS("application/x-rtp"));

G_DEFINE_TYPE_WITH_CODE(GstRtpOneSender, gst_rtp_one_sender, GST_TYPE_BIN,
                        GST_DEBUG_CATEGORY_INIT(rtp_one_sender_debug, "rtponesender", 0,
                                                "RTP of one sender"))
GST_ELEMENT_REGISTER_DEFINE(rtponesender, "rtponesender", GST_RANK_NONE,
                            gst_rtp_one_sender_get_type())

namespace {

// Calls `handle` with what passes the pad; an exception gives `otherwise`.
template <auto handle, GstPadProbeReturn otherwise = GST_PAD_PROBE_OK>
void add_probe(GstRtpOneSender *self, GstPad *pad, GstPadProbeType type) {
  gst_pad_add_probe(
      pad, type,
      [](GstPad *probed, GstPadProbeInfo *info, gpointer user) {
        return guarded(user, otherwise,
                       [&] { return handle(GST_RTP_ONE_SENDER(user), probed, info); });
      },
      self, nullptr);
}

// ---- senders ------------------------------------------------------------------------------------

// One pad of rtpbin: recv_rtp_src_SESSION_SSRC_PT.
struct Sender {
  guint session = 0;
  guint ssrc = 0;
  guint type = 0;
};

std::optional<Sender> sender_of(GstPad *pad) {
  const haptic::GCharPtr name(gst_pad_get_name(pad));
  Sender sender;
  // rtpbin wrote the numbers. NOLINTNEXTLINE(bugprone-unchecked-string-to-number-conversion)
  if (std::sscanf(name.get(), "recv_rtp_src_%u_%u_%u", &sender.session, &sender.ssrc,
                  &sender.type) != 3)
    return std::nullopt;
  return sender;
}

void warn_of_second(GstRtpOneSender *self, const Sender &sender, GstBuffer *buffer) {
  haptic::GCharPtr address;
  if (const auto *meta = gst_buffer_get_net_address_meta(buffer))
    address.reset(g_socket_connectable_to_string(G_SOCKET_CONNECTABLE(meta->addr)));
  GST_ELEMENT_WARNING(
      self, RESOURCE, BUSY,
      (haptic::messages::kRtpSecondSender, address ? address.get() : "?", sender.ssrc),
      ("session %u", sender.session));
}

// Links the sender's pad to the pad of its session, in place of the sender before.
void choose(GstRtpOneSender *self, GstPad *pad, GstPad *out) {
  gst_ghost_pad_set_target(GST_GHOST_PAD(out), pad);
  gst_element_post_message(GST_ELEMENT(self), gst_message_new_latency(GST_OBJECT(self)));
}

// Gives the packet the time that those of the other sessions have at the same instant.
void bring_into_step(GstRtpOneSender *self, GstPad *pad, const Sender &sender,
                     GstPadProbeInfo *info) {
  State &state = *self->state;
  GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
  const haptic::CapsPtr caps(gst_pad_get_current_caps(pad));
  haptic::TimedPacket packet;
  GstRTPBuffer rtp = GST_RTP_BUFFER_INIT;
  if (!GST_BUFFER_PTS_IS_VALID(buffer) || !caps ||
      !gst_structure_get_int(gst_caps_get_structure(caps.get(), 0), "clock-rate",
                             &packet.clock_rate) ||
      !gst_rtp_buffer_map(buffer, GST_MAP_READ, &rtp))
    return;
  packet.ssrc = sender.ssrc;
  packet.rtp = gst_rtp_buffer_get_timestamp(&rtp);
  packet.time = static_cast<std::int64_t>(GST_BUFFER_PTS(buffer));
  gst_rtp_buffer_unmap(&rtp);
  const GstClockTime now = gst_element_get_current_running_time(GST_ELEMENT(self));
  packet.earliest =
      GST_CLOCK_TIME_IS_VALID(now)
          ? static_cast<std::int64_t>(now) -
                std::int64_t{haptic::locked_copy(self, self->state->latency)} * GST_MSECOND
          : packet.time;
  const auto time = [&] {
    const std::lock_guard lock(state.mutex);
    return static_cast<GstClockTime>(state.sync.time_of(sender.session, packet));
  }();
  if (time == GST_BUFFER_PTS(buffer))
    return;
  buffer = gst_buffer_make_writable(buffer);
  GST_PAD_PROBE_INFO_DATA(info) = buffer;
  GST_BUFFER_PTS(buffer) = time;
  GST_BUFFER_DTS(buffer) = GST_CLOCK_TIME_NONE;
}

// Lets what the chosen sender sends through.
GstPadProbeReturn on_data(GstRtpOneSender *self, GstPad *pad, GstPadProbeInfo *info) {
  State &state = *self->state;
  const auto sender = sender_of(pad);
  if (!sender)
    return GST_PAD_PROBE_OK;
  const auto now = static_cast<std::uint64_t>(g_get_monotonic_time()) * GST_USECOND;
  OneSender::Verdict verdict = OneSender::Verdict::drop;
  PadPtr out;
  {
    const std::lock_guard lock(state.mutex);
    const auto session = state.sessions.find(sender->session);
    if (session == state.sessions.end() || !session->second.out)
      return GST_PAD_PROBE_DROP;
    verdict = session->second.senders.packet(sender->ssrc, now);
    session->second.is_read = true;
    out.reset(GST_PAD(gst_object_ref(session->second.out)));
  }
  switch (verdict) {
  case OneSender::Verdict::pass:
    if (gst_pad_is_linked(pad)) {
      bring_into_step(self, pad, *sender, info);
      return GST_PAD_PROBE_OK;
    }
    [[fallthrough]]; // it has changed the payload type, for which rtpbin makes another pad
  case OneSender::Verdict::chosen: // this packet came too early for caps and segment
    choose(self, pad, out.get());
    return GST_PAD_PROBE_DROP;
  case OneSender::Verdict::intruder:
    warn_of_second(self, *sender, GST_PAD_PROBE_INFO_BUFFER(info));
    return GST_PAD_PROBE_DROP;
  default:
    return GST_PAD_PROBE_DROP;
  }
}

void on_pad_added(GstRtpOneSender *self, GstPad *pad) {
  if (sender_of(pad))
    add_probe<on_data, GST_PAD_PROBE_DROP>(self, pad, GST_PAD_PROBE_TYPE_BUFFER);
}

// The sender said good-bye, or rtpbin has not heard of it for long.
void on_sender_left(GstRtpOneSender *self, guint number, guint ssrc) {
  State &state = *self->state;
  const std::lock_guard lock(state.mutex);
  if (const auto session = state.sessions.find(number); session != state.sessions.end())
    session->second.senders.leave(ssrc);
}

// The stream of a session ends although no sender ever came, or the last one left. Its id and its
// group are those of the input of the session.
void end_without_sender(GstRtpOneSender *self, guint number, GstPad *in) {
  State &state = *self->state;
  PadPtr out;
  {
    const std::lock_guard lock(state.mutex);
    if (const auto session = state.sessions.find(number);
        session != state.sessions.end() && session->second.out)
      out.reset(GST_PAD(gst_object_ref(session->second.out)));
  }
  if (!out || PadPtr(gst_ghost_pad_get_target(GST_GHOST_PAD(out.get()))))
    return;
  if (GstEvent *begin = gst_pad_get_sticky_event(in, GST_EVENT_STREAM_START, 0))
    gst_pad_push_event(out.get(), begin);
  gst_pad_push_event(out.get(), gst_event_new_eos());
}

GstPadProbeReturn on_input_event(GstRtpOneSender *self, GstPad *pad, GstPadProbeInfo *info) {
  const haptic::GCharPtr name(gst_pad_get_name(pad));
  guint number = 0;
  if (GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info)) == GST_EVENT_EOS &&
      std::sscanf(name.get(), rtp_sink_template.name_template, &number) == 1)
    end_without_sender(self, number, pad);
  return GST_PAD_PROBE_OK;
}

// rtpbin drops payloads of another kind than the caps have, and says nothing.
GstPadProbeReturn on_packet(GstRtpOneSender *self, GstPad *pad, GstPadProbeInfo *info) {
  const haptic::GCharPtr name(gst_pad_get_name(pad));
  guint number = 0;
  std::sscanf(name.get(), rtp_sink_template.name_template, &number);
  const auto now = static_cast<std::uint64_t>(g_get_monotonic_time()) * GST_USECOND;
  const auto patience =
      haptic::kSenderSilence +
      std::uint64_t{haptic::locked_copy(self, self->state->latency)} * GST_MSECOND;
  {
    const std::lock_guard lock(self->state->mutex);
    const auto found = self->state->sessions.find(number);
    if (found == self->state->sessions.end() || found->second.is_read)
      return GST_PAD_PROBE_OK;
    Session &session = found->second;
    session.unread = session.unread == 0 ? now : session.unread;
    if (now - session.unread < patience)
      return GST_PAD_PROBE_OK;
    session.is_read = true;
  }
  GstRTPBuffer rtp = GST_RTP_BUFFER_INIT;
  if (!gst_rtp_buffer_map(GST_PAD_PROBE_INFO_BUFFER(info), GST_MAP_READ, &rtp))
    return GST_PAD_PROBE_OK;
  const gint type = gst_rtp_buffer_get_payload_type(&rtp);
  gst_rtp_buffer_unmap(&rtp);
  const haptic::CapsPtr caps(gst_pad_get_current_caps(pad));
  gint wanted = -1;
  if (caps && gst_structure_get_int(gst_caps_get_structure(caps.get(), 0), "payload", &wanted) &&
      wanted != type)
    GST_ELEMENT_WARNING(self, STREAM, WRONG_TYPE,
                        (haptic::messages::kRtpOtherPayload, type, wanted), ("session %u", number));
  return GST_PAD_PROBE_OK;
}

// ---- sender reports -----------------------------------------------------------------------------

// The CNAME in this packet of descriptions; empty if there is none.
std::string name_of(GstRTCPPacket *packet) {
  if (!gst_rtcp_packet_sdes_first_item(packet) || !gst_rtcp_packet_sdes_first_entry(packet))
    return {};
  do {
    GstRTCPSDESType type = GST_RTCP_SDES_INVALID;
    guint8 length = 0;
    guint8 *text = nullptr;
    if (gst_rtcp_packet_sdes_get_entry(packet, &type, &length, &text) &&
        type == GST_RTCP_SDES_CNAME)
      return {reinterpret_cast<const char *>(text), length};
  } while (gst_rtcp_packet_sdes_next_entry(packet));
  return {};
}

// A compound packet has the report first and the sender's name after it (RFC 3550, section 6.1).
std::optional<haptic::SenderReport> report_in(GstBuffer *buffer) {
  GstRTCPBuffer rtcp = GST_RTCP_BUFFER_INIT;
  if (!gst_rtcp_buffer_validate(buffer) || !gst_rtcp_buffer_map(buffer, GST_MAP_READ, &rtcp))
    return std::nullopt;
  haptic::SenderReport report;
  bool has_report = false;
  GstRTCPPacket packet;
  for (bool more = gst_rtcp_buffer_get_first_packet(&rtcp, &packet); more;
       more = gst_rtcp_packet_move_to_next(&packet)) {
    if (gst_rtcp_packet_get_type(&packet) == GST_RTCP_TYPE_SR) {
      guint64 ntp = 0;
      gst_rtcp_packet_sr_get_sender_info(&packet, &report.ssrc, &ntp, &report.rtp, nullptr,
                                         nullptr);
      report.wall = static_cast<std::int64_t>(
          gst_util_uint64_scale(ntp, GST_SECOND, G_GUINT64_CONSTANT(1) << 32));
      has_report = true;
    } else if (gst_rtcp_packet_get_type(&packet) == GST_RTCP_TYPE_SDES && report.sender.empty()) {
      report.sender = name_of(&packet);
    }
  }
  gst_rtcp_buffer_unmap(&rtcp);
  return has_report && !report.sender.empty() ? std::optional(report) : std::nullopt;
}

GstPadProbeReturn on_rtcp(GstRtpOneSender *self, GstPad *pad, GstPadProbeInfo *info) {
  const haptic::GCharPtr name(gst_pad_get_name(pad));
  guint number = 0;
  if (std::sscanf(name.get(), rtcp_sink_template.name_template, &number) != 1)
    return GST_PAD_PROBE_OK;
  if (auto report = report_in(GST_PAD_PROBE_INFO_BUFFER(info))) {
    State &state = *self->state;
    const std::lock_guard lock(state.mutex);
    if (const auto session = state.sessions.find(number);
        session != state.sessions.end() && session->second.senders.is_chosen(report->ssrc))
      state.sync.report(number, std::move(*report));
  }
  return GST_PAD_PROBE_OK;
}

// ---- pads ---------------------------------------------------------------------------------------

// The name of this form with the lowest number that no pad has.
std::string free_name(GstRtpOneSender *self, const std::string &form) {
  const std::string stem = form.substr(0, form.find('%'));
  guint number = 0;
  const auto name = [&] { return stem + std::to_string(number); };
  while (PadPtr(gst_element_get_static_pad(GST_ELEMENT(self), name().c_str())))
    ++number;
  return name();
}

// `wanted` is nullptr if any number will do.
GstPad *request_pad(GstRtpOneSender *self, GstPadTemplate *pad_template, const gchar *wanted) {
  State &state = *self->state;
  guint number = 0;
  const std::string form = GST_PAD_TEMPLATE_NAME_TEMPLATE(pad_template);
  const std::string name = wanted ? wanted : free_name(self, form);
  if (!state.rtpbin || std::sscanf(name.c_str(), form.c_str(), &number) != 1)
    return nullptr;
  GstPad *pad = nullptr;
  if (form == rtp_src_template.name_template) {
    const std::lock_guard lock(state.mutex);
    Session &session = state.sessions[number];
    if (session.out)
      return nullptr;
    pad = session.out = gst_ghost_pad_new_no_target_from_template(name.c_str(), pad_template);
  } else {
    const PadPtr inner(gst_element_request_pad_simple(state.rtpbin, name.c_str()));
    if (!inner)
      return nullptr;
    pad = gst_ghost_pad_new_from_template(name.c_str(), inner.get(), pad_template);
    add_probe<on_input_event>(self, pad, GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM);
    if (form == rtp_sink_template.name_template)
      add_probe<on_packet>(self, pad, GST_PAD_PROBE_TYPE_BUFFER);
    if (form == rtcp_sink_template.name_template)
      add_probe<on_rtcp>(self, pad, GST_PAD_PROBE_TYPE_BUFFER);
  }
  gst_pad_set_active(pad, TRUE);
  gst_element_add_pad(GST_ELEMENT(self), pad);
  return pad;
}

void release_pad(GstRtpOneSender *self, GstPad *pad) {
  State &state = *self->state;
  const PadPtr inner(gst_ghost_pad_get_target(GST_GHOST_PAD(pad)));
  bool is_output = false;
  {
    const std::lock_guard lock(state.mutex);
    is_output = std::erase_if(state.sessions,
                              [&](const auto &entry) { return entry.second.out == pad; }) > 0;
  }
  gst_element_remove_pad(GST_ELEMENT(self), pad);
  if (inner && !is_output)
    gst_element_release_request_pad(state.rtpbin, inner.get());
}

GstStateChangeReturn change_state(GstElement *element, GstStateChange transition) {
  State &state = *GST_RTP_ONE_SENDER(element)->state;
  if (transition == GST_STATE_CHANGE_NULL_TO_READY && !state.rtpbin) {
    GST_ELEMENT_ERROR(element, CORE, MISSING_PLUGIN, ("%s", haptic::messages::kRtpbinIsMissing),
                      ("rtpbin"));
    return GST_STATE_CHANGE_FAILURE;
  }
  if (transition == GST_STATE_CHANGE_READY_TO_PAUSED) {
    const std::lock_guard lock(state.mutex);
    for (auto &[number, session] : state.sessions)
      session = {.out = session.out, .senders = {}};
    state.sync = {};
  }
  return GST_ELEMENT_CLASS(gst_rtp_one_sender_parent_class)->change_state(element, transition);
}

// ---- properties ---------------------------------------------------------------------------------

std::span<const haptic::Property<State>> properties() {
  static const haptic::Property<State> table[] = {
      haptic::Rows<State>::number<&State::latency>(
          "latency", "Latency",
          "How long packets that come late or out of order are waited for, ms", 0, 10000,
          haptic::kReady),
  };
  return table;
}

void add_rtpbin(GstRtpOneSender *self) {
  State &state = *self->state;
  state.rtpbin = gst_element_factory_make("rtpbin", nullptr);
  if (!state.rtpbin)
    return;
  // 3: feedback at once (AVPF). A sender that has left makes room. rtpbin's own synchronisation,
  // which this limit switches off, is wrong by the length of a stall until both streams have been
  // reported about again.
  g_object_set(state.rtpbin, "rtp-profile", 3, "autoremove", TRUE, "min-ts-offset",
               G_GUINT64_CONSTANT(1) << 62, nullptr);
  g_object_bind_property(self, "latency", state.rtpbin, "latency", G_BINDING_SYNC_CREATE);
  gst_bin_add(GST_BIN(self), state.rtpbin);
  g_signal_connect_object(state.rtpbin, "pad-added",
                          G_CALLBACK(+[](GstElement *, GstPad *pad, GstRtpOneSender *one) {
                            guarded(one, [&] { on_pad_added(one, pad); });
                          }),
                          self, static_cast<GConnectFlags>(0));
  for (const char *signal : {"on-bye-ssrc", "on-timeout"})
    g_signal_connect_object(
        state.rtpbin, signal,
        G_CALLBACK(+[](GstElement *, guint session, guint ssrc, GstRtpOneSender *one) {
          guarded(one, [&] { on_sender_left(one, session, ssrc); });
        }),
        self, static_cast<GConnectFlags>(0));
}

} // namespace

static void gst_rtp_one_sender_init(GstRtpOneSender *self) {
  guarded(self, [&] {
    self->state = new State;
    add_rtpbin(self);
  });
}

static void gst_rtp_one_sender_class_init(GstRtpOneSenderClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  object_class->finalize = haptic::delete_state<GstRtpOneSender, gst_rtp_one_sender_parent_class>;
  haptic::install_properties<properties>(
      object_class, [](GObject *object) -> State & { return *GST_RTP_ONE_SENDER(object)->state; });
  haptic::describe(element_class, "rtponesender", "RTP of one sender", "Generic/Bin/Network/RTP",
                   "Receives RTP of one sender a session, in step by RTCP");
  for (auto *pad : {&rtp_sink_template, &rtcp_sink_template, &rtp_src_template, &rtcp_src_template})
    gst_element_class_add_static_pad_template(element_class, pad);
  element_class->request_new_pad = kGuarded<request_pad>;
  element_class->release_pad = kGuarded<release_pad>;
  element_class->change_state = kGuarded<change_state>;
}
