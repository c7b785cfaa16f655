// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-hapticconvert
 *
 * Converts a haptic track between samples, fields, reliefs, KLV, text and MPEG haptics. This
 * element holds caps and time; each form has a file of its own (track-form.hpp). See
 * docs/elements/hapticconvert.md.
 *
 *     gst-launch-1.0 filesrc location=session.ts ! tsdemux ! meta/x-klv ! hapticconvert
 *         ! hapticsink device=sim
 *
 * Standards: SMPTE ST 336 for KLV, ISO/IEC 23090-31:2025 for MPEG haptics.
 */
#include "core/track-buffer.hpp"
#include "core/track-caps.hpp"
#include "core/track-clock.hpp"
#include "core/track-time.hpp"
#include "forms/convert-caps.hpp"
#include "forms/problem-counters.hpp"
#include "forms/track-form.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/property-table.hpp"
#include "glue/segment-time.hpp"
#include "glue/stream-lock.hpp"
#include "messages.hpp"
#include "mpeg-haptics/hmpg-form.hpp"
#include "network/key-requests.hpp"
#include "network/latency-query.hpp"

#include <algorithm>
#include <atomic>
#include <deque>
#include <gst/base/gstbasetransform.h>
#include <memory>
#include <span>
#include <string>
#include <utility>

G_DECLARE_FINAL_TYPE(GstHapticConvert, gst_haptic_convert, GST, HAPTIC_CONVERT, GstBaseTransform)

GST_DEBUG_CATEGORY_STATIC(haptic_convert_debug);
#define GST_CAT_DEFAULT haptic_convert_debug

namespace {

using haptic::BufferPtr;
using haptic::CapsPtr;
using Form = haptic::TrackFormKind;
using haptic::guarded;
using haptic::kGuarded;
using haptic::layout_of;
using haptic::ObjectLock;
using haptic::TrackForm;
using haptic::TrackLayout;
using haptic::TrackProblem;
using haptic::TrackProblemKind;

constexpr guint kDefaultUnitDuration = 100; // ms
constexpr guint kLongestUnitDuration = 4000;

struct State {
  // Object lock.
  guint unit_duration = kDefaultUnitDuration; // ms
  bool start_untied = false;

  // Atomic, for any thread.
  std::atomic<guint64> samples = 0;
  haptic::ProblemCounters problems;
  haptic::KeyRequests key_requests;
  std::atomic<Form> in = Form::raw; // written by the streaming thread
  std::atomic<Form> out = Form::raw;

  // Streaming thread only, or while it is stopped.
  TrackLayout layout = TrackLayout::point; // of the samples that come
  std::unique_ptr<TrackForm> reader;       // none before the first caps
  std::unique_ptr<TrackForm> writer;
  std::deque<BufferPtr> ready;
  bool failed = false; // an error was posted
  bool discont = true;
  bool begun = false;        // a sample has come since the start or the last flush
  bool has_language = false; // was said of the text that leaves
  haptic::TrackClock clock;
  haptic::KeyAsker key_asker;
};

} // namespace

struct _GstHapticConvert {
  GstBaseTransform parent;
  State *state; // made in _init, deleted in _finalize
};

#define ALL_FORMS(text_formats)                                                                    \
  HAPTIC_MOTION_CAPS "; " HAPTIC_FIELD_CAPS "; " HAPTIC_RELIEF_CAPS "; " HAPTIC_KLV_CAPS           \
                     "; " HAPTIC_TEXT_TYPE ", format=(string)" text_formats "; " HAPTIC_HMPG_CAPS
static GstStaticPadTemplate sink_template = GST_STATIC_PAD_TEMPLATE(
    "sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS(ALL_FORMS("{ utf8, pango-markup }")));
static GstStaticPadTemplate src_template =
    GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(ALL_FORMS("utf8")));

G_DEFINE_TYPE_WITH_CODE(GstHapticConvert, gst_haptic_convert, GST_TYPE_BASE_TRANSFORM,
                        GST_DEBUG_CATEGORY_INIT(haptic_convert_debug, "hapticconvert", 0,
                                                "forms of a haptic track"))
GST_ELEMENT_REGISTER_DEFINE(hapticconvert, "hapticconvert", GST_RANK_NONE,
                            gst_haptic_convert_get_type())

