// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-hapticconvert
 *
 * Converts a haptic track between its forms. See docs/elements/hapticconvert.md.
 */
#include "gsthapticconvert.h"

#include "exception-barrier.hpp"
#include "field-codec.hpp"
#include "gst-raii.hpp"
#include "hmpg-track.hpp"
#include "klv.hpp"
#include "text-line.hpp"
#include "track-caps.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <memory>
#include <string>
#include <utility>

GST_DEBUG_CATEGORY_STATIC(haptic_convert_debug);
#define GST_CAT_DEFAULT haptic_convert_debug

namespace {

using haptic::BufferPtr;
using haptic::CapsPtr;
using haptic::guarded;
using haptic::ObjectLock;
using haptic::TrackSample;

enum PropertyId : guint { kUnitDuration = 1, kStats };

constexpr guint kDefaultUnitDuration = 100; // ms
constexpr guint kLongestUnitDuration = 4000;
// The sender's times run on, or it was started anew.
constexpr GstClockTime kLargestStep = 10 * GST_SECOND;

enum class Form { raw, klv, text, hmpg };

constexpr std::array<std::pair<Form, const char *>, 4> kForms = {{
    {Form::raw, "haptics/x-raw"},
    {Form::klv, "meta/x-klv"},
    {Form::text, "text/x-raw"},
    {Form::hmpg, "haptics/hmpg"},
}};

Form form_of(const GstCaps *caps) {
  const GstStructure *structure = gst_caps_get_structure(caps, 0);
  for (const auto &[form, name] : kForms)
    if (gst_structure_has_name(structure, name))
      return form;
  return Form::raw;
}

// What a sample of the track is of.
enum class Layout { point, field };

constexpr const char *layout_name(Layout layout) {
  return layout == Layout::field ? "field" : "point";
}

Layout layout_of(const GstStructure *structure) {
  const char *name = gst_structure_get_string(structure, "layout");
  return name && g_str_equal(name, "field") ? Layout::field : Layout::point;
}

// Things that go wrong in streams; each is told once and then counted.
enum Trouble { kDamaged, kForeign, kOtherVersion, kOtherKind, kNoTimes, kMissing, kTroubles };

struct Item {
  TrackSample sample;
  GstClockTime pts = GST_CLOCK_TIME_NONE;
};

struct State {
  // Object lock.
  guint unit_duration = kDefaultUnitDuration; // ms

  // Read by anybody.
  std::atomic<guint64> samples = 0;
  std::array<std::atomic<guint64>, kTroubles> troubles{};

  // Streaming thread only, or while it is stopped.
  Form in = Form::raw;
  Form out = Form::raw;
  Layout layout = Layout::point; // of the samples that come
  bool failed = false;           // an error was posted
  std::deque<BufferPtr> ready;
  std::unique_ptr<haptic::HmpgEncoder> encoder;
  haptic::HmpgDecoder decoder;
  haptic::FieldEncoder field_encoder;
  haptic::FieldDecoder field_decoder;
  haptic::MotionField field; // that came; kept for its memory
  std::array<bool, kTroubles> told{};
  bool discont = true;
  bool begun = false; // a sample has come since the start or the last flush
  GstClockTime last_pts = GST_CLOCK_TIME_NONE;
  GstClockTime last_time = GST_CLOCK_TIME_NONE; // the sender's
  GstClockTime last_duration = 0;
};

} // namespace

struct _GstHapticConvert {
  GstBaseTransform parent;
  State *state; // made in _init, deleted in _finalize
};

#define ALL_FORMS(text_formats)                                                                    \
  HAPTIC_MOTION_CAPS "; " HAPTIC_FIELD_CAPS "; " HAPTIC_KLV_CAPS                                   \
                     "; text/x-raw, format=(string)" text_formats "; " HAPTIC_HMPG_CAPS
static GstStaticPadTemplate sink_template = GST_STATIC_PAD_TEMPLATE(
    "sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS(ALL_FORMS("{ utf8, pango-markup }")));
static GstStaticPadTemplate src_template =
    GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(ALL_FORMS("utf8")));

G_DEFINE_TYPE_WITH_CODE(GstHapticConvert, gst_haptic_convert, GST_TYPE_BASE_TRANSFORM,
                        GST_DEBUG_CATEGORY_INIT(haptic_convert_debug, "hapticconvert", 0,
                                                "forms of a haptic track"))
