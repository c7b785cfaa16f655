// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/film-cut.hpp"

#include "core/track-caps.hpp"
#include "film/copied-stream.hpp"
#include "film/pipeline.hpp"
#include "part-file.hpp"
#include "tracks/field-track.hpp"

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <optional>

namespace haptic {
namespace {

constexpr guint kQueueBytes = 48 << 20;
constexpr std::uint64_t kNoEnd = GST_CLOCK_TIME_NONE;

// ---- where the key frames are -------------------------------------------------------------------

struct CutScan {
  GstPad *video = nullptr;
  std::vector<std::uint64_t> keys; // stream times, ns; the video's streaming thread, as the rest
  std::uint64_t delay = 0;         // ns by which a key frame is decoded before it is shown
  std::int64_t start = 0;          // stream time at running time 0, ns
  std::mutex mutex;
  std::vector<std::string> tracks; // stream ids of the haptic ones; guarded by mutex

  bool is_track(const std::string &id) const {
    return std::ranges::find(tracks, id) != tracks.end();
  }
};

std::string id_of(GstPad *pad) {
  const GCharPtr id(gst_pad_get_stream_id(pad));
  return id ? id.get() : "";
}

GstPadProbeReturn note_buffer(GstPad *pad, GstPadProbeInfo *info, gpointer data) {
  auto &scan = *static_cast<CutScan *>(data);
  GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
  if (pad != scan.video) {
    const std::scoped_lock lock(scan.mutex);
    const std::string id = id_of(pad);
    if (!scan.is_track(id) && is_own_track(buffer))
      scan.tracks.push_back(id);
    return GST_PAD_PROBE_OK;
  }
  if (GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT))
    return GST_PAD_PROBE_OK;
  if (const auto time = stream_time_of(pad, buffer); time != kNoEnd) {
    scan.keys.push_back(time);
    if (const auto running = running_time_of(pad, buffer); running != kNoEnd)
      scan.start = static_cast<std::int64_t>(time) - static_cast<std::int64_t>(running);
    if (GST_BUFFER_DTS_IS_VALID(buffer) && GST_BUFFER_PTS_IS_VALID(buffer) &&
        GST_BUFFER_PTS(buffer) > GST_BUFFER_DTS(buffer))
      scan.delay = std::max(scan.delay, GST_BUFFER_PTS(buffer) - GST_BUFFER_DTS(buffer));
  }
  return GST_PAD_PROBE_OK;
}

void scan_film(const std::string &path, const Poll &poll, CutScan &scan) {
  FilmStreams film(path, FilmUse::copy, poll);
  scan.video = film.video();
  for (GstPad *pad : film.all()) {
    gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, note_buffer, &scan, nullptr);
    read_to_end(film, pad);
  }
  film.play(poll);
  if (scan.keys.empty())
    throw_error(messages::kNoFrameIsDecoded);
  std::ranges::sort(scan.keys);
}

// ---- the part -----------------------------------------------------------------------------------

struct Part {
  const CutScan &scan;
  std::uint64_t begin = 0; // stream times, ns
  std::uint64_t end = kNoEnd;
  GstPad *video = nullptr;
  bool is_over = false; // of the first video; its streaming thread
};

GstPadProbeReturn drop_others(GstPad *pad, GstPadProbeInfo *info, gpointer data) {
  auto &part = *static_cast<Part *>(data);
  const GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
  const std::uint64_t time = stream_time_of(pad, buffer);
  bool is_within = time != kNoEnd && time >= part.begin && time < part.end;
  if (pad == part.video) {
    // Frames behind the last key frame may be shown before it, and depend on it.
    part.is_over = part.is_over || (!GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT) &&
                                    time != kNoEnd && time >= part.end);
    is_within = time != kNoEnd && time >= part.begin && !part.is_over;
  }
  return is_within ? GST_PAD_PROBE_OK : GST_PAD_PROBE_DROP;
}

// Links the stream to the muxer, or leaves it out. Returns what was left out.
std::optional<std::string> keep_stream(Part &part, const FilmStreams &film, GstPad *pad,
                                       GstElement *mux, bool is_matroska) {
  const CapsPtr caps = caps_of(pad);
  const bool is_track = part.scan.is_track(id_of(pad));
  if (is_track || !has_place(is_matroska ? "matroskamux" : "mpegtsmux", pad)) {
    read_to_end(film, pad);
    return is_track ? std::nullopt
                    : std::optional(std::string("a stream was left out: ") + name_of(caps.get()));
  }
  GstElement *queue = add_queue(film.pipeline(), kQueueBytes);
  const PadPtr out(gst_element_get_static_pad(queue, "src"));
  // A muxer drops what is decoded before 0.
  gst_pad_set_offset(out.get(), part.scan.start + static_cast<gint64>(part.scan.delay) -
                                    static_cast<gint64>(part.begin));
  gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, drop_others, &part, nullptr);
  link_untouched(queue, caps.get(), mux, is_matroska);
  link_pad(pad, queue);
  return std::nullopt;
}

} // namespace

std::vector<std::string> cut_film(const std::string &path, TrackFile track, std::uint64_t from,
                                  std::uint64_t to, const std::string &output, const Poll &poll) {
  const std::string ending = std::filesystem::path(output).extension().string();
  const bool is_matroska = ending == ".mkv";
  if (!is_matroska && ending != ".ts")
    throw_error(messages::kFilmFormIsUnknown, output.c_str());
  CutScan scan;
  scan_film(path, poll, scan);
  Part part{.scan = scan};
  const auto after = std::ranges::upper_bound(scan.keys, from);
  part.begin = after == scan.keys.begin() ? *after : *(after - 1);
  if (const auto last = std::ranges::lower_bound(scan.keys, to); last != scan.keys.end())
    part.end = *last;
  cut_track(track, part.begin, part.end);
  if (track.holds_nothing() || part.begin >= part.end)
    throw_error(messages::kCutIsEmpty, path.c_str());
  for (auto &sample : track.samples)
    sample.time += scan.delay;
  for (auto *coded : {&track.fields, &track.reliefs})
    for (auto &field : *coded)
      field.time += scan.delay;

  PartFile file(output + ".part");
  FilmStreams film(path, FilmUse::copy, poll);
  part.video = film.video();
  GstElement *mux =
      add_muxer(film.pipeline(), is_matroska ? "matroskamux" : "mpegtsmux", file.path());
  std::vector<std::string> remarks;
  if (scan.tracks.size() > 1)
    remarks.emplace_back("further haptic tracks were left out");
  const auto keep = [&](GstPad *pad) {
    if (auto remark = keep_stream(part, film, pad, mux, is_matroska))
      remarks.push_back(std::move(*remark));
  };
  // The clock and the tables of a transport stream go with its first stream.
  keep(film.video());
  // Before other texts: who takes the first text of the file takes the track.
  GstElement *in = add_track_source(film.pipeline(), !track.coded().empty(), mux, is_matroska).in;
  for (GstPad *pad : film.all())
    if (pad != film.video())
      keep(pad);
  push_track(in, track);
  film.play(poll);
  file.keep_as(output);
  return remarks;
}

} // namespace haptic