namespace {

State &state_of(gpointer object) {
  return *GST_HAPTIC_CONVERT(object)->state;
}

GstBaseTransformClass *parent_class() {
  return GST_BASE_TRANSFORM_CLASS(gst_haptic_convert_parent_class);
}

// ---- caps ---------------------------------------------------------------------------------------

GstCaps *transform_caps(GstHapticConvert *, GstPadDirection direction, GstCaps *caps,
                        GstCaps *filter) {
  CapsPtr result = haptic::convertible_caps(
      caps, direction == GST_PAD_SINK ? &src_template : &sink_template, direction);
  if (filter)
    result.reset(gst_caps_intersect_full(filter, result.get(), GST_CAPS_INTERSECT_FIRST));
  return result.release();
}

// The caps of KLV and text do not show whether points, fields or reliefs come. The layout that came
// last is expected.
GstCaps *fixate_caps(GstHapticConvert *self, GstPadDirection direction, GstCaps *,
                     GstCaps *othercaps) {
  if (direction != GST_PAD_SINK)
    return gst_caps_fixate(othercaps);
  return haptic::fixated_caps(CapsPtr(othercaps), self->state->layout).release();
}

// ---- warnings -----------------------------------------------------------------------------------

void warn_once(GstHapticConvert *self, const TrackProblem &problem) {
  if (const char *message = self->state->problems.first_warning(problem.kind))
    GST_ELEMENT_WARNING(self, STREAM, FORMAT, ("%s", message), ("%s", problem.details.c_str()));
}

void report(GstHapticConvert *self, const TrackProblem &problem) {
  GST_DEBUG_OBJECT(self, "problem %d: %s", static_cast<int>(problem.kind), problem.details.c_str());
  self->state->problems.count(problem.kind);
  warn_once(self, problem);
}

// ---- time ---------------------------------------------------------------------------------------

// Completes the two times of a sample or field: `pts` of its buffer and the sender's `time`.
// Returns false if nothing ties the sample to the streams beside it: its place among them is
// unknown.
bool complete_times(GstHapticConvert *self, GstClockTime &pts, GstClockTime &time,
                    GstClockTime duration) {
  State &state = *self->state;
  const GstSegment &segment = GST_BASE_TRANSFORM(self)->segment;
  if (!state.reader->carries_time()) {
    time = haptic::stream_time_of(segment, pts);
  } else if (!GST_CLOCK_TIME_IS_VALID(pts) && GST_CLOCK_TIME_IS_VALID(time)) {
    const bool has_times = segment.format == GST_FORMAT_TIME;
    if (has_times && !state.clock.is_tied() &&
        !haptic::locked_copy(self, self->state->start_untied)) {
      state.problems.count(TrackProblemKind::untied);
      if (state.clock.wait_for_tie(time))
        warn_once(self, {TrackProblemKind::untied, "no PTS so far"});
      return false;
    }
    pts = state.clock.recovered(time, has_times && segment.rate > 0 ? segment.start : 0);
    report(self, {TrackProblemKind::without_time, "no PTS"});
  }
  state.clock.remember(pts, time, duration);
  return true;
}

// ---- output -------------------------------------------------------------------------------------

void queue_output(GstHapticConvert *self, const haptic::TrackOutput &output) {
  State &state = *self->state;
  for (const TrackProblem &problem : output.problems)
    report(self, problem);
  for (const haptic::OutputPacket &packet : output.packets) {
    BufferPtr buffer = haptic::make_buffer(packet.bytes, packet.time, packet.duration);
    if (packet.gap)
      GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_GAP);
    if (packet.delta)
      GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_DELTA_UNIT);
    if (packet.header)
      GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_HEADER);
    // Units carry the flags of their dependency themselves.
    if (state.out != Form::hmpg && std::exchange(state.discont, false))
      GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_DISCONT);
    state.ready.push_back(std::move(buffer));
  }
}

// Players choose text by its language, and in Matroska text without one is English (RFC 9559,
// 5.1.4.1.19). This one has no linguistic content (ISO 639-2).
void say_language(GstHapticConvert *self) {
  State &state = *self->state;
  if (state.out != Form::text || std::exchange(state.has_language, true))
    return;
  gst_pad_push_event(GST_BASE_TRANSFORM_SRC_PAD(self),
                     gst_event_new_tag(gst_tag_list_new(GST_TAG_LANGUAGE_CODE, "zxx", nullptr)));
}

void push_remaining(GstHapticConvert *self) {
  State &state = *self->state;
  if (state.writer) {
    haptic::TrackOutput output;
    state.writer->finish(output);
    queue_output(self, output);
  }
  while (!state.ready.empty()) {
    say_language(self);
    GstBuffer *buffer = state.ready.front().release();
    state.ready.pop_front();
    if (gst_pad_push(GST_BASE_TRANSFORM_SRC_PAD(self), buffer) != GST_FLOW_OK)
      state.ready.clear();
  }
}