GST_ELEMENT_REGISTER_DEFINE(hapticconvert, "hapticconvert", GST_RANK_NONE, GST_TYPE_HAPTIC_CONVERT)

namespace {

State &state_of(gpointer object) {
  return *GST_HAPTIC_CONVERT(object)->state;
}

GstBaseTransformClass *parent_class() {
  return GST_BASE_TRANSFORM_CLASS(gst_haptic_convert_parent_class);
}

// ---- caps ---------------------------------------------------------------------------------------

// A field becomes no point, nor MPEG haptics, which is of one point.
bool go_together(const GstStructure *one, const GstStructure *other) {
  const auto is_field = [](const GstStructure *structure) {
    return layout_of(structure) == Layout::field;
  };
  const auto holds_points_only = [&](const GstStructure *structure) {
    return gst_structure_has_name(structure, "haptics/hmpg") ||
           (gst_structure_has_name(structure, "haptics/x-raw") && !is_field(structure));
  };
  return !(is_field(one) && holds_points_only(other)) &&
         !(is_field(other) && holds_points_only(one));
}

// Everything that one structure can become, the plain samples first.
CapsPtr other_side(GstPadDirection from, const GstCaps *caps) {
  CapsPtr result(gst_caps_new_empty());
  for (guint i = 0; i < gst_caps_get_size(caps); ++i) {
    const GstStructure *structure = gst_caps_get_structure(caps, i);
    CapsPtr all(
        gst_static_pad_template_get_caps(from == GST_PAD_SINK ? &src_template : &sink_template));
    all.reset(gst_caps_make_writable(all.release()));
    for (guint j = gst_caps_get_size(all.get()); j-- > 0;) {
      GstStructure *other = gst_caps_get_structure(all.get(), j);
      if (!go_together(structure, other)) {
        gst_caps_remove_structure(all.get(), j);
        continue;
      }
      const bool same = gst_structure_has_name(structure, gst_structure_get_name(other));
      if (same && gst_structure_has_name(other, "haptics/x-raw"))
        for (const char *field : {"width", "height", "pixel-aspect-ratio", "framerate"})
          if (const GValue *value = gst_structure_get_value(structure, field))
            gst_structure_set_value(other, field, value);
      if (gst_structure_has_name(other, "haptics/hmpg")) {
        if (!same && from == GST_PAD_SINK)
          gst_structure_set(other, "rate", G_TYPE_INT, static_cast<gint>(haptic::kTrackTimescale),
                            nullptr);
        else if (const GValue *rate = gst_structure_get_value(structure, "rate"); same && rate)
          gst_structure_set_value(other, "rate", rate);
      }
    }
    result.reset(gst_caps_merge(result.release(), all.release()));
  }
  return result;
}

GstCaps *transform_caps(GstPadDirection direction, GstCaps *caps, GstCaps *filter) {
  CapsPtr result = other_side(direction, caps);
  if (filter)
    result.reset(gst_caps_intersect_full(filter, result.get(), GST_CAPS_INTERSECT_FIRST));
  return result.release();
}

// Whether a file holds points or fields is known only from its samples: what came last is expected.
GstCaps *fixate_caps(GstHapticConvert *self, GstPadDirection direction, GstCaps *othercaps) {
  CapsPtr caps(othercaps);
  const GstStructure *first = gst_caps_get_structure(caps.get(), 0);
  if (direction == GST_PAD_SINK && gst_structure_has_name(first, "haptics/x-raw"))
    for (guint i = 0; i < gst_caps_get_size(caps.get()); ++i)
      if (const GstStructure *structure = gst_caps_get_structure(caps.get(), i);
          gst_structure_has_name(structure, "haptics/x-raw") &&
          layout_of(structure) == self->state->layout) {
        caps.reset(gst_caps_copy_nth(caps.get(), i));
        break;
      }
  return gst_caps_fixate(caps.release());
}

// ---- troubles -----------------------------------------------------------------------------------

void tell(GstHapticConvert *self, Trouble trouble, const char *text, const std::string &details) {
  State &state = *self->state;
  ++state.troubles[trouble];
  GST_DEBUG_OBJECT(self, "%s (%s)", text, details.c_str());
  if (!std::exchange(state.told[trouble], true))
    GST_ELEMENT_WARNING(self, STREAM, FORMAT, ("%s", text), ("%s", details.c_str()));
}

void tell_damage(GstHapticConvert *self, const std::string &details) {
  tell(self, kDamaged,
       "A part of the haptic track is damaged and was left out. Further parts are only counted "
       "(stats).",
       details);
}

// ---- time ---------------------------------------------------------------------------------------

// The time stamp of a sample whose buffer lost it (some remuxers drop them): where the sender's
// time leads from the last sample of which both were known, or from the beginning of the segment.
GstClockTime recovered_time(GstHapticConvert *self, const TrackSample &sample) {
  State &state = *self->state;
  if (sample.time == haptic::kNoTime)
    return GST_CLOCK_TIME_NONE;
  tell(self, kNoTimes,
       "The haptic track has lost its time stamps. The times inside of its samples are used; they "
       "may differ from the video's by a constant.",
       "no PTS");
  if (!GST_CLOCK_TIME_IS_VALID(state.last_pts)) {
    const GstSegment &segment = GST_BASE_TRANSFORM(self)->segment;
    return segment.format == GST_FORMAT_TIME && segment.rate > 0 ? segment.start : 0;
  }
  const guint64 forward = sample.time - state.last_time;
  const guint64 back = state.last_time - sample.time;
  if (GST_CLOCK_TIME_IS_VALID(state.last_time) && forward <= kLargestStep)
    return state.last_pts + forward;
  if (GST_CLOCK_TIME_IS_VALID(state.last_time) && back <= std::min(kLargestStep, state.last_pts))
    return state.last_pts - back;
  return state.last_pts + state.last_duration; // the sender was started anew
}

void remember_time(State &state, const Item &item) {
  if (!GST_CLOCK_TIME_IS_VALID(item.pts))
    return;
  state.last_pts = item.pts;
  state.last_time = item.sample.time;
  state.last_duration = item.sample.duration == haptic::kNoTime
                            ? 0
                            : std::min<GstClockTime>(item.sample.duration, GST_SECOND);
}

// ---- layout -------------------------------------------------------------------------------------

void push_what_is_left(GstBaseTransform *trans);

void refuse_layout(GstHapticConvert *self, const char *what_follows) {
  if (!std::exchange(self->state->failed, true))
    GST_ELEMENT_ERROR(
        self, STREAM, WRONG_TYPE,
        ("The haptic track holds motion %s, but %s.",
         self->state->layout == Layout::field ? "fields of the whole frame" : "of one point",
         what_follows),
        ("layout=%s", layout_name(self->state->layout)));
}

// Samples of this layout follow. False, with an error posted, if they cannot go on.
bool take_layout(GstHapticConvert *self, Layout layout) {
  State &state = *self->state;
  if (state.layout == layout)
    return !state.failed;
  auto *trans = GST_BASE_TRANSFORM(self);
  push_what_is_left(trans);
  state.layout = layout;
  if (state.out == Form::hmpg && layout == Layout::field) {
    refuse_layout(self,
                  "MPEG haptics can hold the motion of one point only; convert to KLV or text");
  } else if (state.out == Form::raw) {
    CapsPtr caps(gst_pad_get_current_caps(GST_BASE_TRANSFORM_SRC_PAD(trans)));
    caps.reset(gst_caps_make_writable(caps.release()));
    gst_caps_set_simple(caps.get(), "layout", G_TYPE_STRING, layout_name(layout), nullptr);
    const CapsPtr taken(gst_pad_peer_query_caps(GST_BASE_TRANSFORM_SRC_PAD(trans), nullptr));
    if (!gst_caps_can_intersect(taken.get(), caps.get()) ||
        !gst_base_transform_update_src_caps(trans, caps.get()))
      refuse_layout(self, "what follows hapticconvert does not take them");
  }
  return !state.failed;
}

// ---- out ----------------------------------------------------------------------------------------

BufferPtr make_buffer(const void *bytes, std::size_t size, GstClockTime pts,
                      GstClockTime duration) {
  BufferPtr buffer(gst_buffer_new_allocate(nullptr, size, nullptr));
  gst_buffer_fill(buffer.get(), 0, bytes, size);
  GST_BUFFER_PTS(buffer.get()) = pts;
  GST_BUFFER_DURATION(buffer.get()) = duration;
  return buffer;
}

void take_units(State &state, const std::vector<haptic::CodedUnit> &units) {
  for (const auto &unit : units) {
    BufferPtr buffer = make_buffer(unit.bytes.data(), unit.bytes.size(), unit.time, unit.duration);
    if (unit.type == haptic::UnitType::initialization)
      GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_HEADER);
    state.ready.push_back(std::move(buffer));
  }
}

