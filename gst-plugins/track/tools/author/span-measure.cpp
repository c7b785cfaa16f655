// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/span-measure.hpp"

#include "author/centred-mean.hpp"
#include "film/copied-stream.hpp"
#include "film/pipeline.hpp"
#include "forms/track-form.hpp"
#include "glue/display-orientation.hpp"
#include "glue/gst-raii.hpp"
#include "network/key-requests.hpp"
#include "samples/motion-field.hpp"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <deque>
#include <iterator>
#include <limits>
#include <memory>
#include <utility>

namespace haptic {
namespace {

constexpr guint kQueueBytes = 4 << 20;
constexpr std::uint64_t kNoEnd = std::numeric_limits<std::uint64_t>::max();

// A field that waits for the next one.
struct PendingField {
  MotionField field;
  GstClockTime time; // running time, as it is written
  GstClockTime duration;
  bool is_gap;
  bool is_discont;
};

// Frames come from the decoder, go to motionfield, and their fields to the file.
struct Measuring {
  std::span<const Span> spans;
  SpanRange range;
  const HoldOptions &hold;
  ChunkWriter &out;
  FilmStreams &film;

  // The decoder's streaming thread. Its sending of frames to motionfield returns when the field is
  // written.
  PadPtr field_in;
  GstElement *field_element = nullptr; // motionfield, the pipeline's
  std::deque<BufferPtr> before;        // the last frames
  CapsPtr form_of_frames;
  std::size_t next = 0; // span, not yet begun
  bool within = false;  // a span of the range
  bool repeats = false; // frames before a span are measured again
  bool over = false;
  std::unique_ptr<TrackForm> form; // with the encoder
  ChunkStats stats;
  std::optional<MotionField> earlier; // of this span, before `pending`
  std::optional<PendingField> pending;

  KeyRequests keys{std::numeric_limits<std::size_t>::max()}; // the queue limits them
  bool decodes = false;                                      // the video's streaming thread
  // Whether an edit list hides coded frames, and one begins with the video. Set by that thread.
  std::atomic<bool> hides = false;
  std::atomic<bool> begins_at_frame = false;

  std::uint64_t begin_of(std::size_t span) const {
    return span < spans.size() ? spans[span].begin : kNoEnd;
  }
};

// ---- coded frames -------------------------------------------------------------------------------

// Leaves out what stands before the key frame at which the decoder begins, and notes the times of
// key frames: a player that tunes in begins with one, so that the field beside it is a key field.
bool watch_coded(Measuring &all, GstPad *pad, const GstBuffer *buffer) {
  const bool is_key = !GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT);
  const GstClockTime time = running_time_of(pad, buffer);
  const bool has_time = GST_CLOCK_TIME_IS_VALID(time);
  all.hides = all.hides || (!has_time && GST_BUFFER_PTS_IS_VALID(buffer));
  all.begins_at_frame = all.begins_at_frame || time == 0;
  const std::uint64_t from = all.spans[all.range.begin].decode_from;
  all.decodes = all.decodes || from == 0 || (is_key && has_time && time >= from);
  if (all.decodes && is_key && has_time)
    all.keys.add(EventPtr(make_key_request(time)).get());
  return all.decodes;
}

// ---- fields -------------------------------------------------------------------------------------

std::uint64_t mean_confidence(const MotionField &field) {
  double sum = 0;
  for (const FieldCell &cell : field.cells)
    sum += static_cast<double>(cell.confidence);
  return static_cast<std::uint64_t>(1e6 * sum / static_cast<double>(field.cells.size()));
}

// motionfield counts the things of each span from 1. Here those of neighbouring spans have other
// numbers.
void renumber(MotionField &field, std::size_t span) {
  constexpr std::size_t kThingsOfSpan = 4096;
  for (FieldThing &thing : field.things)
    thing.id = static_cast<std::uint16_t>(thing.id + span * kThingsOfSpan);
}

void write(Measuring &all, const PendingField &pending) {
  if (all.keys.is_due(pending.time))
    all.form->restart();
  std::vector<std::uint8_t> bytes(packed_size(pending.field));
  pack_motion_field(pending.field, bytes);
  std::vector<TrackItem> items;
  all.form->read({bytes, pending.time, pending.duration, pending.is_gap, pending.is_discont},
                 items);
  for (TrackItem &item : items)
    if (auto *timed = std::get_if<TimedField>(&item)) {
      timed->field.time = timed->time;
      all.out.add(timed->field);
    }
  ++all.stats.frames;
  all.stats.confidence += mean_confidence(pending.field);
}

// The first field of a span and its last one have no neighbour there.
void end_span(Measuring &all) {
  if (all.pending)
    write(all, *all.pending);
  all.pending.reset();
  all.earlier.reset();
}

void take_field(Measuring &all, GstPad *pad, GstBuffer *buffer) {
  if (all.repeats || all.over)
    return;
  const ReadableBuffer readable(buffer);
  PendingField now{.field = {},
                   .time = running_time_of(pad, buffer),
                   .duration = GST_BUFFER_DURATION(buffer),
                   .is_gap = GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP) != FALSE,
                   .is_discont = GST_BUFFER_IS_DISCONT(buffer) != FALSE};
  if (!readable || !unpack_motion_field(readable.bytes(), now.field) ||
      !GST_CLOCK_TIME_IS_VALID(now.time))
    return;
  renumber(now.field, all.next);
  if (all.pending) {
    MotionField measured = all.pending->field;
    if (all.earlier)
      take_centred_mean(*all.earlier, all.pending->field, now.field);
    write(all, *all.pending);
    all.earlier = std::move(measured);
  }
  all.pending = std::move(now);
}