// Announces samples of this layout downstream. Returns false, with an error posted, if they are
// refused.
bool change_layout(GstHapticConvert *self, TrackLayout layout) {
  State &state = *self->state;
  if (state.layout == layout)
    return !state.failed;
  push_remaining(self);
  state.layout = layout;
  if (state.out == Form::hmpg && layout != TrackLayout::point) {
    state.failed = true;
    GST_ELEMENT_ERROR(self, STREAM, WRONG_TYPE, ("%s", haptic::messages::kTrackFieldsInHmpg),
                      ("%s", haptic::layout_name(layout)));
  } else if (state.out == Form::raw) {
    auto *trans = GST_BASE_TRANSFORM(self);
    CapsPtr caps(gst_pad_get_current_caps(GST_BASE_TRANSFORM_SRC_PAD(trans)));
    caps.reset(gst_caps_make_writable(caps.release()));
    haptic::set_layout(caps.get(), layout);
    const CapsPtr allowed(gst_pad_peer_query_caps(GST_BASE_TRANSFORM_SRC_PAD(trans), nullptr));
    if (!gst_caps_can_intersect(allowed.get(), caps.get()) ||
        !gst_base_transform_update_src_caps(trans, caps.get())) {
      state.failed = true;
      GST_ELEMENT_ERROR(self, STREAM, WRONG_TYPE,
                        (haptic::messages::kTrackLayoutIsRefused, haptic::layout_name(layout)),
                        ("%" GST_PTR_FORMAT, static_cast<void *>(caps.get())));
    }
  }
  return !state.failed;
}

// ---- items --------------------------------------------------------------------------------------

struct ItemConverter {
  GstHapticConvert *self;

  void operator()(haptic::TimedSample &item) const {
    if (!begins(TrackLayout::point, item.time, item.sample))
      return;
    haptic::TrackOutput output;
    self->state->writer->write(item, output);
    ++self->state->samples;
    queue_output(self, output);
  }

  void operator()(haptic::TimedField &item) const {
    if (!begins(haptic::layout_of(item.field.kind), item.time, item.field))
      return;
    State &state = *self->state;
    haptic::TrackOutput output;
    if (state.writer->write(item, output))
      ++state.samples;
    else // a sender that hears it need not wait for its next key field
      state.key_asker.ask(GST_BASE_TRANSFORM_SINK_PAD(self), item.time);
    queue_output(self, output);
  }

  // A gap event takes the place of the field, so that no muxer waits for it.
  void operator()(const haptic::TimedRest &item) const {
    State &state = *self->state;
    state.begun = true;
    ++state.samples;
    if (GST_CLOCK_TIME_IS_VALID(item.time))
      gst_pad_push_event(GST_BASE_TRANSFORM_SRC_PAD(self),
                         gst_event_new_gap(item.time, item.duration));
  }

  void operator()(const TrackProblem &problem) const { report(self, problem); }

private:
  // Returns whether the item is converted.
  bool begins(TrackLayout layout, GstClockTime &pts, auto &own) const {
    if (!change_layout(self, layout) || !complete_times(self, pts, own.time, own.duration))
      return false;
    self->state->begun = true;
    return true;
  }
};

void convert(GstHapticConvert *self, GstBuffer *buffer) {
  State &state = *self->state;
  if (GST_BUFFER_IS_DISCONT(buffer))
    state.discont = true;
  const haptic::ReadableBuffer readable(buffer);
  if (!readable)
    return report(self, {TrackProblemKind::damaged, "a buffer that cannot be read"});
  if (state.in == Form::raw && state.key_requests.is_due(haptic::running_time_of(
                                   GST_BASE_TRANSFORM(self)->segment, GST_BUFFER_PTS(buffer))))
    state.reader->restart();
  std::vector<haptic::TrackItem> items;
  state.reader->read({readable.bytes(), GST_BUFFER_PTS(buffer), GST_BUFFER_DURATION(buffer),
                      GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP) != FALSE,
                      GST_BUFFER_IS_DISCONT(buffer) != FALSE},
                     items);
  for (auto &item : items)
    std::visit(ItemConverter{self}, item);
}

