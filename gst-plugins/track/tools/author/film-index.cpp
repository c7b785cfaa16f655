// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/film-index.hpp"

#include "film/pipeline.hpp"
#include "glue/display-orientation.hpp"
#include "part-file.hpp"
#include "seconds.hpp"
#include "tracks/track-file.hpp"

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <ranges>
#include <utility>

namespace haptic {
namespace {

// Of the key frames at which the decoder may begin for a span, the last one that has so many frames
// before the span: kFramesBefore, and those that a decoder may leave out after an open group.
constexpr std::uint64_t kDecodedBefore = 32;
// A film whose key frames are further apart (ns) is said to have few.
constexpr std::uint64_t kSparse = 60'000'000'000;
// A file ends early if it lacks more than this share of its length and more than this time.
constexpr double kMissingShare = 0.02;
constexpr GstClockTime kMissing = GST_SECOND;

struct KeyFrame {
  std::uint64_t time = 0;   // ns, running time
  std::uint64_t number = 0; // of the frame, as they are decoded
};

struct IndexScan {
  FilmIndex &index; // the video's streaming thread, as the rest; rotation as the tag has it
  std::vector<KeyFrame> keys = {};
  std::uint64_t frames = 0;
  std::uint64_t begin = 0;         // ns, time stamp at running time 0
  std::uint64_t hidden = 0;        // frames that an edit list hides before the first shown one
  std::optional<gint64> edit = {}; // ns, running time at 0 of the media
  // ns, the ends of the streams, each of its own thread: sound may be longer.
  std::deque<std::uint64_t> ends = {};
};

// Returns the end of a buffer in running time, ns; 0 if it has no time.
std::uint64_t end_of(GstPad *pad, const GstBuffer *buffer) {
  const GstClockTime start = running_time_of(pad, buffer);
  if (!GST_CLOCK_TIME_IS_VALID(start))
    return 0;
  return start + (GST_BUFFER_DURATION_IS_VALID(buffer) ? GST_BUFFER_DURATION(buffer) : 0);
}

void note_frame(GstPad *pad, const GstBuffer *buffer, IndexScan &scan) {
  const GstClockTime time = running_time_of(pad, buffer);
  if (!GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT) && GST_CLOCK_TIME_IS_VALID(time))
    scan.keys.push_back({time, scan.frames});
  ++scan.frames;
  scan.index.duration = std::max(scan.index.duration, end_of(pad, buffer));
  const auto segment = segment_of(pad);
  if (!segment || !GST_BUFFER_PTS_IS_VALID(buffer))
    return;
  scan.begin = segment->start;
  if (GST_BUFFER_PTS(buffer) < segment->start) {
    scan.index.lead = std::max(scan.index.lead, segment->start - GST_BUFFER_PTS(buffer));
    ++scan.hidden;
  }
}

// The edit list of an MP4 may show parts of the video in any order and at any speed. Neither
// MPEG-TS nor Matroska can.
void refuse_edits(GstEvent *event, IndexScan &scan) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_SEGMENT)
    return;
  const GstSegment *segment = nullptr;
  gst_event_parse_segment(event, &segment);
  const gint64 edit = static_cast<gint64>(segment->base) - static_cast<gint64>(segment->start);
  if (segment->rate * segment->applied_rate != 1 || scan.edit.value_or(edit) != edit)
    throw_error(messages::kFilmIsEdited);
  scan.edit = edit;
}

bool has_edit_list(GstElement *pipeline) {
  const std::unique_ptr<GstIterator, decltype(&gst_iterator_free)> all(
      gst_bin_iterate_all_by_element_factory_name(GST_BIN(pipeline), "qtdemux"), gst_iterator_free);
  GValue found = G_VALUE_INIT;
  const bool has = gst_iterator_next(all.get(), &found) == GST_ITERATOR_OK;
  if (has)
    g_value_unset(&found);
  return has;
}

// Watches all that flows in the film, and lets it flow.
void scan_film(FilmStreams &film, IndexScan &scan) {
  GstElement *pipeline = film.pipeline();
  const bool is_edited = has_edit_list(pipeline);
  watch_buffers(film.video(), [&](GstPad *pad, GstBuffer *frame) { note_frame(pad, frame, scan); });
  watch_events(film.video(), [&](GstPad *, GstEvent *event) {
    if (std::string rotation = rotation_of(event); !rotation.empty())
      scan.index.rotation = std::move(rotation);
    if (is_edited)
      refuse_edits(event, scan);
  });
  refuse_other_size(film.video());
  for (GstPad *pad : film.others()) // a copy has one haptic track
    watch_buffers(pad, [](GstPad *, GstBuffer *buffer) {
      if (is_own_track(buffer))
        throw_error(messages::kVideoHasTrack);
    });
  for (GstPad *pad : film.all()) {
    watch_buffers(pad, [&end = scan.ends.emplace_back()](GstPad *at, GstBuffer *any) {
      end = std::max(end, end_of(at, any));
    });
    read_to_end(pipeline, pad);
  }
  film.play();
  if (scan.frames == 0)
    throw_error(messages::kNoFrameIsDecoded);
}

bool is_matroska(const std::string &path) {
  return read_start(path, kMatroskaMagic.size()) == kMatroskaMagic;
}

