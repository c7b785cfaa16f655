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
#include "interruption.hpp"
#include "mpeg-haptics/hjif.hpp"
#include "mpeg-haptics/hmpg-track.hpp"
#include "part-file.hpp"
#include "seconds.hpp"
#include "tracks/field-track.hpp"
#include "tracks/stream-track.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <iterator>

namespace haptic {
namespace {

constexpr std::size_t kMp4BrandAt = 4; // ISO/IEC 14496-12, 4.3: behind the size of the first box
constexpr std::uintmax_t kLargestText = 64 << 20; // bytes of what is read as a whole
constexpr std::size_t kMostSamples = 3'000'000;   // 27 hours of 30 a second, 300 MB

// ---- reading ------------------------------------------------------------------------------------

std::vector<std::uint8_t> read_bytes(const std::string &path) {
  if (std::filesystem::file_size(path) > kLargestText)
    throw_error(messages::kTrackFileIsTooLarge, path.c_str());
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::uint8_t> first_bytes(const std::string &path) {
  check_readable(path);
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes(4096);
  file.read(reinterpret_cast<char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

bool begins_with(std::span<const std::uint8_t> bytes, std::string_view text) {
  return bytes.size() >= text.size() &&
         std::equal(text.begin(), text.end(), bytes.begin(),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

// A unit of some bytes may last for hours, and containers have any size.
bool is_too_long(const TrackFile &track) {
  return track.samples.size() > kMostSamples || track.fields.size() > kMostSamples;
}

void check_length(const std::string &path, const TrackFile &track) {
  if (is_too_long(track))
    throw_error(messages::kTrackIsTooLong, path.c_str(), kMostSamples);
}

// Reads a file of sets, or of lines, whose samples have their own times. Of what is damaged some is
// named.
void read_bare_file(const std::string &path, TrackForm &form, bool has_lines, TrackFile &track) {
  constexpr std::size_t kNamed = 5;
  constexpr std::size_t kMostDamaged = 20; // sets
  const auto bytes = read_bytes(path);
  std::span<const std::uint8_t> rest(bytes);
  std::size_t damaged = 0;
  std::size_t others = 0;
  for (std::size_t line = 1; !rest.empty(); ++line) {
    const auto end = has_lines ? std::ranges::find(rest, '\n') : rest.end();
    const std::span packet(rest.begin(), end);
    std::vector<TrackItem> items;
    form.read({packet}, items);
    rest = rest.subspan(std::min(packet.size() + 1, rest.size()));
    for (TrackItem &item : items)
      if (const auto *sample = std::get_if<TimedSample>(&item))
        track.samples.push_back(sample->sample);
      else if (auto *field = std::get_if<TimedField>(&item))
        track.fields.push_back(std::move(field->field));
      else if (const auto &problem = std::get<TrackProblem>(item);
               problem.kind != TrackProblemKind::damaged &&
               problem.kind != TrackProblemKind::foreign_text)
        ++others;
      else if (++damaged <= kNamed)
        track.remarks.push_back(
            has_lines ? remark(FileRemark::damaged_line, line, problem.details.c_str())
                      : remark(FileRemark::damaged_set, problem.details.c_str()));
    if (damaged > kMostDamaged && !has_lines)
      throw_error(messages::kTrackFileIsDamaged, path.c_str());
  }
  if (damaged > kNamed)
    track.remarks.push_back(remark(FileRemark::further_damage, damaged - kNamed));
  if (others > 0)
    track.remarks.push_back(remark(FileRemark::other_sets, others));
}

void add_unsupported(TrackFile &track, const std::string &what) {
  if (!what.empty())
    track.remarks.push_back(remark(FileRemark::unsupported, what.c_str()));
}

void read_hmpg_file(const std::string &path, TrackFile &track) {
  const auto bytes = read_bytes(path);
  HmpgDecoder decoder;
  const auto append = [&](std::size_t at, HmpgDecoder::Result result) {
    if (!result.problem.empty())
      track.remarks.push_back(remark(FileRemark::damaged_unit, at, result.problem.c_str()));
    add_unsupported(track, result.unsupported);
    std::move(result.samples.begin(), result.samples.end(), std::back_inserter(track.samples));
    check_length(path, track);
  };
  std::size_t at = 0;
  while (at < bytes.size()) {
    const auto rest = std::span(bytes).subspan(at);
    const auto header = read_unit_header(rest);
    const std::size_t size = header ? kUnitHeaderSize + header->length : 0;
    if (!header || size > rest.size()) {
      track.remarks.push_back(remark(header ? FileRemark::cut_unit : FileRemark::no_unit, at));
      break;
    }
    append(at, decoder.push(rest.first(size), kNoTime));
    at += size;
  }
  append(at, decoder.finish());
}

void read_hjif_file(const std::string &path, TrackFile &track) {
  const auto bytes = read_bytes(path);
  auto read = read_hjif({reinterpret_cast<const char *>(bytes.data()), bytes.size()});
  if (!read.error.empty())
    throw_error(messages::kHjifIsWrong, path.c_str(), read.offset, read.error.c_str());
  add_unsupported(track, read.unsupported);
  track.samples = std::move(read.samples);
}

// Returns the type of a stream, and the size of its frames, for people to read.
std::string text_of(GstPad *pad) {
  const CapsPtr caps = caps_of(pad);
  const auto [width, height] = size_in(caps.get());
  return width > 0 ? format_text("%s, %d x %d", name_of(caps.get()), width, height)
                   : name_of(caps.get());
}

} // namespace

bool is_own_track(GstBuffer *buffer) {
  const ReadableBuffer readable(buffer);
  const auto bytes = readable.bytes();
  return begins_with(bytes, kTextName) ||
         (bytes.size() >= kMotionKey.size() &&
          std::equal(kMotionKey.begin(), kMotionKey.end(), bytes.begin()));
}

namespace {

bool has_reliefs(GstBuffer *buffer) {
  const ReadableBuffer readable(buffer);
  const auto bytes = readable.bytes();
  TrackFile track;
  StreamTrack(begins_with(bytes, kTextName) ? make_text_form() : make_klv_form(), track)
      .push({bytes, 0});
  return !track.fields.empty() && track.fields.front().kind == FieldKind::relief;
}

// A container, whose streams are known one after another. `sink` gets the track: the first stream
// that begins with a sample of this project. Other streams, other KLV and subtitles too, go to
// fakesinks.
struct Container {
  const std::string &wanted; // the only stream that is the track, or empty
  TrackFile &track;
  ElementPtr sink = make_element("appsink");
  std::atomic<bool> has_track = false;
  FrameSize film_size;
  std::atomic<GstClockTime> film_begin = GST_CLOCK_TIME_NONE; // stream times
  std::atomic<GstClockTime> film_end = 0;
  FilePipeline file; // ends first: its threads use the rest
};

// Once a stream turns out to be the track, its pad is linked to `sink` and its fakesink goes.
GstPadProbeReturn find_track(GstPad *pad, GstPadProbeInfo *info, gpointer data) {
  auto &container = *static_cast<Container *>(data);
  if (!is_own_track(GST_PAD_PROBE_INFO_BUFFER(info)))
    return GST_PAD_PROBE_OK;
  const GCharPtr name(gst_pad_get_name(pad));
  auto &beside = container.track.beside; // another stream may have the same caps
  if (const auto entry = std::ranges::find(beside, text_of(pad)); entry != beside.end())
    beside.erase(entry);
  if (container.has_track || (!container.wanted.empty() && container.wanted != name.get())) {
    container.track.others.emplace_back(name.get());
    if (has_reliefs(GST_PAD_PROBE_INFO_BUFFER(info)))
      container.track.surfaces.emplace_back(name.get());
    return GST_PAD_PROBE_REMOVE;
  }
  const PadPtr before(gst_pad_get_peer(pad));
  const ElementPtr fakesink(gst_pad_get_parent_element(before.get()));
  gst_pad_unlink(pad, before.get());
  // The pipeline may be changing its state and with it those of what is in it.
  gst_element_set_locked_state(fakesink.get(), TRUE);
  gst_element_set_state(fakesink.get(), GST_STATE_NULL);
  gst_bin_remove(GST_BIN(container.file.get()), fakesink.get());
  gst_bin_add(GST_BIN(container.file.get()), container.sink.get());
  gst_element_sync_state_with_parent(container.sink.get());
  gst_pad_link(pad, PadPtr(gst_element_get_static_pad(container.sink.get(), "sink")).get());
  container.track.stream = name.get();
  container.has_track = true;
  return GST_PAD_PROBE_REMOVE;
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
    gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, find_track, &container, nullptr);
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

template <typename Cells>
FrameSize frame_size_of(const CodedField &coded) {
  GridDecoder<Cells> decoder;
  if (decoder.push(coded.bytes) != GridDecoder<Cells>::Result::field)
    return {};
  return {static_cast<gint>(decoder.field().frame_width),
          static_cast<gint>(decoder.field().frame_height)};
}

// Of a track that is not empty.
FrameSize frame_size_of(const TrackFile &track) {
  if (track.fields.empty())
    return {static_cast<gint>(track.samples.front().motion.frame_width),
            static_cast<gint>(track.samples.front().motion.frame_height)};
  const CodedField &first = track.fields.front();
  return first.kind == FieldKind::relief ? frame_size_of<ReliefCells>(first)
                                         : frame_size_of<MotionCells>(first);
}

// What can be known of a track of another film: its frames have another size, or it does not end
// with the film. It may be shorter, since frames at rest are not written.
void compare_with_film(const Container &container, TrackFile &track) {
  if (track.empty() || container.film_end == 0)
    return;
  const std::uint64_t end =
      track.fields.empty() ? track.samples.back().time : track.fields.back().time;
  if (end != kNoTime && end > container.film_end + kSecond)
    track.remarks.push_back(
        remark(FileRemark::longer_than_film, seconds(end - container.film_end)));
  const FrameSize own = frame_size_of(track);
  const FrameSize film = container.film_size;
  // Of a film that lies on its side, author measures the upright frame.
  const bool is_turned = own == FrameSize{film.height, film.width};
  if (own.width > 0 && film.width > 0 && own != film && !is_turned)
    track.remarks.push_back(
        remark(FileRemark::other_frame, own.width, own.height, film.width, film.height));
}

void push_sample(GstSample *sample, StreamTrack &track) {
  GstBuffer *buffer = gst_sample_get_buffer(sample);
  const ReadableBuffer readable(buffer);
  if (!readable)
    return;
  track.push({readable.bytes(),
              stream_time_of(*gst_sample_get_segment(sample), GST_BUFFER_PTS(buffer)),
              GST_BUFFER_DURATION(buffer)});
}

void read_container(const std::string &path, const char *demuxer, std::unique_ptr<TrackForm> form,
                    TrackFile &track, const std::string &wanted) {
  Container container{.wanted = wanted, .track = track, .file = {path, demuxer}};
  GstElement *pipeline = container.file.get();
  GstAppSink *sink = GST_APP_SINK(container.sink.get());
  g_object_set(sink, "sync", FALSE, "async", FALSE, nullptr);
  StreamTrack stream(std::move(form), track);
  g_signal_connect(container.file.reader(), "pad-added", G_CALLBACK(link_stream), &container);
  const auto pull = [&] {
    while (const auto sample = SamplePtr(gst_app_sink_try_pull_sample(sink, 0)))
      push_sample(sample.get(), stream);
    check_length(path, track);
  };
  std::string failure;
  try {
    const Running running(pipeline);
    container.file.run(GST_STATE_PLAYING, GST_MESSAGE_EOS, messages::kFileStandsStill, pull);
    pull();
  } catch (const TrackFileError &error) {
    failure = error.what();
  }
  throw_if_interrupted();
  stream.finish();
  track.film_begin = container.film_begin;
  check_length(path, track);
  if (!container.has_track && !track.others.empty())
    throw_error(messages::kStreamIsNoTrack, path.c_str(), wanted.c_str(),
                track.others.front().c_str());
  if (!container.has_track && track.beside.empty())
    throw_error(messages::kContainerIsEmpty, path.c_str());
  if (!container.has_track)
    throw_error(messages::kContainerHasNoTrack, path.c_str(), track.beside.front().c_str());
  if (!failure.empty() && track.empty())
    throw TrackFileError(about(path, failure));
  if (!failure.empty())
    track.remarks.push_back(remark(FileRemark::ends_early, failure.c_str()));
  compare_with_film(container, track);
}

// ---- writing ------------------------------------------------------------------------------------

std::string bytes_of(const TrackFile &track, const std::string &ending) {
  const auto &samples = track.samples;
  std::string bytes;
  const auto append = [&](const std::vector<std::uint8_t> &more) {
    bytes.append(more.begin(), more.end());
  };
  if (ending == ".hjif")
    return write_hjif(samples, today());
  if (ending == ".hmpg") {
    HmpgEncoder encoder(1'000'000'000, today());
    for (const auto &sample : samples)
      for (const auto &unit : encoder.push(sample.motion, sample.time, sample.duration))
        append(unit.bytes);
    for (const auto &unit : encoder.finish())
      append(unit.bytes);
    return bytes;
  }
  const auto write = [&](const auto &one) {
    if (ending == ".klv")
      append(write_klv(one));
    else
      bytes += write_text_line(one) + "\n";
  };
  std::ranges::for_each(samples, write);
  std::ranges::for_each(track.coded(), write);
  return bytes;
}

const char *caps_of_track(bool is_coded) {
  return is_coded ? HAPTIC_KLV_CAPS : "haptics/x-raw,modality=velocity,layout=point";
}

} // namespace

TrackFile read_track_file(const std::string &path, const std::string &stream) {
  const auto head = first_bytes(path);
  TrackFile track;
  const auto text = std::find_if_not(head.begin(), head.end(),
                                     [](std::uint8_t c) { return c == ' ' || c == '\n'; });
  if (std::ranges::equal(std::span(head).first(std::min(head.size(), kKlvDesignator.size())),
                         kKlvDesignator)) {
    track.form = "KLV";
    read_bare_file(path, *make_klv_form(), false, track);
  } else if (begins_with(head, kTextName)) {
    track.form = "text lines";
    read_bare_file(path, *make_text_form(), true, track);
  } else if (looks_like_unit(head)) {
    track.form = "MPEG haptics, binary";
    read_hmpg_file(path, track);
  } else if (text != head.end() && *text == '{') {
    track.form = "MPEG haptics, JSON";
    read_hjif_file(path, track);
  } else if (!head.empty() && head[0] == 0x47 && (head.size() < 189 || head[188] == 0x47)) {
    track.form = "KLV in MPEG-TS";
    read_container(path, "tsdemux", make_klv_form(), track, stream);
  } else if (begins_with(head, kMatroskaMagic)) {
    track.form = "text lines in Matroska";
    read_container(path, "matroskademux", make_text_form(), track, stream);
  } else if (begins_with(std::span(head).subspan(std::min(head.size(), kMp4BrandAt)), "ftyp")) {
    track.form = "text lines in MP4";
    read_container(path, "qtdemux", make_text_form(), track, stream);
  } else {
    throw_error(messages::kTrackFormIsUnknown, path.c_str());
  }
  std::erase_if(track.samples, [](const TrackSample &sample) { return sample.time == kNoTime; });
  std::erase_if(track.fields, [](const CodedField &field) { return field.time == kNoTime; });
  // clang 14 does not compile that of std::ranges.
  const auto reliefs =
      std::stable_partition(track.fields.begin(), track.fields.end(), [](const CodedField &field) {
        return field.kind == FieldKind::motion;
      });
  track.reliefs.assign(reliefs, track.fields.end());
  track.fields.erase(reliefs, track.fields.end());
  if (!track.samples.empty() && !track.fields.empty()) {
    track.remarks.push_back(remark(FileRemark::points_beside_fields, track.samples.size()));
    track.samples.clear();
  }
  return track;
}

void leave_reliefs_out(const std::string &path, TrackFile &track) {
  if (track.empty() || track.reliefs.empty())
    return;
  print_remark(path, remark(FileRemark::reliefs_beside_motion, track.reliefs.size()));
  track.reliefs.clear();
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

void begin_at_zero(TrackFile &track) {
  const std::uint64_t first = times_of(track).first;
  for (auto &sample : track.samples)
    sample.time -= first;
  for (auto &field : track.fields)
    field.time -= first;
}

void play_track(const std::string &path, const TrackFile &track, const std::string &line,
                const std::function<void(GstElement *pipeline)> &prepare) {
  const ElementPtr pipeline = make_pipeline("appsrc name=in format=time caps=\"" +
                                            std::string(caps_of_track(!track.coded().empty())) +
                                            "\" ! hapticconvert ! " + line);
  if (prepare)
    prepare(pipeline.get());
  try {
    const Running running(pipeline.get());
    push_track(element_in(pipeline.get(), "in").get(), track);
    wait_for(pipeline.get(), GST_MESSAGE_EOS);
  } catch (const TrackFileError &failure) {
    throw TrackFileError(is_interrupted() ? failure.what() : about(path, failure.what()));
  }
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
  } else if (ending == ".klv" || ending == ".txt" || holds_points) {
    write_bytes(path, bytes_of(track, ending));
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