// Converts and sends all that is held back.
void drain(GstHapticConvert *self) {
  State &state = *self->state;
  std::vector<haptic::TrackItem> items;
  if (state.reader && state.writer)
    state.reader->finish_reading(items);
  for (auto &item : items)
    std::visit(ItemConverter{self}, item);
  push_remaining(self);
}

GstFlowReturn generate_output(GstBaseTransform *trans, GstBuffer **out) {
  if (gst_base_transform_is_passthrough(trans))
    return parent_class()->generate_output(trans, out);
  State &state = state_of(trans);
  if (trans->queued_buf) {
    const BufferPtr buffer(std::exchange(trans->queued_buf, nullptr));
    // At a restart the pad takes buffers before the class forgets the caps of the run before.
    if (!state.reader || !state.writer)
      return GST_FLOW_NOT_NEGOTIATED;
    convert(GST_HAPTIC_CONVERT(trans), buffer.get());
  }
  if (state.failed)
    return GST_FLOW_NOT_NEGOTIATED;
  *out = nullptr;
  if (!state.ready.empty()) {
    say_language(GST_HAPTIC_CONVERT(trans));
    *out = state.ready.front().release();
    state.ready.pop_front();
  }
  return GST_FLOW_OK;
}

// ---- events and queries -------------------------------------------------------------------------

void restart_stream(State &state) {
  state.ready.clear();
  for (const auto &form : {state.reader.get(), state.writer.get()})
    if (form)
      form->restart();
  state.discont = true;
  state.begun = false;
}

// Muxers and receivers ask for a key field where a segment begins or a packet was lost.
gboolean src_event(GstBaseTransform *trans, GstEvent *event) {
  State &state = state_of(trans);
  if (state.in != Form::raw || !state.key_requests.add(event))
    return parent_class()->src_event(trans, event);
  gst_event_unref(event);
  return TRUE;
}

gboolean sink_event(GstBaseTransform *trans, GstEvent *event) {
  State &state = state_of(trans);
  switch (GST_EVENT_TYPE(event)) {
  case GST_EVENT_EOS:
    if (state.clock.is_waiting())
      warn_once(GST_HAPTIC_CONVERT(trans), {TrackProblemKind::untied, "no PTS"});
    [[fallthrough]];
  case GST_EVENT_SEGMENT:
  case GST_EVENT_CAPS:
    drain(GST_HAPTIC_CONVERT(trans));
    break;
  case GST_EVENT_FLUSH_STOP:
    restart_stream(state);
    break;
  case GST_EVENT_STREAM_START:
    state.clock.forget();
    state.has_language = false;
    break;
  case GST_EVENT_GAP:
    // Demuxers send them when other streams run ahead, tsdemux 1.22 also before its segment. A
    // muxer behind KLV or text needs them, or it waits for a track that has ended. For a device
    // they would mean that nothing is measured where a field rests: such a field comes once a
    // second, and matroskademux sends gaps half a second after it. Beside a queue of 1 s its gaps
    // behind the end of a track reach no further, so that no limit tells one from the other.
    if ((state.in != Form::raw && state.begun && state.out != Form::klv &&
         state.out != Form::text) ||
        trans->segment.format != GST_FORMAT_TIME) {
      gst_event_unref(event);
      return TRUE;
    }
    break;
  default:
    break;
  }
  return parent_class()->sink_event(trans, event);
}

// MPEG haptics is written a unit at a time, when it is over. Live, its reader may hold samples
// back.
gboolean query(GstBaseTransform *trans, GstPadDirection direction, GstQuery *query) {
  const gboolean done = parent_class()->query(trans, direction, query);
  const State &state = state_of(trans);
  if (!done || direction != GST_PAD_SRC || GST_QUERY_TYPE(query) != GST_QUERY_LATENCY)
    return done;
  if ((state.out == Form::hmpg) == (state.in == Form::hmpg))
    return done;
  const ObjectLock lock(trans);
  haptic::add_latency(query, [&](bool live) -> GstClockTime {
    if (state.in != Form::hmpg)
      return state.unit_duration * GST_MSECOND;
    return live ? haptic::ns_of(haptic::kLongestHold, haptic::kTrackTimescale) : 0;
  });
  return TRUE;
}

std::unique_ptr<TrackForm> make_form(GstHapticConvert *self, Form form, TrackLayout layout) {
  switch (form) {
  case Form::klv:
    return haptic::make_klv_form();
  case Form::text:
    return haptic::make_text_form();
  case Form::hmpg: {
    const ObjectLock lock(self);
    return haptic::make_hmpg_form(self->state->unit_duration * GST_MSECOND);
  }
  default:
    return haptic::make_raw_form(layout);
  }
}

