// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track-caps.hpp"
#include "film/copied-stream.hpp"
#include "film/film-streams.hpp"
#include "film/pipeline.hpp"
#include "part-file.hpp"
#include "tracks/track-file.hpp"

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <set>

namespace haptic {
namespace {

constexpr guint kQueueBytes = 48 << 20;
constexpr std::int64_t kNoEnd = G_MAXINT64;

// ---- where the key frames are -------------------------------------------------------------------

struct CutScan {
  std::vector<std::int64_t> keys; // stream times, ns; the video's streaming thread, as the rest
  std::int64_t last = G_MININT64; // stream time of the last frame, ns
  std::int64_t delay = 0;         // ns by which a key frame is decoded before it is shown
  bool has_no_order = false; // frames are shown in another order than they come, and say no more
  std::int64_t start = 0;    // stream time at running time 0, ns
  std::mutex mutex;
  std::set<std::string> tracks; // stream ids of the haptic ones; guarded by mutex
};

std::string id_of(GstPad *pad) {
  const GCharPtr id(gst_pad_get_stream_id(pad));
  return id ? id.get() : "";
}

void note_frame(CutScan &scan, GstPad *pad, const GstBuffer *frame) {
  const auto time = signed_stream_time_of(pad, frame);
  if (!time)
    return;
  scan.has_no_order = scan.has_no_order || (*time < scan.last && !GST_BUFFER_DTS_IS_VALID(frame));
  scan.last = std::max(scan.last, *time);
  if (const auto running = running_time_of(pad, frame); GST_CLOCK_TIME_IS_VALID(running))
    scan.start = *time - static_cast<std::int64_t>(running);
  if (GST_BUFFER_FLAG_IS_SET(frame, GST_BUFFER_FLAG_DELTA_UNIT))
    return;
  scan.keys.push_back(*time);
  if (GST_BUFFER_DTS_IS_VALID(frame) && GST_BUFFER_PTS_IS_VALID(frame) &&
      GST_BUFFER_PTS(frame) > GST_BUFFER_DTS(frame))
    scan.delay = std::max(scan.delay, GST_CLOCK_DIFF(GST_BUFFER_DTS(frame), GST_BUFFER_PTS(frame)));
}

void scan_film(const std::string &path, CutScan &scan) {
  FilmStreams film(path, FilmUse::copy);
  watch_buffers(film.video(), [&](auto... frame) { note_frame(scan, frame...); });
  for (GstPad *pad : film.all()) {
    watch_buffers(pad, [&](GstPad *at, GstBuffer *buffer) {
      const std::scoped_lock lock(scan.mutex);
      if (is_own_track(buffer))
        scan.tracks.insert(id_of(at));
    });
    read_to_end(film.pipeline(), pad);
  }
  film.play();
  if (scan.keys.empty())
    throw_error(messages::kNoFrameIsDecoded);
  std::ranges::sort(scan.keys);
}

// ---- the part -----------------------------------------------------------------------------------

struct Part {
  const std::string &path;
  const CutScan &scan;
  std::int64_t begin = 0; // stream times, ns
  std::int64_t end = kNoEnd;
  GstPad *video = nullptr;
  bool is_over = false; // of the first video; its streaming thread

  std::int64_t hidden() const { return std::max<std::int64_t>(-begin, 0); } // ns before the film
};

bool is_within(Part &part, GstPad *pad, const GstBuffer *buffer) {
  const auto time = signed_stream_time_of(pad, buffer);
  if (pad != part.video)
    return time && *time >= part.begin && *time < part.end;
  // Frames behind the last key frame may be shown before it, and depend on it.
  part.is_over = part.is_over || (!GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT) &&
                                  time && *time >= part.end);
  return time && *time >= part.begin && !part.is_over;
}

// Links the stream to the muxer, or leaves it out and says so.
void keep_stream(Part &part, const FilmStreams &film, GstPad *pad, GstElement *mux,
                 bool is_matroska) {
  const bool is_track = part.scan.tracks.contains(id_of(pad));
  if (is_track || !has_place(is_matroska ? "matroskamux" : "mpegtsmux", pad)) {
    if (pad == part.video)
      throw_error(messages::kMuxerHasNoPlace, name_of(caps_of(pad).get()));
    read_to_end(film.pipeline(), pad);
    if (!is_track)
      print_remarks(part.path,
                    {"a further stream was left out: " + std::string(name_of(caps_of(pad).get()))});
    return;
  }
  watch_buffers(pad, [&part](auto... buffer) { return is_within(part, buffer...); });
  // A muxer drops what is decoded before 0.
  const std::int64_t offset = part.scan.start + part.scan.delay - part.begin;
  if (pad != part.video) {
    copy_stream(pad, kQueueBytes, offset, mux, is_matroska);
    return;
  }
  copy_stream(pad, kQueueBytes, offset - part.hidden(), mux, is_matroska);
  begin_earlier(pad, part.hidden());
}

} // namespace

void cut_film(const std::string &path, TrackFile track, std::int64_t from, std::int64_t to,
              const std::string &output) {
  const std::string ending = std::filesystem::path(output).extension().string();
  const bool is_matroska = ending == kMatroska;
  if (!is_matroska && ending != kTransportStream)
    throw_error(messages::kFilmFormIsUnknown, output.c_str());
  CutScan scan;
  scan_film(path, scan);
  if (scan.has_no_order && !is_matroska)
    throw_error(messages::kCutNeedsMatroska);
  if (from >= to || from > scan.last)
    throw_error(messages::kCutIsEmpty, path.c_str());
  Part part{.path = path, .scan = scan};
  const auto after = std::ranges::upper_bound(scan.keys, from);
  part.begin = after == scan.keys.begin() ? *after : *(after - 1);
  if (const auto last = std::ranges::lower_bound(scan.keys, to); last != scan.keys.end())
    part.end = *last;
  cut_track(track, std::max<std::int64_t>(part.begin, 0), part.end);
  if (track.holds_nothing() || part.begin >= part.end)
    throw_error(messages::kCutIsEmpty, path.c_str());
  move_times(track, scan.delay + part.hidden());

  PartFile file(output + ".part");
  FilmStreams film(path, FilmUse::copy);
  part.video = film.video();
  GstElement *mux = add_muxer(film.pipeline(), muxer_of(ending), file.path());
  if (scan.tracks.size() > 1)
    print_remarks(path, {"further haptic tracks were left out"});
  // The clock and the tables of a transport stream go with its first stream.
  keep_stream(part, film, film.video(), mux, is_matroska);
  // Before other texts: who takes the first text of the file takes the track.
  GstElement *in = add_track_source(film.pipeline(), !track.coded().empty(), mux, is_matroska).in;
  for (GstPad *pad : film.all())
    if (pad != film.video())
      keep_stream(part, film, pad, mux, is_matroska);
  push_track(in, track);
  film.play();
  file.keep_as(output);
}

} // namespace haptic
