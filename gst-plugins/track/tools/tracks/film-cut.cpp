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
  GstElement *pipeline = nullptr;
  std::mutex mutex;
  std::vector<std::string> streams; // their ids
  std::string video;                // the first one
  std::vector<std::string> tracks;  // the haptic ones
  std::vector<std::uint64_t> keys;  // stream times, ns
  std::uint64_t delay = 0;          // ns by which a key frame is decoded before it is shown
  std::int64_t start = 0;           // stream time at running time 0, ns

  bool is_track(const std::string &id) const {
    return std::ranges::find(tracks, id) != tracks.end();
  }
};

std::string id_of(GstPad *pad) {
  const GCharPtr id(gst_pad_get_stream_id(pad));
  return id ? id.get() : "";
}

bool is_video(GstPad *pad) {
  const std::string_view name = name_of(caps_of(pad).get());
  return name.starts_with("video/") || name.starts_with("image/");
}

std::uint64_t stream_time_of(GstPad *pad, const GstBuffer *buffer, std::int64_t *start = nullptr) {
  const EventPtr event(gst_pad_get_sticky_event(pad, GST_EVENT_SEGMENT, 0));
  const GstClockTime time =
      GST_BUFFER_PTS_IS_VALID(buffer) ? GST_BUFFER_PTS(buffer) : GST_BUFFER_DTS(buffer);
  if (!event || !GST_CLOCK_TIME_IS_VALID(time))
    return kNoEnd;
  const GstSegment *segment = nullptr;
  gst_event_parse_segment(event.get(), &segment);
  const std::uint64_t stream = gst_segment_to_stream_time(segment, GST_FORMAT_TIME, time);
  const std::uint64_t running = gst_segment_to_running_time(segment, GST_FORMAT_TIME, time);
  if (start && stream != kNoEnd && running != kNoEnd)
    *start = static_cast<std::int64_t>(stream) - static_cast<std::int64_t>(running);
  return stream;
}

GstPadProbeReturn note_buffer(GstPad *pad, GstPadProbeInfo *info, gpointer data) {
  auto &scan = *static_cast<CutScan *>(data);
  GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
  const std::scoped_lock lock(scan.mutex);
  const std::string id = id_of(pad);
  // In GStreamer 1.26 a pad may be shown before its caps.
  if (scan.video.empty() && is_video(pad))
    scan.video = id;
  if (id != scan.video && !scan.is_track(id) && is_own_track(buffer))
    scan.tracks.push_back(id);
  if (id == scan.video && !GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT))
    if (const auto time = stream_time_of(pad, buffer, &scan.start); time != kNoEnd) {
      scan.keys.push_back(time);
      if (GST_BUFFER_DTS_IS_VALID(buffer) && GST_BUFFER_PTS_IS_VALID(buffer) &&
          GST_BUFFER_PTS(buffer) > GST_BUFFER_DTS(buffer))
        scan.delay = std::max(scan.delay, GST_BUFFER_PTS(buffer) - GST_BUFFER_DTS(buffer));
    }
  return GST_PAD_PROBE_OK;
}

void scan_stream(GstElement *, GstPad *pad, gpointer data) {
  auto &scan = *static_cast<CutScan *>(data);
  GstElement *sink = add_element(scan.pipeline, "fakesink");
  g_object_set(sink, "sync", FALSE, "async", FALSE, nullptr);
  gst_element_sync_state_with_parent(sink);
  {
    const std::scoped_lock lock(scan.mutex);
    scan.streams.push_back(id_of(pad));
    if (scan.video.empty() && is_video(pad))
      scan.video = scan.streams.back();
  }
  gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, note_buffer, &scan, nullptr);
  link_pad(pad, sink);
}

// Adds filesrc ! parsebin.
GstElement *add_parser(GstElement *pipeline, const std::string &path) {
  GstElement *source = add_element(pipeline, "filesrc");
  GstElement *parse = add_element(pipeline, "parsebin");
  g_object_set(source, "location", path.c_str(), nullptr);
  g_signal_connect(parse, "autoplug-continue", G_CALLBACK(is_parsed_further), nullptr);
  link_elements(source, parse);
  return parse;
}