std::string today() {
  GDateTime *now = g_date_time_new_now_utc();
  const haptic::GCharPtr text(g_date_time_format(now, "%Y-%m-%d"));
  g_date_time_unref(now);
  return text.get();
}

void encode_units(GstHapticConvert *self, const Item &item) {
  State &state = *self->state;
  if (!GST_CLOCK_TIME_IS_VALID(item.pts))
    return tell_damage(self, "a sample without a time has no place in haptics/hmpg");
  if (!state.encoder) {
    guint unit_duration = 0;
    {
      const ObjectLock lock(self);
      unit_duration = state.unit_duration;
    }
    state.encoder = std::make_unique<haptic::HmpgEncoder>(unit_duration * GST_MSECOND, today());
  }
  take_units(state, state.encoder->push(item.sample.motion, item.pts, item.sample.duration));
}

void send(State &state, BufferPtr buffer) {
  if (std::exchange(state.discont, false))
    GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_DISCONT);
  state.ready.push_back(std::move(buffer));
}

void encode(GstHapticConvert *self, const Item &item) {
  if (!take_layout(self, Layout::point))
    return;
  State &state = *self->state;
  state.begun = true;
  ++state.samples;
  const GstClockTime duration = item.sample.duration;
  BufferPtr buffer;
  switch (state.out) {
  case Form::raw: {
    const auto bytes = haptic::pack_motion_sample(item.sample.motion);
    buffer = make_buffer(bytes.data(), bytes.size(), item.pts, duration);
    if (!(item.sample.motion.confidence > 0))
      GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_GAP);
    break;
  }
  case Form::klv: {
    const auto bytes = haptic::write_klv(item.sample);
    buffer = make_buffer(bytes.data(), bytes.size(), item.pts, duration);
    break;
  }
  case Form::text: {
    const auto text = haptic::write_text_line(item.sample);
    buffer = make_buffer(text.data(), text.size(), item.pts, duration);
    break;
  }
  case Form::hmpg:
    return encode_units(self, item);
  }
  send(state, std::move(buffer));
}

