// SPDX-License-Identifier: LGPL-2.1-or-later
/**
 * SECTION:element-hmpgparse
 *
 * Cuts a stream of MPEG haptics into units and gives them their times. See
 * docs/elements/hmpgparse.md.
 *
 *     gst-launch-1.0 filesrc location=track.hmpg ! hmpgparse ! hapticconvert
 *         ! hapticsink device=sim
 *
 * Standard: ISO/IEC 23090-31:2025, the MIHS stream of units (summed up in RFC 9993, section 4.2).
 */
#include "gsthmpgparse.h"

#include "documentation.hpp"
#include "exception-barrier.hpp"
#include "gst-raii.hpp"
#include "hmpg.hpp"
#include "messages.hpp"
#include "track-buffer.hpp"
#include "track-caps.hpp"

#include <algorithm>
#include <optional>
#include <utility>

GST_DEBUG_CATEGORY_STATIC(hmpg_parse_debug);
#define GST_CAT_DEFAULT hmpg_parse_debug

namespace {

using haptic::guarded;
using haptic::UnitHeader;
using haptic::UnitType;

// Streaming thread only, or while it is stopped.
struct State {
  std::optional<haptic::HmpgExperience> experience;
  std::uint64_t tick = 0; // end of the unit before
  bool in_step = false;   // the unit before was sound
  bool warned = false;
};

} // namespace

struct _GstHmpgParse {
  GstBaseParse parent;
  State *state; // made in _init, deleted in _finalize
};

static GstStaticPadTemplate sink_template = GST_STATIC_PAD_TEMPLATE(
    "sink", GST_PAD_SINK, GST_PAD_ALWAYS, GST_STATIC_CAPS(HAPTIC_HMPG_TYPE));
static GstStaticPadTemplate src_template =
    GST_STATIC_PAD_TEMPLATE("src", GST_PAD_SRC, GST_PAD_ALWAYS, GST_STATIC_CAPS(HAPTIC_HMPG_CAPS));

G_DEFINE_TYPE_WITH_CODE(GstHmpgParse, gst_hmpg_parse, GST_TYPE_BASE_PARSE,
                        GST_DEBUG_CATEGORY_INIT(hmpg_parse_debug, "hmpgparse", 0,
                                                "units of MPEG haptics"))
GST_ELEMENT_REGISTER_DEFINE(hmpgparse, "hmpgparse", GST_RANK_PRIMARY, GST_TYPE_HMPG_PARSE)

namespace {

using Bytes = std::span<const std::uint8_t>;

void report_damage(GstHmpgParse *self, const char *what, std::size_t offset) {
  GST_DEBUG_OBJECT(self, "%s at byte %" G_GSIZE_FORMAT " of a unit", what, offset);
  if (!std::exchange(self->state->warned, true))
    GST_ELEMENT_WARNING(self, STREAM, FORMAT, (haptic::messages::kHmpgIsDamaged, what),
                        ("at byte %" G_GSIZE_FORMAT " of a unit", offset));
}

// Returns how many bytes to pass over until something looks like a unit again.
gint bytes_to_skip(Bytes bytes) {
  for (std::size_t at = 1; at + haptic::kUnitHeadSize <= bytes.size(); ++at)
    if (haptic::looks_like_unit(bytes.subspan(at)))
      return static_cast<gint>(at);
  const std::size_t kept = std::min(bytes.size() - 1, haptic::kUnitHeadSize - 1);
  return static_cast<gint>(bytes.size() - kept);
}

GstClockTime time_of(const State &state, std::uint64_t ticks) {
  return gst_util_uint64_scale_round(ticks, GST_SECOND, state.experience->timescale);
}

void set_experience(GstHmpgParse *self, haptic::HmpgExperience experience) {
  State &state = *self->state;
  state.tick = experience.time;
  if (!state.experience || state.experience->timescale != experience.timescale) {
    const haptic::CapsPtr caps = haptic::make_hmpg_caps(static_cast<gint>(experience.timescale));
    gst_pad_set_caps(GST_BASE_PARSE_SRC_PAD(self), caps.get());
  }
  state.experience = std::move(experience);
}

void stamp(State &state, GstBuffer *buffer, const UnitHeader &header) {
  const std::uint64_t end = state.tick + header.duration;
  if (!GST_BUFFER_PTS_IS_VALID(buffer))
    GST_BUFFER_PTS(buffer) = time_of(state, state.tick);
  GST_BUFFER_DURATION(buffer) = time_of(state, end) - time_of(state, state.tick);
  state.tick = end;
  if (header.dependent)
    GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT);
  if (header.type == UnitType::initialization)
    GST_BUFFER_FLAG_SET(buffer, GST_BUFFER_FLAG_HEADER);
}

