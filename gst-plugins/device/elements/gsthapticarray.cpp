// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticarray makes motion felt on the skin: a channel of audio for each actuator of an array.
//
//   gst-launch-1.0 videotestsrc pattern=ball ! motionfield ! hapticarray ! audioconvert !
//   autoaudiosink
//
// It is an aggregator with one pad, because only that class makes live output when input is late.
#include "array/array-drive.hpp"
#include "array/array-voices.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "glue/property-table.hpp"
#include "glue/segment-time.hpp"
#include "messages.hpp"
#include "safety/safety-chain.hpp"

#include <algorithm>
#include <cmath>
#include <gst/base/gstaggregator.h>
#include <memory>
#include <optional>
#include <string>
#include <utility>

G_DECLARE_FINAL_TYPE(GstHapticArray, gst_haptic_array, GST, HAPTIC_ARRAY, GstAggregator)

GST_DEBUG_CATEGORY_STATIC(hapticarray_debug);
#define GST_CAT_DEFAULT hapticarray_debug

#define HAPTIC_ARRAY_CAPS                                                                          \
  "audio/x-raw, format=(string)" HAPTIC_ARRAY_FORMAT ", layout=(string)interleaved, "              \
  "rate=(int)[ 8000, 192000 ], channels=(int)[ 2, 64 ]"
#if G_BYTE_ORDER == G_LITTLE_ENDIAN
#define HAPTIC_ARRAY_FORMAT "F32LE"
#else
#define HAPTIC_ARRAY_FORMAT "F32BE"
#endif

namespace {

using haptic::ArrayVoices;
using haptic::guarded;
using haptic::kGuarded;
using haptic::ObjectLock;

// State

constexpr int kFrames = 2 * ArrayVoices::kStep; // of a buffer
constexpr int kUsualRate = 48000;
constexpr GstClockTime kPositionError = 50 * GST_MSECOND; // see begin_segment()
constexpr GstClockTime kFade = GST_SECOND / static_cast<int>(ArrayVoices::kSlew); // from 1 to 0

struct Settings : haptic::DriveSettings {
  std::string layout = "back-3x4";
  haptic::VoiceLimits limits = {.level = 1, .continuous_level = 0.5};
};

struct State {
  // Object lock: written by the application, read by the streaming thread.
  Settings settings;

  // From READY to PAUSED on, until stopped.
  haptic::ArrayLayout layout;
  std::unique_ptr<haptic::ArrayDrive> drive;

  // Lock of the pad `src`: a flush has come that the streaming thread has not followed.
  bool flushed = false;

  // Streaming thread only, or while it is stopped.
  std::unique_ptr<ArrayVoices> voices; // once the rate is known
  gint64 stopped = 0;                  // µs, monotonic; what was used of the budgets is kept
  bool warned = false;                 // of a damaged sample
  std::vector<double> amplitudes;
  haptic::MotionField field;
  bool is_field = false;   // of the caps
  int rate = 0;            // frames a second
  bool begins = true;      // nothing was made since the start or a flush
  GstSegment motion = {};  // of the newest motion; the sound has the same stream time
  GstClockTime origin = 0; // running time at which the segment begins
  guint64 frames_made = 0; // at this rate, from there on
  GstClockTime stale = 0;  // running time at which the newest motion is too old
  GstClockTime ends = 0;   // running time until which it lasts
  GstClockTime fades = GST_CLOCK_TIME_NONE;  // running time from which nothing is felt
  GstClockTime renews = GST_CLOCK_TIME_NONE; // running time from which another segment is due

  void begin_anew() {
    begins = true;
    motion = {};
    frames_made = 0;
    stale = 0;
    ends = 0;
    if (drive)
      drive->rest();
    if (voices)
      voices->restart();
  }
  GstClockTime time_of(guint64 frames) const {
    return gst_util_uint64_scale(frames, GST_SECOND, static_cast<guint64>(rate));
  }
  // Running time of the next frame, which is its time stamp too.
  GstClockTime now() const { return origin + time_of(frames_made); }
};

} // namespace