// ---- frames -------------------------------------------------------------------------------------

void end(Measuring &all) {
  if (std::exchange(all.over, true))
    return;
  end_span(all);
  GstElement *pipeline = all.film.pipeline();
  gst_element_post_message(
      pipeline, gst_message_new_application(GST_OBJECT(pipeline), gst_structure_new_empty("over")));
}

// The points of the span that begins. Those before it were taken in another one.
std::string points_of_span(const Measuring &all) {
  const auto begin = static_cast<double>(all.begin_of(all.next - 1)) * 1e-9;
  const auto end = static_cast<double>(all.begin_of(all.next)) * 1e-9;
  std::vector<HoldPoint> points = all.hold.points;
  std::erase_if(points, [&](const HoldPoint &point) {
    return (all.next > 1 && point.time < begin) || point.time >= end;
  });
  return write_hold_points(points);
}

// The tracker forgets all before the first of the frames that it is given again.
void begin_span(Measuring &all) {
  end_span(all);
  g_object_set(all.field_element, "points", points_of_span(all).c_str(), nullptr);
  all.form = make_raw_form(TrackLayout::field);
  all.within = all.repeats = true;
  for (const BufferPtr &frame : all.before) {
    BufferPtr again(gst_buffer_copy(frame.get()));
    GST_BUFFER_FLAG_UNSET(again.get(), GST_BUFFER_FLAG_DISCONT);
    if (&frame == &all.before.front())
      GST_BUFFER_FLAG_SET(again.get(), GST_BUFFER_FLAG_DISCONT);
    gst_pad_chain(all.field_in.get(), again.release());
  }
  all.repeats = false;
}

// Returns false for a frame that motionfield does not get, or not yet.
bool divide_frames(Measuring &all, GstPad *pad, GstBuffer *frame) {
  const std::uint64_t time = running_time_of(pad, frame); // without one: the largest number
  // A frame that begins before the video, to which the decoder moves it. Other programs hide it.
  if (time == 0 && all.hides && !all.begins_at_frame)
    return false;
  bool begins = false;
  while (time != kNoEnd && time >= all.begin_of(all.next)) {
    ++all.next;
    begins = true;
  }
  if (all.next > all.range.end)
    end(all);
  if (all.over)
    return false;
  // Frames of another form are not given again: motionfield would read them as what comes now.
  if (CapsPtr caps(gst_pad_get_current_caps(pad));
      caps && (!all.form_of_frames || !gst_caps_is_equal(caps.get(), all.form_of_frames.get()))) {
    all.before.clear();
    all.form_of_frames = std::move(caps);
  }
  if (begins && all.next > all.range.begin)
    begin_span(all);
  all.before.emplace_back(gst_buffer_ref(frame));
  if (all.before.size() > kFramesBefore)
    all.before.pop_front();
  return all.within;
}

