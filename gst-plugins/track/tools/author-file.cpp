// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author-file.hpp"

#include "copied-stream.hpp"
#include "field-codec.hpp"
#include "klv.hpp"
#include "matroska-track.hpp"
#include "part-file.hpp"
#include "pipeline.hpp"
#include "source-mark.hpp"
#include "track-buffer.hpp"
#include "track-file.hpp"

#include <algorithm>
#include <filesystem>
#include <gst/app/gstappsrc.h>
#include <string_view>

namespace haptic {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kVideos[] = {".3gp", ".avi", ".flv", ".m2ts", ".m4v",
                                        ".mkv", ".mov", ".mp4", ".mpeg", ".mpg",
                                        ".mts", ".ogv", ".ts",  ".webm", ".wmv"};

// Limits of the queues. The muxer waits for the slowest stream.
constexpr guint kVideoBytes = 24 << 20;
constexpr guint kAudioBytes = 8 << 20;

// ---- the track ----------------------------------------------------------------------------------

// The fields of all chunks, one after another. The thread of the appsrc.
struct Track {
  const std::vector<ChunkReader> &chunks;
  std::size_t next = 0; // chunk
  KlvReader reader{{}};
  FieldDecoder decoder; // of the duration of fields that do not say it
};

// Pushes one field, or the end.
void push_next(GstAppSrc *in, guint, gpointer data) {
  Track &track = *static_cast<Track *>(data);
  auto item = track.reader.next();
  while (!item && track.next < track.chunks.size()) {
    track.reader = KlvReader(track.chunks[track.next++].fields());
    item = track.reader.next();
  }
  if (!item) {
    gst_app_src_end_of_stream(in);
    return;
  }
  const CodedField field = coded_field_of(*item);
  track.decoder.push(field.bytes);
  const bool is_usual = field.duration == kNoTime && track.decoder.field().interval > 0;
  BufferPtr buffer = make_buffer(write_klv(field), field.time,
                                 is_usual ? track.decoder.field().interval : field.duration);
  if (!is_key_field(field.bytes))
    GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_DELTA_UNIT);
  gst_app_src_push_buffer(in, buffer.release());
}

// Puts the mark into the first field.
GstPadProbeReturn mark_first(GstPad *, GstPadProbeInfo *info, gpointer data) {
  const auto &mark = *static_cast<const std::string *>(data);
  GstBuffer *buffer = GST_PAD_PROBE_INFO_BUFFER(info);
  std::vector<std::uint8_t> field(gst_buffer_get_size(buffer));
  gst_buffer_extract(buffer, 0, field.data(), field.size());
  insert_mark(field, mark);
  GstBuffer *marked = gst_buffer_new_memdup(field.data(), field.size());
  gst_buffer_copy_into(
      marked, buffer,
      static_cast<GstBufferCopyFlags>(GST_BUFFER_COPY_FLAGS | GST_BUFFER_COPY_TIMESTAMPS), 0,
      static_cast<gsize>(-1));
  gst_buffer_unref(buffer);
  GST_PAD_PROBE_INFO_DATA(info) = marked;
  return GST_PAD_PROBE_REMOVE;
}

// ---- the pipeline -------------------------------------------------------------------------------

