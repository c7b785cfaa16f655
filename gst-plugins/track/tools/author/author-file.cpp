// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/author-file.hpp"

#include "core/track-buffer.hpp"
#include "field-code/field-codec.hpp"
#include "film/big-endian.hpp"
#include "film/copied-stream.hpp"
#include "film/pipeline.hpp"
#include "forms/klv.hpp"
#include "glue/display-orientation.hpp"
#include "part-file.hpp"
#include "tracks/source-mark.hpp"
#include "tracks/track-file.hpp"

#include <algorithm>
#include <filesystem>
#include <gst/app/gstappsrc.h>
#include <span>
#include <string_view>
#include <utility>

namespace haptic {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kVideos[] = {".3gp", ".avi", ".flv", ".m2ts", ".m4v",
                                        ".mkv", ".mov", ".mp4", ".mpeg", ".mpg",
                                        ".mts", ".ogv", ".ts",  ".webm", ".wmv"};

// Limits of the queues. The muxer waits for the slowest stream.
constexpr guint kVideoBytes = 24 << 20;
constexpr guint kAudioBytes = 8 << 20;

constexpr std::uint64_t kFieldsInMemory = 1000; // of a chunk, before they are forgotten

// ---- the track ----------------------------------------------------------------------------------

// The fields of all chunks, one after another. The thread of the appsrc.
struct Track {
  const std::vector<ChunkReader> &chunks;
  std::uint64_t lead;       // ns
  std::size_t next = 0;     // chunk
  std::uint64_t pushed = 0; // fields
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
  CodedField field = coded_field_of(*item);
  if (++track.pushed % kFieldsInMemory == 0)
    track.chunks[track.next - 1].forget();
  track.decoder.push(field.bytes);
  const bool is_usual = field.duration == kNoTime && track.decoder.field().interval > 0;
  gst_app_src_push_buffer(
      in, make_field_buffer(field, field.time + track.lead,
                            is_usual ? track.decoder.field().interval : field.duration)
              .release());
}

// ---- the rotation -------------------------------------------------------------------------------

// The form of a coded picture.
struct CodedForm {
  bool is_h265 = false;
  std::size_t length_size = 0; // bytes before a NAL unit; 0: start codes
};

CodedForm form_of(GstPad *pad) {
  const CapsPtr caps = caps_of(pad);
  CodedForm form{.is_h265 = g_str_equal(name_of(caps.get()), "video/x-h265") != FALSE};
  const GValue *value =
      gst_structure_get_value(gst_caps_get_structure(caps.get(), 0), "codec_data");
  guint8 sizes = 0; // ISO/IEC 14496-15, 5.3.3.1 and 8.3.3.1
  if (value && gst_buffer_extract(gst_value_get_buffer(value), form.is_h265 ? 21 : 4, &sizes, 1))
    form.length_size = (sizes & 3U) + 1;
  return form;
}

// Whether a NAL unit with this first byte is a slice.
bool is_slice(std::uint8_t first, bool is_h265) {
  const int type = is_h265 ? first >> 1 & 0x3F : first & 0x1F;
  return is_h265 ? type < 32 : type > 0 && type < 6;
}

// Returns where the first slice of an access unit begins, with its length or start code; or the
// size. Another message may have to be the first one (H.264, 7.4.1.2.3).
std::size_t find_picture(std::span<const std::uint8_t> bytes, const CodedForm &form) {
  constexpr std::uint8_t kStartCode[] = {0, 0, 1};
  const std::size_t head = form.length_size > 0 ? form.length_size : std::size(kStartCode);
  for (std::size_t at = 0; at + head < bytes.size();) {
    if (form.length_size == 0)
      at = static_cast<std::size_t>(std::ranges::search(bytes.subspan(at), kStartCode).begin() -
                                    bytes.begin());
    if (at + head < bytes.size() && is_slice(bytes[at + head], form.is_h265))
      return at;
    if (form.length_size > 0)
      read_unit(bytes, at, head);
    else
      at += head;
  }
  return bytes.size();
}

// Puts the rotation before the picture.
void turn_picture(GstPad *pad, GstBuffer *&picture, const std::string &rotation) {
  const CodedForm form = form_of(pad);
  const auto unit = orientation_unit(rotation, form.is_h265);
  edit_buffer(picture, [&](std::vector<std::uint8_t> &bytes) {
    const std::size_t at = find_picture(bytes, form);
    if (at == bytes.size())
      return;
    std::vector<std::uint8_t> message(form.length_size > 0 ? form.length_size : 3);
    message.back() = form.length_size > 0 ? static_cast<std::uint8_t>(unit.size()) : 1;
    message.insert(message.end(), unit.begin(), unit.end());
    bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), message.begin(), message.end());
  });
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