// A field as its code travels.
void send_coded(State &state, const haptic::CodedField &coded, GstClockTime pts,
                GstClockTime duration) {
  BufferPtr buffer;
  if (state.out == Form::klv) {
    const auto bytes = haptic::write_klv(coded);
    buffer = make_buffer(bytes.data(), bytes.size(), pts, duration);
  } else {
    const auto text = haptic::write_text_line(coded);
    buffer = make_buffer(text.data(), text.size(), pts, duration);
  }
  if (!haptic::is_key_field(coded.bytes))
    GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_DELTA_UNIT);
  send(state, std::move(buffer));
}

void send_field(State &state, const haptic::MotionField &field, GstClockTime pts,
                GstClockTime duration) {
  BufferPtr buffer(gst_buffer_new_allocate(nullptr, haptic::packed_size(field), nullptr));
  GstMapInfo map;
  if (!gst_buffer_map(buffer.get(), &map, GST_MAP_WRITE))
    return;
  haptic::pack_motion_field(field, {map.data, map.size});
  gst_buffer_unmap(buffer.get(), &map);
  GST_BUFFER_PTS(buffer.get()) = pts;
  GST_BUFFER_DURATION(buffer.get()) = duration;
  if (std::ranges::none_of(field.cells, [](const auto &cell) { return cell.confidence > 0; }))
    GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_GAP);
  send(state, std::move(buffer));
}

void encode_field(GstHapticConvert *self, GstBuffer *buffer) {
  State &state = *self->state;
  state.begun = true;
  ++state.samples;
  const GstClockTime pts = GST_BUFFER_PTS(buffer);
  const GstClockTime duration = GST_BUFFER_DURATION(buffer);
  auto bytes = state.field_encoder.push(state.field);
  if (!bytes) { // it rests, and a muxer must not wait for it
    if (GST_CLOCK_TIME_IS_VALID(pts))
      gst_pad_push_event(GST_BASE_TRANSFORM_SRC_PAD(self), gst_event_new_gap(pts, duration));
    return;
  }
  haptic::CodedField coded{std::move(*bytes)};
  coded.time = gst_segment_to_stream_time(&GST_BASE_TRANSFORM(self)->segment, GST_FORMAT_TIME, pts);
  // The interval stands in the code, to the microsecond.
  const auto apart = static_cast<GstClockTimeDiff>(duration - state.field.interval);
  if (std::abs(apart) > static_cast<GstClockTimeDiff>(GST_USECOND))
    coded.duration = duration;
  send_coded(state, coded, pts, duration);
}