void play_to_end(GstElement *pipeline, const std::string &path) {
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  const BusPtr bus(gst_element_get_bus(pipeline));
  const MessagePtr message(
      gst_bus_timed_pop_filtered(bus.get(), GST_CLOCK_TIME_NONE,
                                 static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
  const bool failed = GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_ERROR;
  gst_element_set_state(pipeline, GST_STATE_NULL);
  if (failed)
    throw_error("\"%s\": %s", path.c_str(), error_of(message.get()).c_str());
}

// ---- the part -----------------------------------------------------------------------------------

struct Part {
  const CutScan &scan;
  std::uint64_t begin = 0; // stream times, ns
  std::uint64_t end = kNoEnd;
  std::mutex mutex;
  std::vector<std::pair<PadPtr, gulong>> streams; // each held by a probe
  bool is_over = false;                           // of the first video; its streaming thread
};

GstPadProbeReturn drop_others(GstPad *pad, GstPadProbeInfo *info, gpointer data) {
  auto &part = *static_cast<Part *>(data);
  const GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
  const std::uint64_t time = stream_time_of(pad, buffer);
  bool is_within = time != kNoEnd && time >= part.begin && time < part.end;
  if (id_of(pad) == part.scan.video) {
    // Frames behind the last key frame may be shown before it, and depend on it.
    part.is_over = part.is_over || (!GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_DELTA_UNIT) &&
                                    time != kNoEnd && time >= part.end);
    is_within = time != kNoEnd && time >= part.begin && !part.is_over;
  }
  return is_within ? GST_PAD_PROBE_OK : GST_PAD_PROBE_DROP;
}

void hold_stream(GstElement *, GstPad *pad, gpointer data) {
  const auto hold = [](GstPad *, GstPadProbeInfo *, gpointer) { return GST_PAD_PROBE_OK; };
  auto &part = *static_cast<Part *>(data);
  const gulong probe =
      gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BLOCK_DOWNSTREAM, hold, nullptr, nullptr);
  const std::scoped_lock lock(part.mutex);
  part.streams.emplace_back(PadPtr(GST_PAD(gst_object_ref(pad))), probe);
}

// Links the stream to the muxer, or leaves it out. Returns what was left out.
std::optional<std::string> keep_stream(Part &part, GstElement *pipeline, GstPad *pad,
                                       GstElement *mux, bool is_matroska) {
  const CapsPtr caps = caps_of(pad);
  const bool is_track = part.scan.is_track(id_of(pad));
  if (is_track || !has_place(is_matroska ? "matroskamux" : "mpegtsmux", pad)) {
    GstElement *sink = add_element(pipeline, "fakesink");
    g_object_set(sink, "async", FALSE, "sync", FALSE, nullptr);
    link_pad(pad, sink);
    return is_track ? std::nullopt
                    : std::optional(std::string("a stream was left out: ") + name_of(caps.get()));
  }
  GstElement *queue = add_queue(pipeline, kQueueBytes);
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
                                  std::uint64_t to, const std::string &output) {
  const std::string ending = std::filesystem::path(output).extension().string();
  const bool is_matroska = ending == ".mkv";
  if (!is_matroska && ending != ".ts")
    throw_error(messages::kFilmFormIsUnknown, output.c_str());
  CutScan scan;
  const ElementPtr first = make_pipeline();
  scan.pipeline = first.get();
  g_signal_connect(add_parser(first.get(), path), "pad-added", G_CALLBACK(scan_stream), &scan);
  play_to_end(first.get(), path);
  if (scan.keys.empty())
    throw_error(messages::kFilmHasNoVideo, path.c_str());
  std::ranges::sort(scan.keys);
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
  const ElementPtr pipeline = make_pipeline();
  g_signal_connect(add_parser(pipeline.get(), path), "pad-added", G_CALLBACK(hold_stream), &part);
  gst_element_set_state(pipeline.get(), GST_STATE_PAUSED);
  const auto shown = [&] {
    const std::scoped_lock lock(part.mutex);
    return part.streams.size();
  };
  for (int waits = 0; shown() < scan.streams.size(); ++waits) {
    if (waits > 10'000)
      throw_error(messages::kStreamsAreUnclear);
    g_usleep(1000);
  }
  GstElement *mux = add_element(pipeline.get(), is_matroska ? "matroskamux" : "mpegtsmux");
  GstElement *sink = add_element(pipeline.get(), "filesink");
  g_object_set(sink, "location", file.path().c_str(), "async", FALSE, nullptr);
  GstElement *mark = add_element(pipeline.get(), "hapticmark");
  link_elements(mux, mark);
  link_elements(mark, sink);
  // Before the other streams: who takes the first text of the file takes the track.
  GstElement *in = add_track_source(pipeline.get(), !track.coded().empty(), mux, is_matroska).in;
  std::vector<std::string> remarks;
  if (scan.tracks.size() > 1)
    remarks.emplace_back("further haptic tracks were left out");
  for (const auto &[pad, probe] : part.streams)
    if (auto remark = keep_stream(part, pipeline.get(), pad.get(), mux, is_matroska))
      remarks.push_back(std::move(*remark));
  gst_bin_sync_children_states(GST_BIN(pipeline.get()));
  push_track(in, track);
  for (const auto &[pad, probe] : part.streams)
    gst_pad_remove_probe(pad.get(), probe);
  play_to_end(pipeline.get(), path);
  file.keep_as(output);
  return remarks;
}

} // namespace haptic