// ---- the pipeline -------------------------------------------------------------------------------

// Prints the progress of the fields to stderr. progressreport prints a line at the end, too: that
// of a short film is left out.
void report_progress(GstElement *pipeline, const std::string &path, GstElement *field) {
  g_set_print_handler([](const gchar *text) {
    if (!std::strstr(text, " (00:00:0"))
      std::fputs(text, stderr);
  });
  GstElement *progress = add_element(pipeline, "progressreport", path.c_str());
  g_object_set(progress, "update-freq", 10, nullptr); // s
  link_elements(field, progress);
  read_to_end(pipeline, PadPtr(gst_element_get_static_pad(progress, "src")).get());
}

// Links video -> decoder -> videoflip -> motionfield. The decoder has a pad when it has seen a
// frame. Upright frames pass videoflip as they are.
void build(Measuring &all, const std::string &path, unsigned columns, const char *direction) {
  std::string line = format_text(
      "queue name=in max-size-bytes=%u max-size-buffers=0 max-size-time=0 ! decodebin ! "
      "videoconvert name=convert ! videoflip name=flip video-direction=%s ! motionfield name=field",
      kQueueBytes, g_str_equal(direction, "auto") ? "identity" : direction);
  if (columns > 0)
    line += format_text(" field-columns=%u", columns);
  if (all.hold.chooses)
    line += format_text(" things=%u", kChosenThings);
  GstElement *bin = add_bin(all.film.pipeline(), line);
  const auto pad_of = [bin](const char *element, const char *pad) {
    return PadPtr(gst_element_get_static_pad(element_in(bin, element).get(), pad));
  };
  watch_buffers(all.film.video(), [&all](auto... coded) { return watch_coded(all, coded...); });
  refuse_other_size(pad_of("convert", "sink").get());
  watch_buffers(pad_of("flip", "src").get(),
                [&all](auto... decoded) { return divide_frames(all, decoded...); });
  all.field_element = element_in(bin, "field").get(); // the bin's
  all.field_in = pad_of("field", "sink");
  const PadPtr fields = pad_of("field", "src");
  watch_buffers(fields.get(), [&all](auto... made) { take_field(all, made...); });
  all.film.watch(fields.get());
  report_progress(all.film.pipeline(), path, all.field_element);
  link_pad(all.film.video(), element_in(bin, "in").get());
  for (const auto *others : {&all.film.audio(), &all.film.others()})
    for (GstPad *pad : *others)
      discard_stream(pad);
}

} // namespace

std::string write_hold_points(std::span<const HoldPoint> points) {
  std::string text;
  for (const HoldPoint &point : points)
    for (const auto &[sign, value] :
         {std::pair(" ", point.x), std::pair(",", point.y), std::pair("@", point.time)}) {
      char digits[32];
      text.append(text.empty() ? "" : sign);
      text.append(digits, std::to_chars(digits, std::end(digits), value).ptr);
    }
  return text;
}

ChunkStats measure_spans(const std::string &path, unsigned columns, const HoldOptions &hold,
                         const FilmIndex &index, SpanRange range, ChunkWriter &out) {
  FilmStreams film(path, FilmUse::decode);
  Measuring all{.spans = index.spans, .range = range, .hold = hold, .out = out, .film = film};
  build(all, path, columns, direction_of(index.rotation));
  film.play();
  end_span(all);
  if (all.stats.frames == 0)
    throw_error(messages::kNoFrameIsDecoded);
  return all.stats;
}

} // namespace haptic