void finish_units(State &state) {
  if (state.encoder)
    take_units(state, state.encoder->finish());
}

// ---- in -----------------------------------------------------------------------------------------

void decode_raw_field(GstHapticConvert *self, GstBuffer *buffer,
                      std::span<const std::uint8_t> bytes) {
  State &state = *self->state;
  const bool gap = GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP);
  if (!haptic::unpack_motion_field(bytes, state.field)) {
    if (!gap)
      tell_damage(self, "a motion field that does not say what it is");
    return;
  }
  if (gap)
    std::ranges::fill(state.field.cells, haptic::FieldCell{});
  if (GST_BUFFER_IS_DISCONT(buffer))
    state.field_encoder.restart();
  encode_field(self, buffer);
}

void decode_raw(GstHapticConvert *self, GstBuffer *buffer, std::span<const std::uint8_t> bytes) {
  if (self->state->layout == Layout::field)
    return decode_raw_field(self, buffer, bytes);
  const auto motion = haptic::unpack_motion_sample(bytes);
  const bool gap = GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP);
  if (!motion) {
    if (!gap)
      tell_damage(self, "a motion sample that does not say what it is");
    return;
  }
  Item item;
  item.sample.motion = *motion;
  if (gap)
    item.sample.motion.confidence = 0;
  item.pts = GST_BUFFER_PTS(buffer);
  item.sample.time =
      gst_segment_to_stream_time(&GST_BASE_TRANSFORM(self)->segment, GST_FORMAT_TIME, item.pts);
  item.sample.duration = GST_BUFFER_DURATION(buffer);
  encode(self, item);
}

// A sample that came with the time stamp of its buffer, or without one.
void take_sample(GstHapticConvert *self, const TrackSample &sample, GstClockTime pts) {
  Item item;
  item.sample = sample;
  item.pts = GST_CLOCK_TIME_IS_VALID(pts) ? pts : recovered_time(self, sample);
  remember_time(*self->state, item);
  encode(self, item);
}

void decode_field(GstHapticConvert *self, const haptic::CodedField &coded, GstClockTime pts) {
  using Result = haptic::FieldDecoder::Result;
  State &state = *self->state;
  haptic::FieldDecoder &decoder = state.field_decoder;
  const Result result = decoder.push(coded.bytes);
  if (result == Result::missing)
    tell(
        self, kMissing,
        "A part of the motion fields was lost; they are silent until the next key sample, a second "
        "at most.",
        "a sequence number is missing");
  if (result == Result::damaged)
    tell_damage(self, "a motion field that contradicts itself");
  if (!decoder.has_field())
    return;
  const GstClockTime interval = decoder.field().interval;
  if (decoder.rested() && GST_CLOCK_TIME_IS_VALID(pts) && pts >= interval)
    send_field(state, decoder.rest(), pts - interval, interval);
  ++state.samples;
  send_field(state, decoder.field(), pts,
             coded.duration == haptic::kNoTime && interval > 0 ? interval : coded.duration);
}

// A field that came with the time stamp of its buffer, or without one.
void take_field(GstHapticConvert *self, const haptic::CodedField &coded, GstClockTime pts,
                GstClockTime duration) {
  if (!take_layout(self, Layout::field))
    return;
  State &state = *self->state;
  state.begun = true;
  Item item; // for its times
  item.sample.time = coded.time;
  item.sample.duration = coded.duration;
  item.pts = GST_CLOCK_TIME_IS_VALID(pts) ? pts : recovered_time(self, item.sample);
  remember_time(state, item);
  if (state.out == Form::raw)
    return decode_field(self, coded, item.pts);
  ++state.samples;
  send_coded(state, coded, item.pts, duration);
}