// Returns the ending of MPEG-TS if that has a place for all streams. Streams from Matroska have no
// decoding times and go back into Matroska.
std::string choose_ending(const std::string &path, const FilmStreams &film) {
  const auto fits = [](GstPad *pad) { return has_place(muxer_of(kTransportStream), pad); };
  if (!is_matroska(path) && fits(film.video()) && std::ranges::all_of(film.audio(), fits))
    return kTransportStream;
  if (!has_place(muxer_of(kMatroska), film.video()))
    throw_error(messages::kNoContainer, name_of(caps_of(film.video()).get()));
  return kMatroska;
}

void find_warnings(const FilmStreams &film, FilmIndex &index) {
  const auto warn_of = [&](GstPad *pad, const char *what) {
    if (!has_place(muxer_of(index.ending), pad))
      index.warnings.push_back(std::string(what) + " was left out: " + name_of(caps_of(pad).get()));
  };
  if (g_str_equal(name_of(caps_of(film.video()).get()), "video/x-dnxhd"))
    index.warnings.emplace_back(
        "in Matroska, GStreamer does not know DNxHD; players with FFmpeg do");
  for (GstPad *pad : film.audio())
    warn_of(pad, "the sound");
  for (GstPad *pad : film.others())
    warn_of(pad, "a further stream");
}

// Returns the spans. The first one begins with the film.
std::vector<Span> divide(const std::vector<KeyFrame> &keys) {
  std::vector<Span> spans = {{}};
  auto start = keys.begin(); // where the decoder begins
  for (const KeyFrame &key : keys) {
    const std::uint64_t least = spans.size() > 1 ? spans.back().begin : keys.front().time;
    if (key.time < least + kSpanLength)
      continue;
    while (start + 1 != keys.end() && (start + 1)->number + kDecodedBefore <= key.number)
      ++start;
    spans.push_back({key.time, start->time});
  }
  return spans;
}

void warn_of_sparse_keys(const IndexScan &scan) {
  std::uint64_t longest = 0;
  std::uint64_t next = scan.index.duration;
  for (const KeyFrame &key : scan.keys | std::views::reverse) {
    longest = std::max(longest, next - std::min(next, key.time));
    next = key.time;
  }
  if (longest > kSparse)
    scan.index.warnings.push_back(format_text(messages::kKeysAreSparse, seconds(longest)));
}

// The copy holds the rotation in the coded video. A film that is a copy has it there already.
void find_rotation(const std::string &path, bool has_message, FilmIndex &index) {
  const std::string tag = std::exchange(index.rotation, "");
  if (has_message && !orientation_unit(tag, false).empty())
    index.rotation = tag;
  else if (has_message && tag.empty())
    index.rotation = orientation_in(path);
  else if (!tag.empty() && tag != "rotate-0")
    index.warnings.push_back("the rotation was left out: " + tag);
}

// The length that Matroska states counts from time stamp 0.
void check_whole(const IndexScan &scan, GstClockTime duration, bool counts_from_zero) {
  const std::uint64_t position = std::ranges::max(scan.ends) + (counts_from_zero ? scan.begin : 0);
  if (GST_CLOCK_TIME_IS_VALID(duration) && position < duration && duration - position > kMissing &&
      static_cast<double>(duration - position) > kMissingShare * static_cast<double>(duration))
    throw_error(messages::kFileEndsEarly, seconds(position), seconds(duration));
}

} // namespace

void refuse_other_size(GstPad *pad) {
  const auto position = std::make_shared<double>(0); // s
  watch_buffers(pad, [position](GstPad *at, GstBuffer *buffer) {
    if (const auto time = running_time_of(at, buffer); GST_CLOCK_TIME_IS_VALID(time))
      *position = seconds(time);
  });
  watch_events(pad, [position, before = FrameSize{}](GstPad *, GstEvent *event) mutable {
    const GstCaps *caps = caps_in(event);
    const FrameSize size = caps ? size_in(caps) : FrameSize{};
    if (size.width > 0 && before.width > 0 && size != before)
      throw_error(messages::kFrameSizeChanges, before.width, before.height, size.width, size.height,
                  *position);
    before = size.width > 0 ? size : before;
  });
}

FilmIndex index_film(const std::string &path) {
  FilmStreams film(path, FilmUse::copy);
  FilmIndex index;
  IndexScan scan{index};
  index.ending = choose_ending(path, film);
  find_warnings(film, index);
  const CapsPtr caps = caps_of(film.video());
  const bool has_message = g_str_equal(name_of(caps.get()), "video/x-h264") ||
                           g_str_equal(name_of(caps.get()), "video/x-h265");
  gint64 duration = -1; // GST_CLOCK_TIME_NONE
  gst_pad_query_duration(film.video(), GST_FORMAT_TIME, &duration);
  scan_film(film, scan);
  check_whole(scan, static_cast<GstClockTime>(duration), is_matroska(path));
  if (scan.hidden > 0)
    index.warnings.push_back(
        format_text(messages::kHiddenFrames, static_cast<unsigned long long>(scan.hidden)));
  index.spans = divide(scan.keys);
  warn_of_sparse_keys(scan);
  find_rotation(path, has_message, index);
  return index;
}

} // namespace haptic