struct _GstHapticArray {
  GstAggregator parent;
  GstAggregatorPad *sink; // owned by the element
  State *state;           // made in _init, deleted in _finalize
};

static GstStaticPadTemplate sink_template =
    GST_STATIC_PAD_TEMPLATE("sink", GST_PAD_SINK, GST_PAD_ALWAYS,
                            GST_STATIC_CAPS(HAPTIC_MOTION_CAPS "; " HAPTIC_FIELD_CAPS));
static GstStaticPadTemplate src_template =
    GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(HAPTIC_ARRAY_CAPS));

G_DEFINE_TYPE_WITH_CODE(GstHapticArray, gst_haptic_array, GST_TYPE_AGGREGATOR,
                        GST_DEBUG_CATEGORY_INIT(hapticarray_debug, "hapticarray", 0,
                                                "motion on an array of actuators"))
GST_ELEMENT_REGISTER_DEFINE(hapticarray, "hapticarray", GST_RANK_NONE, gst_haptic_array_get_type())

namespace {

// Properties

std::span<const haptic::Property<Settings>> properties() {
  using haptic::MapChoice;
  using haptic::PointerPosition;
  using haptic::VoiceLimits;
  using Rows = haptic::Rows<Settings>;
  constexpr double kSteepest = 10; // s/px
  static const haptic::Property<Settings> table[] = {
      Rows::text<&Settings::layout>(
          "layout", "Layout",
          "Where the actuators are: back-3x4, ring-8, shakers-2, coils-2, or the path of a layout "
          "file. Takes effect at the next start"),
      Rows::choice<&Settings::map>(
          "map", "Map", "How a motion is spread over the array",
          haptic::register_enum<MapChoice>(
              "GstHapticArrayMap",
              {{MapChoice::stroke,
                "The motion at the pointer runs across the array in its direction", "stroke"},
               {MapChoice::field,
                "Each actuator vibrates with the motion at its place of the frame", "field"},
               {MapChoice::point,
                "The motion at the pointer is felt at the pointer's place on the array",
                "point"}})),
      Rows::number<&Settings::pointer, &PointerPosition::x>(
          "pointer-x", "Pointer X", "Pointer in a field, fraction of the frame's width", 0, 1),
      Rows::number<&Settings::pointer, &PointerPosition::y>(
          "pointer-y", "Pointer Y", "Pointer in a field, fraction of the frame's height", 0, 1),
      Rows::number<&Settings::alpha>(
          "alpha", "Alpha", "Steepness, s/px in a frame 352 wide: 1/alpha px/s give half of level",
          0, kSteepest),
      Rows::number<&Settings::limits, &VoiceLimits::level>(
          "level", "Level", "Highest amplitude of an actuator, of full scale", 0, 1),
      Rows::number<&Settings::limits, &VoiceLimits::continuous_level>(
          "continuous-level", "Continuous Level",
          "Amplitude that an actuator may keep up: rms over a minute, of full scale; 0: any", 0, 1),
  };
  return table;
}

Settings settings_of(GstHapticArray *self) {
  return haptic::locked_copy(self, self->state->settings);
}

// Motion in

// Takes over what a buffer says, from `time` (running time) on.
void follow(GstHapticArray *self, GstBuffer *buffer, GstClockTime time, const Settings &settings) {
  State &state = *self->state;
  const haptic::ReadableBuffer readable(buffer);
  if (!readable)
    return;
  guint64 interval = 0;
  const bool is_gap = GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP); // whatever its bytes say
  bool is_read = false;
  if (is_gap) {
    state.drive->rest();
  } else if (state.is_field) {
    is_read = haptic::unpack_motion_field(readable.bytes(), state.field);
    if (is_read) {
      interval = state.field.interval;
      state.drive->follow(state.field, settings);
    }
  } else if (const auto sample = haptic::unpack_motion_sample(readable.bytes())) {
    is_read = true;
    interval = sample->interval;
    state.drive->follow(*sample, settings);
  }
  if (!is_read && !is_gap) {
    if (!std::exchange(state.warned, true))
      GST_ELEMENT_WARNING(self, STREAM, DECODE, (haptic::messages::kArraySampleDamaged), (nullptr));
    state.drive->rest();
  }
  const double seconds = haptic::stale_after(static_cast<double>(interval) / GST_SECOND);
  const auto longest = static_cast<GstClockTime>(seconds * GST_SECOND);
  const guint64 lasts =
      GST_BUFFER_DURATION_IS_VALID(buffer) ? GST_BUFFER_DURATION(buffer) : interval;
  state.stale = time + longest;
  state.ends = time + std::min<guint64>(lasts, longest);
}