void decode_klv(GstHapticConvert *self, GstClockTime pts, GstClockTime duration,
                std::span<const std::uint8_t> bytes) {
  haptic::KlvReader reader(bytes);
  const auto place = [](const haptic::KlvItem &item) {
    return std::string(item.error) + " (byte " + std::to_string(item.offset) + ")";
  };
  std::uint64_t first_time = haptic::kNoTime;
  while (const auto item = reader.next()) {
    switch (item->kind) {
    case haptic::KlvKind::motion:
    case haptic::KlvKind::field: {
      // Only the first sample of a packet has the packet's time stamp.
      GstClockTime time = pts;
      if (first_time == haptic::kNoTime)
        first_time = item->sample.time;
      else if (GST_CLOCK_TIME_IS_VALID(pts) && item->sample.time != haptic::kNoTime &&
               item->sample.time >= first_time)
        time = pts + std::min<GstClockTime>(item->sample.time - first_time, kLargestStep);
      if (item->kind == haptic::KlvKind::field)
        take_field(
            self,
            {{item->field.begin(), item->field.end()}, item->sample.time, item->sample.duration},
            time, duration);
      else
        take_sample(self, item->sample, time);
      break;
    }
    case haptic::KlvKind::damaged:
      tell_damage(self, place(*item));
      break;
    case haptic::KlvKind::foreign:
      tell(self, kForeign,
           "There is KLV of other origin in this stream; it was passed over. If nothing is felt, "
           "this is not a haptic track.",
           place(*item));
      break;
    case haptic::KlvKind::other_version:
      tell(self, kOtherVersion,
           "The haptic track was written by a later version; what this one does not know is left "
           "out. Update this machine.",
           place(*item));
      break;
    case haptic::KlvKind::other_sample:
      tell(self, kOtherKind,
           "The haptic track has samples of a kind that this version does not know; they were "
           "left out. Update this machine.",
           place(*item));
      break;
    }
  }
}

void decode_text(GstHapticConvert *self, GstClockTime pts, GstClockTime duration,
                 std::string_view text) {
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.find_first_not_of(std::string_view(" \r\0", 3)) == std::string_view::npos)
      continue;
    const auto read = haptic::read_text_line(line);
    if (read.sample)
      take_sample(self, *read.sample, pts);
    else if (read.field)
      take_field(self, *read.field, pts, duration);
    else
      tell(self, kForeign,
           "There is text in this stream that is not a haptic track; it was passed over.",
           read.error);
    pts = GST_CLOCK_TIME_NONE;
  }
}

void decode_unit(GstHapticConvert *self, GstClockTime pts, std::span<const std::uint8_t> bytes) {
  auto result = self->state->decoder.push(bytes, pts);
  if (!result.problem.empty())
    tell_damage(self, result.problem);
  for (auto &sample : result.samples) {
    Item item;
    item.pts = std::exchange(sample.time, haptic::kNoTime);
    item.sample = sample;
    item.sample.time =
        gst_segment_to_stream_time(&GST_BASE_TRANSFORM(self)->segment, GST_FORMAT_TIME, item.pts);
    remember_time(*self->state, item);
    encode(self, item);
  }
}

void process(GstHapticConvert *self, GstBuffer *buffer) {
  State &state = *self->state;
  if (GST_BUFFER_IS_DISCONT(buffer))
    state.discont = true;
  GstMapInfo map;
  if (!gst_buffer_map(buffer, &map, GST_MAP_READ))
    return tell_damage(self, "a buffer that cannot be read");
  const std::span<const std::uint8_t> bytes(map.data, map.size);
  const GstClockTime pts = GST_BUFFER_PTS(buffer);
  switch (state.in) {
  case Form::raw:
    decode_raw(self, buffer, bytes);
    break;
  case Form::klv:
    decode_klv(self, pts, GST_BUFFER_DURATION(buffer), bytes);
    break;
  case Form::text:
    decode_text(self, pts, GST_BUFFER_DURATION(buffer),
                {reinterpret_cast<const char *>(map.data), map.size});
    break;
  case Form::hmpg:
    decode_unit(self, pts, bytes);
    break;
  }
  gst_buffer_unmap(buffer, &map);
}

GstFlowReturn generate_output(GstBaseTransform *trans, GstBuffer **out) {
  if (gst_base_transform_is_passthrough(trans))
    return parent_class()->generate_output(trans, out);
  State &state = state_of(trans);
  if (trans->queued_buf) {
    const BufferPtr buffer(std::exchange(trans->queued_buf, nullptr));
    process(GST_HAPTIC_CONVERT(trans), buffer.get());
  }
  if (state.failed)
    return GST_FLOW_NOT_NEGOTIATED;
  *out = nullptr;
  if (!state.ready.empty()) {
    *out = state.ready.front().release();
    state.ready.pop_front();
  }
  return GST_FLOW_OK;
}

// ---- events and queries -------------------------------------------------------------------------

