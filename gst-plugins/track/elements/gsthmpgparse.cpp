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
#include "core/track-buffer.hpp"
#include "core/track-caps.hpp"
#include "glue/element-class.hpp"
#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"
#include "messages.hpp"
#include "mpeg-haptics/hmpg.hpp"

#include <algorithm>
#include <gst/base/gstbaseparse.h>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

G_DECLARE_FINAL_TYPE(GstHmpgParse, gst_hmpg_parse, GST, HMPG_PARSE, GstBaseParse)

GST_DEBUG_CATEGORY_STATIC(hmpg_parse_debug);
#define GST_CAT_DEFAULT hmpg_parse_debug

namespace {

using haptic::guarded;
using haptic::kGuarded;
using haptic::UnitHeader;
using haptic::UnitType;

// Where a unit begins in a file.
struct IndexEntry {
  std::uint64_t offset = 0; // bytes
  std::uint64_t tick = 0;
  GstClockTime time = 0;
  bool independent = false;
  std::uint64_t initialization = 0; // bytes, the initialization unit that it needs
};

constexpr std::size_t kMostIndexed = 1'000'000; // nine hours of 33 ms

struct State {
  // Object lock. In order, from the beginning of the stream.
  std::vector<IndexEntry> index;
  std::uint64_t index_end = 0; // bytes

  // Streaming thread only, or while it is stopped.
  bool indexed = false;
  std::optional<haptic::HmpgExperience> experience;
  std::uint64_t initialization = 0;    // bytes, the unit of `experience`
  std::optional<std::uint64_t> pushed; // bytes, the initialization unit that downstream has
  std::uint64_t tick = 0;              // end of the unit before
  bool in_step = false;                // the unit before was sound
  bool warned = false;
};

} // namespace

struct _GstHmpgParse {
  GstBaseParse parent;
  State *state; // made in _init, deleted in _finalize
};

G_DEFINE_TYPE_WITH_CODE(GstHmpgParse, gst_hmpg_parse, GST_TYPE_BASE_PARSE,
                        GST_DEBUG_CATEGORY_INIT(hmpg_parse_debug, "hmpgparse", 0,
                                                "units of MPEG haptics"))
GST_ELEMENT_REGISTER_DEFINE(hmpgparse, "hmpgparse", GST_RANK_PRIMARY, gst_hmpg_parse_get_type())

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

// Reads a file in chunks at any place.
class FileReader {
public:
  explicit FileReader(GstPad *pad) : pad_(pad) {}

  // Returns the bytes, fewer at the end of the file. They last until the next call.
  Bytes read(std::uint64_t offset, std::size_t size) {
    if (offset < begin_ || offset + size > begin_ + chunk_.size()) {
      chunk_.clear();
      begin_ = offset;
      GstBuffer *raw = nullptr;
      const auto wanted = static_cast<guint>(std::max(size, kChunk));
      flow_ = gst_pad_pull_range(pad_, offset, wanted, &raw);
      if (flow_ == GST_FLOW_OK) {
        const haptic::BufferPtr buffer(raw);
        if (const haptic::ReadableBuffer readable(buffer.get()); readable)
          chunk_.assign(readable.bytes().begin(), readable.bytes().end());
      }
    }
    const std::size_t skipped = offset - begin_;
    return Bytes(chunk_).subspan(skipped, std::min(size, chunk_.size() - skipped));
  }

  // Returns how the last reading went.
  GstFlowReturn flow() const { return flow_; }

private:
  static constexpr std::size_t kChunk = 65536;
  GstPad *pad_;
  GstFlowReturn flow_ = GST_FLOW_OK;
  std::uint64_t begin_ = 0;
  std::vector<std::uint8_t> chunk_;
};