GstSegment segment_of(GstAggregatorPad *pad) {
  const ObjectLock lock(pad);
  return pad->segment;
}

// GstBaseSink 1.22 tells a position that is wrong by (1 - speed) times the length of the segment:
// it takes that length for stream time. So none is so long that it matters.
void begin_backwards(State &state, GstSegment &own, GstClockTime now) {
  const double speed = -own.applied_rate;
  const GstClockTime buffer = state.time_of(kFrames);
  const auto left = static_cast<GstClockTime>(static_cast<double>(own.time) / speed);
  const double wrong = std::abs(1 - speed);
  const GstClockTime longest =
      std::max(static_cast<GstClockTime>(kPositionError / std::max(wrong, 1e-6)), 2 * buffer);
  const GstClockTime end = now + left;
  state.fades = end - std::min(end, buffer + kFade);
  own.stop = now + std::min(left, longest);
  own.time -=
      std::min(own.time, static_cast<GstClockTime>(static_cast<double>(own.stop - now) * speed));
  if (own.stop < end)
    state.renews = own.stop - buffer;
}

// Gives the sound the stream time of the motion's segment from running time `now` on; its own time
// stamps are running time. Sound has no other rate than 1 and does not run backwards: the rate of a
// seek is that of the motion, which comes by running time.
void begin_segment(GstHapticArray *self, const GstSegment &motion, GstClockTime now) {
  State &state = *self->state;
  GstSegment own;
  gst_segment_init(&own, GST_FORMAT_TIME);
  own.applied_rate = motion.rate * motion.applied_rate;
  own.base = own.start = own.position = now;
  const guint64 position = gst_segment_position_from_running_time(&motion, GST_FORMAT_TIME, now);
  const guint64 time = gst_segment_to_stream_time(&motion, GST_FORMAT_TIME, position);
  own.time = GST_CLOCK_TIME_IS_VALID(time) ? time : 0;
  state.fades = GST_CLOCK_TIME_NONE;
  state.renews = GST_CLOCK_TIME_NONE;
  // Backwards, stream time is counted from the end, and sinks cut off what is behind it.
  if (own.applied_rate < 0)
    begin_backwards(state, own, now);
  state.motion = motion;
  state.origin = now;
  state.frames_made = 0;
  gst_aggregator_update_segment(GST_AGGREGATOR(self), &own);
}

bool is_same(const GstSegment &a, const GstSegment &b) {
  return a.rate == b.rate && a.applied_rate == b.applied_rate && a.start == b.start &&
         a.stop == b.stop && a.base == b.base && a.offset == b.offset && a.time == b.time;
}

// Follows all buffers up to the running time `now`. Returns whether a later one waits.
bool follow_until(GstHapticArray *self, GstClockTime now, const Settings &settings) {
  while (auto buffer = haptic::BufferPtr(gst_aggregator_pad_peek_buffer(self->sink))) {
    const GstSegment segment = segment_of(self->sink);
    const bool dated = segment.format == GST_FORMAT_TIME && GST_BUFFER_PTS_IS_VALID(buffer.get());
    const GstClockTime time = haptic::running_time_of(segment, GST_BUFFER_PTS(buffer.get()));
    if (GST_CLOCK_TIME_IS_VALID(time) && time > now)
      return true;
    gst_aggregator_pad_drop_buffer(self->sink);
    if (GST_CLOCK_TIME_IS_VALID(time) && !is_same(segment, self->state->motion))
      begin_segment(self, segment, now);
    if (GST_CLOCK_TIME_IS_VALID(time) || !dated)
      follow(self, buffer.get(), GST_CLOCK_TIME_IS_VALID(time) ? time : now, settings);
  }
  return false;
}