void push_what_is_left(GstBaseTransform *trans) {
  State &state = state_of(trans);
  finish_units(state);
  while (!state.ready.empty()) {
    GstBuffer *buffer = state.ready.front().release();
    state.ready.pop_front();
    if (gst_pad_push(GST_BASE_TRANSFORM_SRC_PAD(trans), buffer) != GST_FLOW_OK)
      state.ready.clear();
  }
}

void forget_stream(State &state) {
  state.ready.clear();
  state.encoder.reset();
  state.decoder.seek();
  state.field_encoder.restart();
  state.field_decoder.forget();
  state.discont = true;
  state.begun = false;
}

// A demuxer sends gap events when its other streams run ahead, so that nobody waits for the first
// buffer. A track says by samples of its own where nothing was measured.
bool is_false_gap(const State &state) {
  return state.in != Form::raw && state.begun;
}

gboolean sink_event(GstBaseTransform *trans, GstEvent *event) {
  State &state = state_of(trans);
  switch (GST_EVENT_TYPE(event)) {
  case GST_EVENT_EOS:
  case GST_EVENT_SEGMENT:
  case GST_EVENT_CAPS:
    push_what_is_left(trans);
    break;
  case GST_EVENT_FLUSH_STOP:
    forget_stream(state);
    break;
  case GST_EVENT_STREAM_START:
    state.last_pts = state.last_time = GST_CLOCK_TIME_NONE;
    break;
  case GST_EVENT_GAP:
    if (is_false_gap(state)) {
      gst_event_unref(event);
      return TRUE;
    }
    break;
  default:
    break;
  }
  return parent_class()->sink_event(trans, event);
}

// A unit is known only when it is over.
gboolean query(GstBaseTransform *trans, GstPadDirection direction, GstQuery *query) {
  const gboolean done = parent_class()->query(trans, direction, query);
  State &state = state_of(trans);
  if (!done || direction != GST_PAD_SRC || GST_QUERY_TYPE(query) != GST_QUERY_LATENCY)
    return done;
  if (state.out != Form::hmpg || state.in == Form::hmpg)
    return done;
  gboolean live = FALSE;
  GstClockTime least = 0;
  GstClockTime most = GST_CLOCK_TIME_NONE;
  gst_query_parse_latency(query, &live, &least, &most);
  const ObjectLock lock(trans);
  const GstClockTime held = state.unit_duration * GST_MSECOND;
  gst_query_set_latency(query, live, least + held,
                        GST_CLOCK_TIME_IS_VALID(most) ? most + held : most);
  return TRUE;
}

gboolean set_caps(GstBaseTransform *trans, GstCaps *in, GstCaps *out) {
  State &state = state_of(trans);
  state.in = form_of(in);
  state.out = form_of(out);
  if (state.in == Form::raw)
    state.layout = layout_of(gst_caps_get_structure(in, 0));
  else if (state.in == Form::hmpg)
    state.layout = Layout::point;
  forget_stream(state);
  return TRUE;
}

gboolean start(GstBaseTransform *trans) {
  State &state = state_of(trans);
  forget_stream(state);
  state.decoder.forget();
  state.told = {};
  state.failed = false;
  state.samples = 0;
  for (auto &count : state.troubles)
    count = 0;
  state.last_pts = state.last_time = GST_CLOCK_TIME_NONE;
  state.last_duration = 0;
  return TRUE;
}

// ---- properties ---------------------------------------------------------------------------------

haptic::StructurePtr make_stats(const State &state) {
  return haptic::StructurePtr(
      gst_structure_new("hapticconvert-stats",                                                //
                        "samples", G_TYPE_UINT64, state.samples.load(),                       //
                        "damaged", G_TYPE_UINT64, state.troubles[kDamaged].load(),            //
                        "foreign", G_TYPE_UINT64, state.troubles[kForeign].load(),            //
                        "other-version", G_TYPE_UINT64, state.troubles[kOtherVersion].load(), //
                        "other-kind", G_TYPE_UINT64, state.troubles[kOtherKind].load(),       //
                        "without-time", G_TYPE_UINT64, state.troubles[kNoTimes].load(),       //
                        "missing", G_TYPE_UINT64, state.troubles[kMissing].load(), nullptr));
}

} // namespace

static void gst_haptic_convert_set_property(GObject *object, guint id, const GValue *value,
                                            GParamSpec *pspec) {
  const ObjectLock lock(object);
  if (id == kUnitDuration)
    state_of(object).unit_duration = g_value_get_uint(value);
  else
    G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
}

