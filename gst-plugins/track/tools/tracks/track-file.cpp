// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/track-file.hpp"

#include "core/track-buffer.hpp"
#include "core/track-caps.hpp"
#include "field-code/field-codec.hpp"
#include "film/copied-stream.hpp"
#include "film/film-streams.hpp"
#include "forms/klv.hpp"
#include "forms/text-line.hpp"
#include "glue/gst-raii.hpp"
#include "glue/segment-time.hpp"
#include "mpeg-haptics/hjif.hpp"
#include "mpeg-haptics/hmpg-form.hpp"
#include "mpeg-haptics/hmpg.hpp"
#include "part-file.hpp"
#include "seconds.hpp"
#include "tracks/field-track.hpp"
#include "tracks/track-reader.hpp"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <gst/app/gstappsrc.h>

namespace haptic {
namespace {

constexpr std::size_t kMp4BrandAt = 4; // ISO/IEC 14496-12, 4.3: behind the size of the first box
constexpr std::uintmax_t kLargestText = 64 << 20; // bytes of what is read as a whole
constexpr std::size_t kMostSamples = 3'000'000;   // 27 hours of 30 a second, 300 MB

// What stands before the number of a damaged part of a file; a set has none.
constexpr char kSet[] = "";
constexpr char kLine[] = "line ";
constexpr char kUnit[] = "unit at byte ";

// ---- reading ------------------------------------------------------------------------------------

std::string read_text(const std::string &path) {
  const std::uintmax_t size = std::filesystem::file_size(path);
  if (size > kLargestText)
    throw_error(messages::kTrackFileIsTooLarge, path.c_str());
  return read_start(path, size);
}

std::span<const std::uint8_t> as_bytes(const std::string &text) {
  return {reinterpret_cast<const std::uint8_t *>(text.data()), text.size()};
}

template <typename Start>
bool begins_with(std::span<const std::uint8_t> bytes, const Start &start) {
  return bytes.size() >= start.size() &&
         std::equal(start.begin(), start.end(), bytes.begin(),
                    [](auto a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

// A unit of some bytes may last for hours, and containers have any size.
void check_length(const std::string &path, const TrackFile &track) {
  if (track.samples.size() + track.fields.size() + track.reliefs.size() > kMostSamples)
    throw_error(messages::kTrackIsTooLong, path.c_str(), kMostSamples);
}

// Reads a file of sets, lines or units, whose samples have their own times.
void read_bare_file(const std::string &path, std::unique_ptr<TrackForm> form, const char *damaged,
                    TrackFile &track) {
  constexpr std::size_t kMostDamaged = 20; // sets
  const std::string text = read_text(path);
  const auto bytes = as_bytes(text);
  TrackReader reader(std::move(form), track, damaged);
  std::size_t line = 0;
  std::size_t at = 0;
  while (at < bytes.size()) {
    const auto rest = bytes.subspan(at);
    std::size_t size = rest.size(); // the reader of sets divides them
    if (damaged == kLine) {
      size = std::min<std::size_t>(size, std::ranges::find(rest, '\n') - rest.begin() + 1);
    } else if (damaged == kUnit) {
      const auto header = read_unit_header(rest);
      size = header ? kUnitHeaderSize + header->length : 0;
      if (!header || size > rest.size()) {
        const char *what = header ? "the last unit is cut off" : "this is no unit";
        track.remarks.push_back(format_text("byte %zu: %s; the rest was left out", at, what));
        break;
      }
    }
    reader.push({rest.first(size)}, damaged == kLine ? ++line : at);
    check_length(path, track);
    at += size;
  }
  reader.finish(damaged == kLine ? line : at);
  check_length(path, track);
  if (damaged == kSet && reader.damage() > kMostDamaged)
    throw_error(messages::kTrackFileIsDamaged, path.c_str());
}

void read_hjif_file(const std::string &path, TrackFile &track) {
  auto read = read_hjif(read_text(path));
  if (!read.error.empty())
    throw_error(messages::kHjifIsWrong, path.c_str(), read.offset, read.error.c_str());
  if (!read.unsupported.empty())
    track.remarks.push_back("left out: " + read.unsupported);
  track.samples = std::move(read.samples);
}

// Returns the type of a stream, and the size of its frames, for people to read.
std::string text_of(GstPad *pad) {
  const CapsPtr caps = caps_of(pad);
  const auto [width, height] = size_in(caps.get());
  return width > 0 ? format_text("%s, %d x %d", name_of(caps.get()), width, height)
                   : name_of(caps.get());
}

// A container, whose streams are known one after another. The track is the first stream that
// begins with a sample of this project. Other streams, other KLV and subtitles too, are passed
// over.
struct Container {
  const std::string &path;
  const std::string &wanted; // the only stream that is the track, or empty
  TrackFile &track;
  TrackReader reader;
  FrameSize film_size;
  std::atomic<GstClockTime> film_begin = GST_CLOCK_TIME_NONE; // stream times
  std::atomic<GstClockTime> film_end = 0;
  FilePipeline file; // ends first: its thread, which reads all streams, uses the rest
};

enum class Role { unknown, track, other };

// What a stream that begins with a sample of this project is.
Role role_of(Container &container, GstPad *pad, const InputPacket &first) {
  TrackFile &track = container.track;
  const GCharPtr name(gst_pad_get_name(pad));
  auto &beside = track.beside; // another stream may have the same caps
  if (const auto entry = std::ranges::find(beside, text_of(pad)); entry != beside.end())
    beside.erase(entry);
  if (track.stream.empty() && (container.wanted.empty() || container.wanted == name.get())) {
    track.stream = name.get();
    return Role::track;
  }
  track.others.emplace_back(name.get());
  TrackFile held;
  TrackReader(begins_text_line(first.bytes) ? make_text_form() : make_klv_form(), held).push(first);
  if (!held.reliefs.empty())
    track.surfaces.emplace_back(name.get());
  return Role::other;
}

void read_packet(Container &container, GstPad *pad, GstBuffer *buffer, Role &role) {
  const ReadableBuffer readable(buffer);
  const auto segment = segment_of(pad);
  if (!readable || !segment || role == Role::other)
    return;
  const GstClockTime pts = GST_BUFFER_PTS(buffer);
  const GstClockTime duration = GST_BUFFER_DURATION(buffer);
  const InputPacket packet{readable.bytes(), stream_time_of(*segment, pts), duration};
  if (role == Role::unknown && is_own_track(buffer))
    role = role_of(container, pad, packet);
  // What an edit list hides has a time stamp, but no time.
  const GstClockTime end = GST_CLOCK_TIME_IS_VALID(duration) ? pts + duration : duration;
  const bool is_shown = !GST_CLOCK_TIME_IS_VALID(pts) || segment->format != GST_FORMAT_TIME ||
                        gst_segment_clip(&*segment, GST_FORMAT_TIME, pts, end, nullptr, nullptr);
  if (role == Role::track && is_shown)
    container.reader.push(packet);
  check_length(container.path, container.track);
}

void link_stream(GstElement *, GstPad *pad, gpointer data) {
  auto &container = *static_cast<Container *>(data);
  const CapsPtr caps(gst_pad_get_current_caps(pad));
  if (!caps)
    return;
  container.track.beside.push_back(text_of(pad));
  gst_element_sync_state_with_parent(read_to_end(container.file.get(), pad));
  const std::string_view type = name_of(caps.get());
  if (type == HAPTIC_KLV_TYPE || type == HAPTIC_TEXT_TYPE)
    watch_buffers(pad, [&container, role = Role::unknown](GstPad *from, GstBuffer *buffer) mutable {
      read_packet(container, from, buffer, role);
    });
  if (!type.starts_with("video/") && !type.starts_with("image/"))
    return;
  container.film_size = size_in(caps.get());
  watch_buffers(pad, [&container](GstPad *video, GstBuffer *frame) {
    const GstClockTime time = stream_time_of(video, frame);
    if (!GST_CLOCK_TIME_IS_VALID(time))
      return;
    container.film_begin = std::min<GstClockTime>(container.film_begin, time);
    container.film_end = std::max<GstClockTime>(container.film_end, time);
  });
}

// Of a track that is not empty.
FrameSize frame_size_of(const TrackFile &track) {
  FrameSize size;
  const auto note = [&](const auto &frame, std::uint64_t) {
    size = {static_cast<gint>(frame.frame_width), static_cast<gint>(frame.frame_height)};
  };
  if (!track.samples.empty())
    note(track.samples.front().motion, 0);
  else if (track.fields.empty())
    for_each_relief({&track.reliefs.front(), 1}, note);
  else
    for_each_field({&track.fields.front(), 1}, note);
  return size;
}

// What can be known of a track of another film: its frames have another size, or it does not end
// with the film. It may be shorter, since frames at rest are not written.
void compare_with_film(const Container &container, TrackFile &track) {
  if (track.holds_nothing() || container.film_end == 0)
    return;
  const std::uint64_t end =
      track.samples.empty() ? track.coded().back().time : track.samples.back().time;
  if (end != kNoTime && end > container.film_end + kSecond)
    track.remarks.push_back(
        format_text(messages::kTrackIsLonger, seconds(end - container.film_end)));
  const FrameSize own = frame_size_of(track);
  const FrameSize film = container.film_size;
  // Of a film that lies on its side, author measures the upright frame.
  const bool is_turned = own == FrameSize{film.height, film.width};
  if (own.width > 0 && film.width > 0 && own != film && !is_turned)
    track.remarks.push_back(
        format_text(messages::kTrackHasOtherFrame, own.width, own.height, film.width, film.height));
}

void read_container(const std::string &path, const char *demuxer, std::unique_ptr<TrackForm> form,
                    TrackFile &track, const std::string &wanted) {
  Container container{.path = path,
                      .wanted = wanted,
                      .track = track,
                      .reader = {std::move(form), track},
                      .file = {path, demuxer}};
  g_signal_connect(container.file.reader(), "pad-added", G_CALLBACK(link_stream), &container);
  std::string failure;
  try {
    const Running running(container.file.get());
    container.file.run(GST_STATE_PLAYING, GST_MESSAGE_EOS, messages::kFileStandsStill);
  } catch (const TrackFileError &error) {
    failure = error.what();
  }
  throw_if_interrupted();
  container.reader.finish();
  track.film_begin = container.film_begin;
  if (track.beside.empty())
    container.reader.take_times_of_sender();
  check_length(path, track);
  if (track.stream.empty() && !track.others.empty())
    throw_error(messages::kStreamIsNoTrack, path.c_str(), wanted.c_str(),
                track.others.front().c_str());
  if (track.stream.empty() && track.beside.empty())
    throw_error(messages::kContainerIsEmpty, path.c_str());
  if (track.stream.empty())
    throw_error(messages::kContainerHasNoTrack, path.c_str(), track.beside.front().c_str());
  if (!failure.empty() && track.holds_nothing())
    throw TrackFileError(about(path, failure));
  if (!failure.empty())
    track.remarks.push_back("the file ends early: " + failure);
  compare_with_film(container, track);
}

// ---- writing ------------------------------------------------------------------------------------

std::string bytes_of(const TrackFile &track, bool has_lines) {
  std::string bytes;
  const auto add = [&](const auto &one) {
    if (has_lines)
      bytes += write_text_line(one) + '\n';
    else
      std::ranges::copy(write_klv(one), std::back_inserter(bytes));
  };
  std::ranges::for_each(track.samples, add);
  std::ranges::for_each(track.coded(), add);
  return bytes;
}

const char *caps_of_track(bool is_coded) {
  return is_coded ? HAPTIC_KLV_CAPS : "haptics/x-raw,modality=velocity,layout=point";
}

} // namespace

bool is_own_track(GstBuffer *buffer) {
  const ReadableBuffer readable(buffer);
  return begins_text_line(readable.bytes()) || begins_with(readable.bytes(), kMotionKey);
}

TrackFile read_track_file(const std::string &path, const std::string &stream) {
  check_readable(path);
  const std::string start = read_start(path, 4096);
  const auto head = as_bytes(start);
  TrackFile track;
  if (begins_with(head, kKlvDesignator)) {
    track.form = "KLV";
    read_bare_file(path, make_klv_form(), kSet, track);
  } else if (begins_text_line(head)) {
    track.form = "text lines";
    read_bare_file(path, make_text_form(), kLine, track);
  } else if (looks_like_unit(head)) {
    track.form = "MPEG haptics, binary";
    read_bare_file(path, make_hmpg_form(kSecond), kUnit, track);
  } else if (const std::size_t text = start.find_first_not_of(" \t\r\n");
             text != start.npos && start[text] == '{') {
    track.form = "MPEG haptics, JSON";
    read_hjif_file(path, track);
  } else if (!head.empty() && head[0] == 0x47 && (head.size() < 189 || head[188] == 0x47)) {
    track.form = "KLV in MPEG-TS";
    read_container(path, "tsdemux", make_klv_form(), track, stream);
  } else if (begins_with(head, kMatroskaMagic)) {
    track.form = "text lines in Matroska";
    read_container(path, "matroskademux", make_text_form(), track, stream);
  } else if (start.find("ftyp") == kMp4BrandAt) {
    track.form = "text lines in MP4";
    read_container(path, "qtdemux", make_text_form(), track, stream);
  } else {
    throw_error(messages::kTrackFormIsUnknown, path.c_str());
  }
  const auto has_no_time = [](const auto &one) { return one.time == kNoTime; };
  std::erase_if(track.samples, has_no_time);
  std::erase_if(track.fields, has_no_time);
  std::erase_if(track.reliefs, has_no_time);
  if (!track.samples.empty() && !track.fields.empty()) {
    track.remarks.push_back(format_text("%zu samples of one point beside the fields were left out",
                                        track.samples.size()));
    track.samples.clear();
  }
  return track;
}

TrackFile read_one_kind(const std::string &path, const std::string &stream) {
  TrackFile track = read_track_file(path, stream);
  if (!track.empty() && !track.reliefs.empty()) {
    track.remarks.push_back(
        format_text("%zu reliefs beside the motion were left out", track.reliefs.size()));
    track.reliefs.clear();
  }
  print_remarks(path, track.remarks);
  return track;
}

TrackTimes times_of(const TrackFile &track) {
  TrackTimes times;
  const auto widen = [&](const auto &one) {
    times.first = std::min(times.first, one.time);
    times.last = std::max(times.last, one.time);
  };
  std::ranges::for_each(track.samples, widen);
  std::ranges::for_each(track.coded(), widen);
  return times;
}

std::optional<double> film_begin_of(const TrackFile &track) {
  return track.is_untied || track.film_begin == kNoTime ? std::nullopt
                                                        : std::optional(seconds(track.film_begin));
}

void move_times(TrackFile &track, std::int64_t by) {
  track.for_each([by](auto &one) { one.time += static_cast<std::uint64_t>(by); });
}

void play_track(const std::string &path, const TrackFile &track, const std::string &line,
                const std::function<void(GstElement *pipeline)> &prepare) {
  const ElementPtr pipeline = make_pipeline("appsrc name=in format=time caps=\"" +
                                            std::string(caps_of_track(!track.coded().empty())) +
                                            "\" ! hapticconvert ! " + line);
  prepare(pipeline.get());
  naming(path, [&] {
    const Running running(pipeline.get());
    push_track(element_in(pipeline.get(), "in").get(), track);
    wait_for(pipeline.get(), GST_MESSAGE_EOS);
  });
}

void write_container(const std::string &path, const TrackFile &track, const std::string &line,
                     const std::function<void(GstElement *pipeline)> &prepare) {
  PartFile part(path + ".part");
  play_track(path, track, line + " ! filesink name=out", [&](GstElement *pipeline) {
    const ElementPtr out = element_in(pipeline, "out");
    g_object_set(out.get(), "location", part.path().c_str(), nullptr);
    if (prepare)
      prepare(pipeline);
  });
  part.keep_as(path);
}

void write_track_file(const std::string &path, const TrackFile &track) {
  const std::string ending = std::filesystem::path(path).extension().string();
  const bool holds_points = ending == ".hmpg" || ending == ".hjif";
  if (track.empty() && holds_points)
    throw_error(messages::kOutputHoldsMotion, path.c_str());
  if (!track.fields.empty() && holds_points)
    throw_error(messages::kOutputHoldsPoints, path.c_str());
  if (ending == ".ts") {
    write_container(path, track, HAPTIC_KLV_TYPE " ! mpegtsmux ! hapticmark");
  } else if (ending == ".mkv") {
    write_container(path, track, HAPTIC_TEXT_TYPE " ! matroskamux ! hapticmark");
  } else if (ending == ".hmpg") {
    write_container(path, track,
                    "haptics/x-raw ! hapticconvert unit-duration=1000 ! " HAPTIC_HMPG_TYPE);
  } else if (ending == ".hjif") {
    write_bytes(path, write_hjif(track.samples, today()));
  } else if (ending == ".klv" || ending == ".txt") {
    write_bytes(path, bytes_of(track, ending == ".txt"));
  } else {
    throw_error(messages::kOutputFormIsUnknown, path.c_str());
  }
}

void push_track(GstElement *in, const TrackFile &track) {
  GstAppSrc *to = GST_APP_SRC(in);
  for (const auto &[motion, time, duration] : track.samples)
    gst_app_src_push_buffer(to, make_buffer(pack_motion_sample(motion), time, duration).release());
  for (const auto &field : track.coded())
    gst_app_src_push_buffer(to, make_field_buffer(field, field.time, field.duration).release());
  gst_app_src_end_of_stream(to);
}

BufferPtr make_field_buffer(const CodedField &field, GstClockTime time, GstClockTime duration) {
  BufferPtr buffer = make_buffer(write_klv(field), time, duration);
  if (!is_key_field(field.bytes))
    GST_BUFFER_FLAG_SET(buffer.get(), GST_BUFFER_FLAG_DELTA_UNIT);
  return buffer;
}

void cut_track(TrackFile &track, std::uint64_t from, std::uint64_t to) {
  std::erase_if(track.samples,
                [&](const TrackSample &sample) { return sample.time < from || sample.time >= to; });
  for (auto &sample : track.samples)
    sample.time -= from;
  track.fields = cut_fields(track.fields, from, to);
  track.reliefs = cut_fields(track.reliefs, from, to);
}

TrackSource add_track_source(GstElement *pipeline, bool is_coded, GstElement *mux,
                             bool is_matroska) {
  GstElement *in = add_element(pipeline, "appsrc");
  GstElement *convert = add_element(pipeline, "hapticconvert");
  GstElement *form = add_element(pipeline, "capsfilter");
  const CapsPtr raw(gst_caps_from_string(caps_of_track(is_coded)));
  const CapsPtr coded(gst_caps_from_string(is_matroska ? HAPTIC_TEXT_CAPS : HAPTIC_KLV_CAPS));
  g_object_set(in, "format", GST_FORMAT_TIME, "caps", raw.get(), "max-bytes", guint64{0}, nullptr);
  g_object_set(form, "caps", coded.get(), nullptr);
  if (!gst_element_link_many(in, convert, form, mux, nullptr))
    throw_error(messages::kMuxerHasNoPlace, is_matroska ? HAPTIC_TEXT_TYPE : HAPTIC_KLV_TYPE);
  return {in, form};
}

} // namespace haptic