// Audio out

GstFlowReturn push_buffer(GstHapticArray *self, const Settings &settings) {
  State &state = *self->state;
  const std::size_t channels = state.layout.actuators.size();
  GstBuffer *out = gst_buffer_new_allocate(nullptr, kFrames * channels * sizeof(float), nullptr);
  GstMapInfo map;
  if (!gst_buffer_map(out, &map, GST_MAP_WRITE)) {
    gst_buffer_unref(out);
    return GST_FLOW_ERROR;
  }
  const std::span<float> frames{reinterpret_cast<float *>(map.data), kFrames * channels};
  const double dt = static_cast<double>(ArrayVoices::kStep) / state.rate;
  bool silent = true;
  for (std::size_t at = 0; at < frames.size(); at += ArrayVoices::kStep * channels) {
    silent = silent && state.voices->silent();
    state.drive->step(dt, settings, state.amplitudes);
    state.voices->make(state.amplitudes, settings.limits,
                       frames.subspan(at, ArrayVoices::kStep * channels));
  }
  silent = silent && state.voices->silent();
  gst_buffer_unmap(out, &map);
  GstAggregator *aggregator = GST_AGGREGATOR(self);
  GST_BUFFER_PTS(out) = state.now();
  GST_BUFFER_OFFSET(out) = state.frames_made;
  state.frames_made += kFrames;
  GST_BUFFER_OFFSET_END(out) = state.frames_made;
  GST_BUFFER_DURATION(out) = state.now() - GST_BUFFER_PTS(out);
  if (silent)
    GST_BUFFER_FLAG_SET(out, GST_BUFFER_FLAG_GAP);
  {
    const ObjectLock lock(aggregator->srcpad);
    if (!state.flushed)
      GST_AGGREGATOR_PAD(aggregator->srcpad)->segment.position = state.now();
  }
  const GstFlowReturn flow = gst_aggregator_finish_buffer(aggregator, out);
  // audioconvert, for one, accepts any number of channels and does not convert it.
  if (flow == GST_FLOW_NOT_NEGOTIATED)
    GST_ELEMENT_ERROR(self, CORE, NEGOTIATION,
                      (haptic::messages::kArrayChannels, static_cast<int>(channels)), (nullptr));
  return flow;
}

// The first frame is where the class put the position (property start-time-selection).
void begin(GstHapticArray *self) {
  const GstSegment own = segment_of(GST_AGGREGATOR_PAD(GST_AGGREGATOR(self)->srcpad));
  const GstClockTime first = gst_segment_to_running_time(&own, GST_FORMAT_TIME, own.position);
  GstSegment motion;
  gst_segment_init(&motion, GST_FORMAT_TIME);
  if (const haptic::BufferPtr buffer{gst_aggregator_pad_peek_buffer(self->sink)})
    if (const GstSegment its = segment_of(self->sink); its.format == GST_FORMAT_TIME)
      motion = its;
  begin_segment(self, motion, GST_CLOCK_TIME_IS_VALID(first) ? first : 0);
  self->state->begins = false;
}

bool take_flush(GstHapticArray *self) {
  const ObjectLock lock(GST_AGGREGATOR(self)->srcpad);
  return std::exchange(self->state->flushed, false);
}

GstFlowReturn aggregate(GstHapticArray *self, gboolean timeout) {
  State &state = *self->state;
  if (!state.voices)
    return GST_FLOW_NOT_NEGOTIATED;
  if (take_flush(self))
    state.begin_anew();
  if (state.begins)
    begin(self);
  const Settings settings = settings_of(self);
  const GstClockTime now = state.now();
  if (now > state.renews)
    begin_segment(self, GstSegment(state.motion), now);
  const bool more = follow_until(self, now, settings);
  const bool ended = gst_aggregator_pad_is_eos(self->sink);
  if (!more && !ended && !timeout)
    return GST_AGGREGATOR_FLOW_NEED_DATA;
  if (now >= std::min(state.fades, ended ? state.ends : state.stale))
    state.drive->rest();
  if (ended && now >= state.ends && state.voices->silent())
    return GST_FLOW_EOS;
  return push_buffer(self, settings);
}