static void gst_haptic_convert_get_property(GObject *object, guint id, GValue *value,
                                            GParamSpec *pspec) {
  guarded(object, [&] {
    const State &state = state_of(object);
    if (id == kStats) {
      g_value_take_boxed(value, make_stats(state).release());
    } else if (id == kUnitDuration) {
      const ObjectLock lock(object);
      g_value_set_uint(value, state.unit_duration);
    } else {
      G_OBJECT_WARN_INVALID_PROPERTY_ID(object, id, pspec);
    }
  });
}

static void gst_haptic_convert_finalize(GObject *object) {
  delete GST_HAPTIC_CONVERT(object)->state;
  G_OBJECT_CLASS(gst_haptic_convert_parent_class)->finalize(object);
}

static void gst_haptic_convert_init(GstHapticConvert *self) {
  self->state = new State;
  gst_base_transform_set_qos_enabled(GST_BASE_TRANSFORM(self), FALSE);
  gst_base_transform_set_gap_aware(GST_BASE_TRANSFORM(self), TRUE);
}

static void gst_haptic_convert_class_init(GstHapticConvertClass *klass) {
  auto *object_class = G_OBJECT_CLASS(klass);
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *transform_class = GST_BASE_TRANSFORM_CLASS(klass);

  object_class->set_property = gst_haptic_convert_set_property;
  object_class->get_property = gst_haptic_convert_get_property;
  object_class->finalize = gst_haptic_convert_finalize;
  g_object_class_install_property(
      object_class, kUnitDuration,
      g_param_spec_uint("unit-duration", "Unit Duration",
                        "Length of the units of haptics/hmpg, ms; a unit is sent when it is over",
                        1, kLongestUnitDuration, kDefaultUnitDuration,
                        static_cast<GParamFlags>(G_PARAM_READWRITE | G_PARAM_STATIC_STRINGS |
                                                 GST_PARAM_MUTABLE_READY)));
  g_object_class_install_property(
      object_class, kStats,
      g_param_spec_boxed("stats", "Statistics", "Counters since the last start", GST_TYPE_STRUCTURE,
                         static_cast<GParamFlags>(G_PARAM_READABLE | G_PARAM_STATIC_STRINGS)));

  gst_element_class_set_static_metadata(
      element_class, "Haptic track converter", "Codec/Converter/Haptics",
      "Converts a haptic track between samples, fields, KLV, text and MPEG haptics",
      "Feeling Wind project");
  gst_element_class_add_static_pad_template(element_class, &sink_template);
  gst_element_class_add_static_pad_template(element_class, &src_template);

  transform_class->passthrough_on_same_caps = TRUE;
  transform_class->transform_caps = [](GstBaseTransform *trans, GstPadDirection direction,
                                       GstCaps *caps, GstCaps *filter) {
    return guarded(trans, static_cast<GstCaps *>(nullptr),
                   [&] { return transform_caps(direction, caps, filter); });
  };
  transform_class->fixate_caps = [](GstBaseTransform *trans, GstPadDirection direction, GstCaps *,
                                    GstCaps *other) {
    return guarded(trans, static_cast<GstCaps *>(nullptr),
                   [&] { return fixate_caps(GST_HAPTIC_CONVERT(trans), direction, other); });
  };
  transform_class->set_caps = [](GstBaseTransform *trans, GstCaps *in, GstCaps *out) -> gboolean {
    return guarded(trans, FALSE, [&] { return set_caps(trans, in, out); });
  };
  transform_class->start = [](GstBaseTransform *trans) -> gboolean {
    return guarded(trans, FALSE, [&] { return start(trans); });
  };
  transform_class->sink_event = [](GstBaseTransform *trans, GstEvent *event) -> gboolean {
    return guarded(trans, FALSE, [&] { return sink_event(trans, event); });
  };
  transform_class->query = [](GstBaseTransform *trans, GstPadDirection direction,
                              GstQuery *q) -> gboolean {
    return guarded(trans, FALSE, [&] { return query(trans, direction, q); });
  };
  transform_class->generate_output = [](GstBaseTransform *trans, GstBuffer **out) {
    return guarded(trans, GST_FLOW_ERROR, [&] { return generate_output(trans, out); });
  };
  // Without one the base class takes this for an element that changes nothing.
  transform_class->transform = [](GstBaseTransform *, GstBuffer *, GstBuffer *) {
    return GST_FLOW_NOT_SUPPORTED;
  };
}