// Forms are kept where they stay the same, since a unit can only be read with what came before.
gboolean set_caps(GstHapticConvert *self, GstCaps *in, GstCaps *out) {
  State &state = *self->state;
  const Form form_in = haptic::form_of(in);
  const Form form_out = haptic::form_of(out);
  if (form_in == Form::raw)
    state.layout = layout_of(gst_caps_get_structure(in, 0));
  else if (form_in == Form::hmpg)
    state.layout = TrackLayout::point;
  else if (form_out == Form::raw)
    state.layout = layout_of(gst_caps_get_structure(out, 0)); // until another one comes
  if (!state.reader || form_in != state.in || form_in == Form::raw)
    state.reader = make_form(self, form_in, state.layout);
  if (!state.writer || form_out != state.out)
    state.writer = make_form(self, form_out, state.layout);
  state.reader->set_live(haptic::is_live(GST_BASE_TRANSFORM_SINK_PAD(self)));
  state.in = form_in;
  state.out = form_out;
  restart_stream(state);
  return TRUE;
}

// The stream may have begun: the pad takes events and buffers before this call.
gboolean start(GstBaseTransform *trans) {
  State &state = state_of(trans);
  state.problems.reset();
  state.samples = 0;
  return TRUE;
}

gboolean stop(GstBaseTransform *trans) {
  const haptic::StreamLock stream(trans);
  State &state = state_of(trans);
  state.reader.reset();
  state.writer.reset();
  restart_stream(state);
  state.key_requests.clear();
  state.key_asker = {};
  state.failed = false;
  state.clock = {};
  state.has_language = false;
  return TRUE;
}

// ---- properties ---------------------------------------------------------------------------------

std::span<const haptic::Property<State>> properties() {
  using Rows = haptic::Rows<State>;
  static const haptic::Property<State> table[] = {
      Rows::number<&State::unit_duration>(
          "unit-duration", "Unit Duration",
          "Length of the units of haptics/hmpg, ms; a unit is sent when it is over", 1,
          kLongestUnitDuration, haptic::kReady),
      Rows::flag<&State::start_untied>(
          "start-untied", "Start Untied",
          "A track that has lost its time stamps begins where the other streams begin"),
      {g_param_spec_boxed("stats", "Statistics", "Counters since the last start",
                          GST_TYPE_STRUCTURE, haptic::kReadOnly),
       nullptr,
       [](const State &state, GValue *value) {
         GstStructure *stats = gst_structure_new("hapticconvert-stats", "samples", G_TYPE_UINT64,
                                                 state.samples.load(), nullptr);
         state.problems.write(*stats);
         g_value_take_boxed(value, stats);
       }},
  };
  return table;
}

} // namespace

static void gst_haptic_convert_init(GstHapticConvert *self) {
  guarded(self, [&] { self->state = new State; });
  gst_base_transform_set_qos_enabled(GST_BASE_TRANSFORM(self), FALSE);
  gst_base_transform_set_gap_aware(GST_BASE_TRANSFORM(self), TRUE);
}

static void gst_haptic_convert_class_init(GstHapticConvertClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);

  object_class->finalize = haptic::delete_state<GstHapticConvert, gst_haptic_convert_parent_class>;
  haptic::install_properties<properties>(
      object_class, [](GObject *object) -> State & { return state_of(object); });

  haptic::describe(
      element_class, "hapticconvert", "Haptic track converter", "Codec/Converter/Haptics",
      "Converts a haptic track between samples, fields, reliefs, KLV, text and MPEG haptics");
  gst_element_class_add_static_pad_template(element_class, &sink_template);
  gst_element_class_add_static_pad_template(element_class, &src_template);

  transform_class->passthrough_on_same_caps = TRUE;
  transform_class->transform_caps = kGuarded<transform_caps>;
  transform_class->fixate_caps = kGuarded<fixate_caps>;
  transform_class->set_caps = kGuarded<set_caps>;
  transform_class->start = kGuarded<start>;
  transform_class->stop = kGuarded<stop>;
  transform_class->sink_event = kGuarded<sink_event>;
  transform_class->src_event = kGuarded<src_event>;
  transform_class->query = kGuarded<query>;
  transform_class->generate_output = kGuarded<generate_output>;
  // Without this function the base class takes the element for one that changes nothing.
  transform_class->transform = [](GstBaseTransform *, GstBuffer *, GstBuffer *) {
    return GST_FLOW_NOT_SUPPORTED;
  };
}