// Caps

GstFlowReturn update_src_caps(GstHapticArray *self, GstCaps *wanted, GstCaps **caps) {
  const auto channels = static_cast<gint>(self->state->layout.actuators.size());
  haptic::CapsPtr own(gst_caps_copy(wanted));
  // Channels beyond a pair are no loudspeakers: they have no position.
  gst_caps_set_simple(own.get(), "channels", G_TYPE_INT, channels, nullptr);
  const guint64 mask = channels == 2 ? 3 : 0;
  gst_caps_set_simple(own.get(), "channel-mask", GST_TYPE_BITMASK, mask, nullptr);
  const haptic::CapsPtr peer(gst_pad_peer_query_caps(GST_AGGREGATOR(self)->srcpad, nullptr));
  *caps = gst_caps_intersect(own.get(), peer.get());
  if (!gst_caps_is_empty(*caps))
    return GST_FLOW_OK;
  GST_ELEMENT_ERROR(self, CORE, NEGOTIATION, (haptic::messages::kArrayChannels, channels),
                    ("%" GST_PTR_FORMAT, static_cast<void *>(peer.get())));
  return GST_FLOW_NOT_NEGOTIATED;
}

GstCaps *fixate(GstHapticArray *, GstCaps *caps) {
  haptic::CapsPtr made(gst_caps_make_writable(caps));
  gst_structure_fixate_field_nearest_int(gst_caps_get_structure(made.get(), 0), "rate", kUsualRate);
  return gst_caps_fixate(made.release());
}

gboolean on_caps(GstHapticArray *self, GstCaps *caps) {
  State &state = *self->state;
  gint rate = 0;
  if (!gst_structure_get_int(gst_caps_get_structure(caps, 0), "rate", &rate) || rate <= 0)
    return FALSE;
  if (!state.voices) {
    state.voices = std::make_unique<ArrayVoices>(state.layout, rate);
  } else if (rate != state.rate) {
    state.voices->set_rate(rate);
    if (state.rate > 0)
      state.frames_made = gst_util_uint64_scale(state.frames_made, static_cast<guint64>(rate),
                                                static_cast<guint64>(state.rate));
  }
  state.rate = rate;
  const GstClockTime latency = state.time_of(kFrames);
  gst_aggregator_set_latency(GST_AGGREGATOR(self), latency, latency);
  return TRUE;
}

// States and events

gboolean start(GstHapticArray *self) {
  State &state = *self->state;
  try {
    haptic::ArrayLayout layout = haptic::load_array_layout(settings_of(self).layout);
    if (layout != state.layout)
      state.voices.reset(); // other actuators
    state.layout = std::move(layout);
  } catch (const std::runtime_error &error) {
    GST_ELEMENT_ERROR(self, RESOURCE, SETTINGS, ("%s", error.what()), (nullptr));
    return FALSE;
  }
  state.drive = std::make_unique<haptic::ArrayDrive>(state.layout);
  state.amplitudes.assign(state.layout.actuators.size(), 0);
  state.rate = 0;
  state.flushed = false;
  state.warned = false;
  if (state.voices)
    state.voices->restart(static_cast<double>(g_get_monotonic_time() - state.stopped) * 1e-6);
  state.begin_anew();
  return TRUE;
}

gboolean stop(GstHapticArray *self) {
  self->state->stopped = g_get_monotonic_time();
  return TRUE;
}

// The thread of the sink pad: the streaming thread may be at work.
GstFlowReturn flush(GstHapticArray *self) {
  GstAggregatorPad *pad = GST_AGGREGATOR_PAD(GST_AGGREGATOR(self)->srcpad);
  const ObjectLock lock(pad);
  self->state->flushed = true;
  pad->segment.position = GST_CLOCK_TIME_NONE;
  return GST_FLOW_OK;
}

// After a seek that does not flush, the class would change the segment of the sound at once, before
// the motion that belongs to it comes.
bool is_for_motion_alone(GstEvent *event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_SEEK)
    return false;
  GstSeekFlags flags = GST_SEEK_FLAG_NONE;
  gst_event_parse_seek(event, nullptr, nullptr, &flags, nullptr, nullptr, nullptr, nullptr);
  return !(flags & GST_SEEK_FLAG_FLUSH);
}