// Matroska holds random numbers and the date. With these settings the same video gives the same
// copy.
void make_output_deterministic(const PlannedFilm &film, GstElement *mux) {
  const std::string name = fs::path(film.path).filename().string();
  g_random_set_seed(g_str_hash(name.c_str()));
  GDateTime *date = g_date_time_new_from_unix_utc(film.modified / 1'000'000'000);
  if (g_object_class_find_property(G_OBJECT_GET_CLASS(mux), "creation-time"))
    g_object_set(mux, "creation-time", date, nullptr);
  g_date_time_unref(date);
}

// Links the stream to the muxer if that has a place for it.
void keep_stream(const FilmStreams &film, GstPad *pad, GstElement *mux, bool is_matroska) {
  if (!has_place(muxer_of(is_matroska ? kMatroska : kTransportStream), pad)) {
    discard_stream(pad);
    return;
  }
  GstElement *queue = add_queue(film.pipeline(), pad == film.video() ? kVideoBytes : kAudioBytes);
  link_untouched(queue, caps_of(pad).get(), mux, is_matroska);
  link_pad(pad, queue);
}

void build(const PlannedFilm &planned, const FilmStreams &film, Track &track,
           const std::string &part, std::string &mark) {
  const bool is_matroska = planned.index.ending == kMatroska;
  GstElement *mux = add_element(film.pipeline(), muxer_of(planned.index.ending));
  make_output_deterministic(planned, mux);
  GstElement *sink = add_element(film.pipeline(), "filesink");
  g_object_set(sink, "location", part.c_str(), "async", FALSE, nullptr);
  GstElement *container_mark = add_element(film.pipeline(), "hapticmark");
  link_elements(mux, container_mark);
  link_elements(container_mark, sink);
  keep_stream(film, film.video(), mux, is_matroska);
  for (GstPad *pad : film.audio())
    keep_stream(film, pad, mux, is_matroska);
  // Before other streams: who takes the first text of the file takes the track.
  const TrackSource source = add_track_source(film.pipeline(), true, mux, is_matroska);
  const PadPtr coded(gst_element_get_static_pad(source.coded, "src"));
  gst_pad_add_probe(coded.get(), GST_PAD_PROBE_TYPE_BUFFER, mark_first, &mark, nullptr);
  GstAppSrcCallbacks callbacks = {};
  callbacks.need_data = push_next;
  gst_app_src_set_callbacks(GST_APP_SRC(source.in), &callbacks, &track, nullptr);
  for (GstPad *pad : film.others())
    keep_stream(film, pad, mux, is_matroska);
}

// ---- copies that are there ---------------------------------------------------------------------

// Returns a video beside this one whose copy would have the same name, or nothing.
std::string video_of_same_name(const fs::path &video) {
  std::error_code error;
  const fs::path folder = video.has_parent_path() ? video.parent_path() : fs::path(".");
  for (const auto &entry : fs::directory_iterator(folder, error)) {
    const fs::path &other = entry.path();
    std::string ending = other.extension().string();
    std::ranges::transform(ending, ending.begin(), g_ascii_tolower);
    if (other.stem() == video.stem() && other.filename() != video.filename() &&
        std::ranges::find(kVideos, ending) != std::end(kVideos))
      return other.string();
  }
  return {};
}

} // namespace

std::string find_copy(const PlannedFilm &film, const AuthorOptions &options) {
  const std::string mark = copy_mark(film, options);
  std::error_code error;
  std::string found;
  std::string other;
  for (const char *ending : {kTransportStream, kMatroska}) {
    const std::string copy = author_stem(film.path, options) + ending;
    if (!fs::exists(copy, error))
      continue;
    const auto held = mark_in(copy);
    if (!held)
      throw_error(messages::kCopyHoldsNoFields, copy.c_str());
    (*held == mark ? found : other) = copy;
  }
  if (other.empty())
    return found;
  const std::string video = video_of_same_name(film.path);
  if (found.empty() && !video.empty())
    throw_error(messages::kCopyIsOfAnother, other.c_str(), video.c_str());
  if (!found.empty() && video.empty())
    fs::remove(other, error);
  return found;
}

std::string write_copy(const PlannedFilm &film, const AuthorOptions &options,
                       const std::vector<ChunkReader> &chunks, const Poll &poll) {
  const std::string stem = author_stem(film.path, options);
  PartFile part(stem + ".part");
  std::string mark = copy_mark(film, options);
  Track track{.chunks = chunks};
  {
    FilmStreams streams(film.path, FilmUse::copy, poll);
    build(film, streams, track, part.path(), mark);
    const bool is_dnxhd =
        g_str_equal(name_of(caps_of(streams.video()).get()), "video/x-dnxhd") != FALSE;
    streams.play(poll);
    if (is_dnxhd)
      name_dnxhd(part.path());
  }
  std::string copy = stem + film.index.ending;
  part.keep_as(copy);
  // One of another video of this name, in the other container.
  std::error_code error;
  fs::remove(stem + (film.index.ending == kMatroska ? kTransportStream : kMatroska), error);
  return copy;
}

} // namespace haptic