// Links the stream to the muxer if that has a place for it. Returns the pad before the muxer.
PadPtr keep_stream(const FilmStreams &film, GstPad *pad, GstElement *mux, bool is_matroska,
                   std::uint64_t lead) {
  if (!has_place(muxer_of(is_matroska ? kMatroska : kTransportStream), pad)) {
    discard_stream(pad);
    return nullptr;
  }
  if (pad != film.video())
    return copy_stream(pad, kAudioBytes, static_cast<gint64>(lead), mux, is_matroska);
  PadPtr linked = copy_stream(pad, kVideoBytes, 0, mux, is_matroska);
  begin_earlier(pad, lead);
  return linked;
}

void build(const PlannedFilm &planned, const FilmStreams &film, Track &track,
           const std::string &part, const std::string &mark) {
  const bool is_matroska = planned.index.ending == kMatroska;
  GstElement *mux = add_muxer(film.pipeline(), muxer_of(planned.index.ending), part);
  make_output_deterministic(planned, mux);
  const PadPtr video = keep_stream(film, film.video(), mux, is_matroska, planned.index.lead);
  if (!planned.index.rotation.empty() && orientation_in(planned.path).empty())
    watch_buffers(video.get(),
                  [rotation = planned.index.rotation](GstPad *pad, GstBuffer *&picture) {
                    turn_picture(pad, picture, rotation);
                  });
  for (GstPad *pad : film.audio())
    keep_stream(film, pad, mux, is_matroska, planned.index.lead);
  // Before other streams: who takes the first text of the file takes the track.
  const TrackSource source = add_track_source(film.pipeline(), true, mux, is_matroska);
  const auto mark_first = [mark, is_first = true](GstPad *, GstBuffer *&buffer) mutable {
    if (std::exchange(is_first, false))
      edit_buffer(buffer, [&](auto &field) { insert_mark(field, mark); });
  };
  watch_buffers(PadPtr(gst_element_get_static_pad(source.coded, "src")).get(), mark_first);
  GstAppSrcCallbacks callbacks = {};
  callbacks.need_data = push_next;
  gst_app_src_set_callbacks(GST_APP_SRC(source.in), &callbacks, &track, nullptr);
  for (GstPad *pad : film.others())
    keep_stream(film, pad, mux, is_matroska, planned.index.lead);
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
  std::string older;
  for (const char *ending : {kTransportStream, kMatroska}) {
    const std::string copy = author_stem(film.path, options) + ending;
    if (!fs::exists(copy, error))
      continue;
    const std::string held = mark_in(copy).value_or("");
    const bool is_in_the_way = ending == film.index.ending;
    if (held.empty() && is_in_the_way)
      throw_error(messages::kCopyIsForeign, copy.c_str());
    if (held.empty())
      continue;
    if (made_of(held) == made_of(mark))
      found = copy;
    else if (place_of(held) == place_of(mark))
      older = copy;
    else if (is_in_the_way)
      throw_error(messages::kCopyIsOfAnother, copy.c_str());
  }
  if (older.empty())
    return found;
  const bool may_be_of_another = !video_of_same_name(film.path).empty();
  if (found.empty() && may_be_of_another)
    throw_error(messages::kCopyIsOfAnother, older.c_str());
  if (!found.empty() && !may_be_of_another)
    fs::remove(older, error);
  return found;
}

std::string write_copy(const PlannedFilm &film, const AuthorOptions &options,
                       const std::vector<ChunkReader> &chunks) {
  const std::string stem = author_stem(film.path, options);
  PartFile part(stem + ".part");
  Track track{.chunks = chunks, .lead = film.index.lead};
  {
    FilmStreams streams(film.path, FilmUse::copy);
    build(film, streams, track, part.path(), copy_mark(film, options));
    streams.play();
  }
  std::string copy = stem + film.index.ending;
  part.keep_as(copy);
  // An older one, in the other container.
  const std::string other = stem + (film.index.ending == kMatroska ? kTransportStream : kMatroska);
  const std::string held = mark_in(other).value_or("");
  if (std::error_code error; !held.empty() && place_of(held) == place_of(copy_mark(film, options)))
    fs::remove(other, error);
  return copy;
}

} // namespace haptic