// Lists the units up to the end. Returns nothing if it meets damage or the file cannot be read.
std::vector<IndexEntry> read_index(FileReader &file, GstClockTime &end) {
  std::vector<IndexEntry> index;
  std::optional<haptic::HmpgExperience> experience;
  std::uint64_t offset = 0;
  std::uint64_t initialization = 0;
  std::uint64_t tick = 0;
  const auto time = [&] {
    return gst_util_uint64_scale_round(tick, GST_SECOND, experience->timescale);
  };
  for (;;) {
    const Bytes head = file.read(offset, haptic::kUnitHeaderSize);
    const auto header = haptic::read_unit_header(head);
    if (!header)
      return file.flow() == GST_FLOW_EOS ? index : std::vector<IndexEntry>{};
    const std::size_t size = haptic::kUnitHeaderSize + header->length;
    if (header->type == UnitType::initialization) {
      experience = haptic::read_unit(file.read(offset, size), nullptr).experience;
      tick = experience ? experience->time : 0;
      initialization = offset;
    }
    if (!experience)
      return {};
    if (index.size() == kMostIndexed)
      return {};
    index.push_back({offset, tick, time(), !header->dependent, initialization});
    tick += header->duration;
    end = time();
    offset += size;
  }
}

bool can_read_file(GstHmpgParse *self) {
  return GST_PAD_MODE(GST_BASE_PARSE_SINK_PAD(self)) == GST_PAD_MODE_PULL;
}

// A file is read once, so that its duration and the places for seeks are known.
void index_file(GstHmpgParse *self) {
  State &state = *self->state;
  GstPad *pad = GST_BASE_PARSE_SINK_PAD(self);
  if (std::exchange(state.indexed, true) || !can_read_file(self))
    return;
  GstClockTime end = 0;
  FileReader file(pad);
  auto index = read_index(file, end);
  if (file.flow() == GST_FLOW_FLUSHING) // a seek came between
    state.indexed = false;
  if (index.empty())
    return;
  {
    const haptic::ObjectLock lock(self);
    state.index = std::move(index);
    state.index_end = std::numeric_limits<std::uint64_t>::max(); // complete
  }
  gst_base_parse_set_duration(GST_BASE_PARSE(self), GST_FORMAT_TIME, static_cast<gint64>(end), 0);
}

// Lists a unit of a stream that cannot be read at any place.
void extend_index(GstHmpgParse *self, std::uint64_t offset, const UnitHeader &header) {
  State &state = *self->state;
  const haptic::ObjectLock lock(self);
  if (offset != state.index_end || state.index.size() == kMostIndexed)
    return;
  state.index.push_back(
      {offset, state.tick, time_of(state, state.tick), !header.dependent, state.initialization});
  state.index_end = offset + haptic::kUnitHeaderSize + header.length;
}

std::optional<IndexEntry> entry_at(GstHmpgParse *self, std::uint64_t offset) {
  const haptic::ObjectLock lock(self);
  const auto &index = self->state->index;
  const auto entry = std::ranges::lower_bound(index, offset, {}, &IndexEntry::offset);
  if (entry == index.end() || entry->offset != offset)
    return std::nullopt;
  return *entry;
}

// Returns nothing if it cannot be read.
std::vector<std::uint8_t> read_initialization(GstHmpgParse *self, std::uint64_t offset) {
  FileReader file(GST_BASE_PARSE_SINK_PAD(self));
  const auto header = haptic::read_unit_header(file.read(offset, haptic::kUnitHeaderSize));
  if (!header)
    return {};
  const Bytes bytes = file.read(offset, haptic::kUnitHeaderSize + header->length);
  return {bytes.begin(), bytes.end()};
}

// After a seek the unit is another one than that behind the one before, and may need another
// initialization unit.
void find_place(GstHmpgParse *self, std::uint64_t offset) {
  State &state = *self->state;
  const auto entry = entry_at(self, offset);
  if (!entry)
    return;
  if (entry->initialization != state.initialization && entry->initialization != offset &&
      can_read_file(self)) {
    auto unit = haptic::read_unit(read_initialization(self, entry->initialization), nullptr);
    if (unit.experience)
      set_experience(self, std::move(*unit.experience));
    state.initialization = entry->initialization;
  }
  state.tick = entry->tick;
}