void on_sink_event(GstHapticArray *self, GstEvent *event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_CAPS)
    return;
  GstCaps *caps = nullptr;
  gst_event_parse_caps(event, &caps);
  const gchar *layout = gst_structure_get_string(gst_caps_get_structure(caps, 0), "layout");
  State &state = *self->state;
  state.is_field = g_strcmp0(layout, "field") == 0;
  if (!state.is_field && settings_of(self).map == haptic::MapChoice::field)
    GST_ELEMENT_WARNING(self, STREAM, FORMAT, (haptic::messages::kArrayNeedsField), (nullptr));
}

} // namespace

static void gst_haptic_array_class_init(GstHapticArrayClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  haptic::describe(element_class, "hapticarray", "Haptic array", "Filter/Converter/Haptics",
                   "Makes motion felt on an array of actuators");
  gst_element_class_add_static_pad_template_with_gtype(element_class, &sink_template,
                                                       GST_TYPE_AGGREGATOR_PAD);
  gst_element_class_add_static_pad_template_with_gtype(element_class, &src_template,
                                                       GST_TYPE_AGGREGATOR_PAD);
  auto *object_class = G_OBJECT_CLASS(klass);
  object_class->finalize = haptic::delete_state<GstHapticArray, gst_haptic_array_parent_class>;
  haptic::install_properties<properties>(object_class, [](GObject *object) -> Settings & {
    return GST_HAPTIC_ARRAY(object)->state->settings;
  });

  auto *aggregator_class = GST_AGGREGATOR_CLASS(klass);
  aggregator_class->start = kGuarded<start>;
  aggregator_class->stop = kGuarded<stop>;
  aggregator_class->flush = kGuarded<flush>;
  aggregator_class->sink_event = [](GstAggregator *aggregator, GstAggregatorPad *pad,
                                    GstEvent *event) {
    guarded(aggregator, [&] { on_sink_event(GST_HAPTIC_ARRAY(aggregator), event); });
    return GST_AGGREGATOR_CLASS(gst_haptic_array_parent_class)->sink_event(aggregator, pad, event);
  };
  aggregator_class->src_event = [](GstAggregator *aggregator, GstEvent *event) -> gboolean {
    if (guarded(aggregator, FALSE, [&] { return is_for_motion_alone(event); }))
      return gst_pad_push_event(GST_PAD(GST_HAPTIC_ARRAY(aggregator)->sink), event);
    return GST_AGGREGATOR_CLASS(gst_haptic_array_parent_class)->src_event(aggregator, event);
  };
  // The class says of every aggregator that it cannot be sought in.
  aggregator_class->src_query = [](GstAggregator *aggregator, GstQuery *query) -> gboolean {
    if (GST_QUERY_TYPE(query) == GST_QUERY_SEEKING)
      return gst_pad_peer_query(GST_PAD(GST_HAPTIC_ARRAY(aggregator)->sink), query);
    return GST_AGGREGATOR_CLASS(gst_haptic_array_parent_class)->src_query(aggregator, query);
  };
  aggregator_class->update_src_caps = kGuarded<update_src_caps>;
  aggregator_class->fixate_src_caps = kGuarded<fixate>;
  aggregator_class->negotiated_src_caps = kGuarded<on_caps>;
  aggregator_class->get_next_time = gst_aggregator_simple_get_next_time;
  aggregator_class->aggregate = kGuarded<aggregate>;
}

static void gst_haptic_array_init(GstHapticArray *self) {
  self->state = new State;
  GstPadTemplate *pad_template =
      gst_element_class_get_pad_template(GST_ELEMENT_GET_CLASS(self), "sink");
  self->sink = GST_AGGREGATOR_PAD(g_object_new(GST_TYPE_AGGREGATOR_PAD, "name", "sink", "direction",
                                               GST_PAD_SINK, "template", pad_template, nullptr));
  gst_element_add_pad(GST_ELEMENT(self), GST_PAD(self->sink));
}