// The unit at the beginning of the bytes, if it is whole and sound, or else what to do.
struct Found {
  std::optional<UnitHeader> header; // of a sound unit
  gint skip = 0;                    // bytes
};
Found find_unit(GstHmpgParse *self, Bytes bytes) {
  State &state = *self->state;
  GstBaseParse *parse = GST_BASE_PARSE(self);
  const auto header = haptic::read_unit_header(bytes);
  if (header && header->length > 0 && bytes.size() < haptic::kUnitHeadSize &&
      !GST_BASE_PARSE_DRAINING(parse)) {
    gst_base_parse_set_min_frame_size(parse, haptic::kUnitHeadSize);
    return {};
  }
  if (!haptic::looks_like_unit(bytes)) {
    if (std::exchange(state.in_step, false))
      report_damage(self, "this is no unit", 0);
    return {std::nullopt, bytes_to_skip(bytes)};
  }
  const std::size_t size = haptic::kUnitHeaderSize + header->length;
  if (bytes.size() < size) {
    if (GST_BASE_PARSE_DRAINING(parse)) {
      report_damage(self, "the unit at the end is cut off", bytes.size());
      state.in_step = false;
      return {std::nullopt, bytes_to_skip(bytes)};
    }
    gst_base_parse_set_min_frame_size(parse, static_cast<guint>(size));
    return {};
  }
  auto unit = haptic::read_unit(bytes.first(size), state.experience ? &*state.experience : nullptr);
  if (unit.error || (!state.experience && !unit.experience)) {
    report_damage(self,
                  unit.error ? unit.error->what : "it does not begin with an initialization unit",
                  unit.error ? unit.error->offset : 0);
    if (!state.in_step)
      return {std::nullopt, bytes_to_skip(bytes)};
    state.in_step = false;
    state.tick += header->duration;
    return {std::nullopt, static_cast<gint>(size)};
  }
  state.in_step = true;
  if (unit.experience)
    set_experience(self, std::move(*unit.experience));
  return {header, 0};
}

GstFlowReturn handle_frame(GstBaseParse *parse, GstBaseParseFrame *frame, gint *skip) {
  GstHmpgParse *self = GST_HMPG_PARSE(parse);
  Found found;
  {
    const haptic::ReadableBuffer readable(frame->buffer);
    if (!readable)
      return GST_FLOW_ERROR;
    found = find_unit(self, readable.bytes());
  }
  if (!found.header) {
    *skip = found.skip;
    if (found.skip > 0)
      gst_base_parse_set_min_frame_size(parse, haptic::kUnitHeaderSize);
    return GST_FLOW_OK;
  }
  gst_base_parse_set_min_frame_size(parse, haptic::kUnitHeaderSize);
  stamp(*self->state, frame->buffer, *found.header);
  return gst_base_parse_finish_frame(
      parse, frame, static_cast<gint>(haptic::kUnitHeaderSize + found.header->length));
}

gboolean start(GstBaseParse *parse) {
  *GST_HMPG_PARSE(parse)->state = {};
  gst_base_parse_set_min_frame_size(parse, haptic::kUnitHeaderSize);
  return TRUE;
}

void finalize(GObject *object) {
  delete GST_HMPG_PARSE(object)->state;
  G_OBJECT_CLASS(gst_hmpg_parse_parent_class)->finalize(object);
}

} // namespace

static void gst_hmpg_parse_init(GstHmpgParse *self) {
  guarded(self, [&] { self->state = new State; });
}

static void gst_hmpg_parse_class_init(GstHmpgParseClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *parse_class = GST_BASE_PARSE_CLASS(klass);
  G_OBJECT_CLASS(klass)->finalize = [](GObject *object) {
    guarded(object, [&] { finalize(object); });
  };
  gst_element_class_set_static_metadata(
      element_class, "MPEG haptics parser", "Codec/Parser/Converter/Haptics",
      "Cuts a stream of MPEG haptics (.hmpg) into units", "Feeling Wind project");
  haptic::add_documentation(element_class, "hmpgparse");
  gst_element_class_add_static_pad_template(element_class, &sink_template);
  gst_element_class_add_static_pad_template(element_class, &src_template);
  parse_class->start = [](GstBaseParse *parse) -> gboolean {
    return guarded(parse, FALSE, [&] { return start(parse); });
  };
  parse_class->handle_frame = [](GstBaseParse *parse, GstBaseParseFrame *frame, gint *skip) {
    return guarded(parse, GST_FLOW_ERROR, [&] { return handle_frame(parse, frame, skip); });
  };
}