// The base class leaves out what is before a seek, initialization units too.
GstFlowReturn push_initialization(GstHmpgParse *self, GstBaseParseFrame *frame) {
  State &state = *self->state;
  const GstSegment &segment = GST_BASE_PARSE(self)->segment;
  const GstClockTime time = GST_BUFFER_PTS(frame->buffer);
  frame->flags |= GST_BASE_PARSE_FRAME_FLAG_CLIP;
  if (!can_read_file(self) || segment.rate < 0 ||
      time + GST_BUFFER_DURATION(frame->buffer) < segment.start)
    return GST_FLOW_OK;
  const bool has_it = state.pushed == state.initialization;
  state.pushed = state.initialization;
  if (has_it || GST_BUFFER_FLAG_IS_SET(frame->buffer, GST_BUFFER_FLAG_HEADER))
    return GST_FLOW_OK;
  const auto bytes = read_initialization(self, state.initialization);
  if (bytes.empty())
    return GST_FLOW_OK;
  haptic::BufferPtr buffer = haptic::make_buffer(bytes, time, 0);
  GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_HEADER);
  return gst_pad_push(GST_BASE_PARSE_SRC_PAD(self), buffer.release());
}

// Returns the place of the last independent unit that begins at a time or before, or the time of a
// place.
gboolean convert(GstBaseParse *parse, GstFormat from, gint64 value, GstFormat to, gint64 *result) {
  GstHmpgParse *self = GST_HMPG_PARSE(parse);
  {
    const haptic::ObjectLock lock(self);
    const auto &index = self->state->index;
    if (!index.empty() && value >= 0 && from == GST_FORMAT_TIME && to == GST_FORMAT_BYTES) {
      auto entry =
          std::ranges::upper_bound(index, static_cast<GstClockTime>(value), {}, &IndexEntry::time);
      while (entry != index.begin() && !(--entry)->independent) {
      }
      *result = static_cast<gint64>(entry->offset);
      return TRUE;
    }
    if (!index.empty() && value >= 0 && from == GST_FORMAT_BYTES && to == GST_FORMAT_TIME) {
      const auto entry = std::ranges::upper_bound(index, static_cast<std::uint64_t>(value), {},
                                                  &IndexEntry::offset);
      *result = static_cast<gint64>((entry - 1)->time);
      return TRUE;
    }
  }
  return gst_base_parse_convert_default(parse, from, value, to, result);
}

GstFlowReturn handle_frame(GstBaseParse *parse, GstBaseParseFrame *frame, gint *skip) {
  GstHmpgParse *self = GST_HMPG_PARSE(parse);
  index_file(self);
  find_place(self, frame->offset);
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
  if (found.header->type == UnitType::initialization)
    self->state->initialization = frame->offset;
  extend_index(self, frame->offset, *found.header);
  stamp(*self->state, frame->buffer, *found.header);
  return gst_base_parse_finish_frame(
      parse, frame, static_cast<gint>(haptic::kUnitHeaderSize + found.header->length));
}

gboolean start(GstBaseParse *parse) {
  gst_base_parse_set_min_frame_size(parse, haptic::kUnitHeaderSize);
  return TRUE;
}

gboolean stop(GstHmpgParse *self) {
  const haptic::ObjectLock lock(self);
  *self->state = {};
  return TRUE;
}

} // namespace

static void gst_hmpg_parse_init(GstHmpgParse *self) {
  guarded(self, [&] { self->state = new State; });
}

static void gst_hmpg_parse_class_init(GstHmpgParseClass *klass) {
  auto *element_class = GST_ELEMENT_CLASS(klass);
  auto *parse_class = GST_BASE_PARSE_CLASS(klass);
  G_OBJECT_CLASS(klass)->finalize = haptic::delete_state<GstHmpgParse, gst_hmpg_parse_parent_class>;
  haptic::describe(
      element_class, "hmpgparse", "MPEG haptics parser", "Codec/Parser/Converter/Haptics",
      "Cuts a stream of MPEG haptics (.hmpg) into units", HAPTIC_HMPG_TYPE, HAPTIC_HMPG_CAPS);
  parse_class->start = kGuarded<start>;
  parse_class->stop = kGuarded<stop>;
  parse_class->convert = kGuarded<convert>;
  parse_class->pre_push_frame = kGuarded<push_initialization>;
  parse_class->handle_frame = kGuarded<handle_frame>;
}
