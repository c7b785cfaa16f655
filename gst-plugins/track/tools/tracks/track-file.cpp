// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/track-file.hpp"

#include "core/track-caps.hpp"
#include "field-code/field-codec.hpp"
#include "film/pipeline.hpp"
#include "forms/klv.hpp"
#include "forms/text-line.hpp"
#include "glue/gst-raii.hpp"
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

void count_remark(TrackFile &track, std::size_t count, const std::string &what) {
  if (count > 0)
    track.remarks.push_back(std::to_string(count) + " " + what);
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
        track.remarks.push_back((has_lines ? "line " + std::to_string(line) : "damaged") + ": " +
                                problem.details);
    if (damaged > kMostDamaged && !has_lines)
      throw_error(messages::kTrackFileIsDamaged, path.c_str());
  }
  if (damaged > kNamed)
    count_remark(track, damaged - kNamed, "further ones were left out");
  count_remark(track, others, "sets of other origin, version or kind were passed over");
}

void add_left_out(TrackFile &track, const std::string &what) {
  if (!what.empty())
    track.remarks.push_back("left out: " + what);
}

void read_hmpg_file(const std::string &path, TrackFile &track) {
  const auto bytes = read_bytes(path);
  HmpgDecoder decoder;
  const auto append = [&](std::size_t at, HmpgDecoder::Result result) {
    if (!result.problem.empty())
      track.remarks.push_back("unit at byte " + std::to_string(at) + ": " + result.problem);
    add_left_out(track, result.unsupported);
    std::move(result.samples.begin(), result.samples.end(), std::back_inserter(track.samples));
    check_length(path, track);
  };
  std::size_t at = 0;
  while (at < bytes.size()) {
    const auto rest = std::span(bytes).subspan(at);
    const auto header = read_unit_header(rest);
    const std::size_t size = header ? kUnitHeaderSize + header->length : 0;
    if (!header || size > rest.size()) {
      track.remarks.push_back("byte " + std::to_string(at) + ": " +
                              (header ? "the last unit is cut off" : "this is no unit") +
                              "; the rest was left out");
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
  add_left_out(track, read.unsupported);
  track.samples = std::move(read.samples);
}

// Returns the type of a stream, and the size of its frames, for people to read.
std::string text_of(GstPad *pad) {
  const CapsPtr caps(gst_pad_get_current_caps(pad));
  const GstStructure *structure = gst_caps_get_structure(caps.get(), 0);
  gint width = 0;
  gint height = 0;
  std::string text = gst_structure_get_name(structure);
  if (gst_structure_get_int(structure, "width", &width) &&
      gst_structure_get_int(structure, "height", &height))
    text += ", " + std::to_string(width) + " x " + std::to_string(height);
  return text;
}

// The streams of a container. `sink` gets the track: the first stream that begins with a sample of
// this project. Other streams, other KLV and subtitles too, go to fakesinks.
struct Container {
  GstElement *pipeline = nullptr;
  ElementPtr sink;
  std::atomic<bool> has_track = false;
  TrackFile *track = nullptr;
  std::string wanted;  // the only stream that is the track, or empty
  gint film_width = 0; // px, 0: not known
  gint film_height = 0;
  std::atomic<GstClockTime> film_begin = GST_CLOCK_TIME_NONE; // stream times
  std::atomic<GstClockTime> film_end = 0;
};

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

// Once a stream turns out to be the track, its pad is linked to `sink` and its fakesink goes.
GstPadProbeReturn find_track(GstPad *pad, GstPadProbeInfo *info, gpointer data) {
  auto &container = *static_cast<Container *>(data);
  if (!is_own_track(GST_PAD_PROBE_INFO_BUFFER(info)))
    return GST_PAD_PROBE_OK;
  const GCharPtr name(gst_pad_get_name(pad));
  auto &beside = container.track->beside; // another stream may have the same caps
  if (const auto entry = std::ranges::find(beside, text_of(pad)); entry != beside.end())
    beside.erase(entry);
  if (container.has_track || (!container.wanted.empty() && container.wanted != name.get())) {
    container.track->others.emplace_back(name.get());
    if (has_reliefs(GST_PAD_PROBE_INFO_BUFFER(info)))
      container.track->surfaces.emplace_back(name.get());
    return GST_PAD_PROBE_REMOVE;
  }
  const PadPtr before(gst_pad_get_peer(pad));
  const ElementPtr fakesink(gst_pad_get_parent_element(before.get()));
  gst_pad_unlink(pad, before.get());
  gst_element_set_state(fakesink.get(), GST_STATE_NULL);
  gst_bin_remove(GST_BIN(container.pipeline), fakesink.get());
  gst_bin_add(GST_BIN(container.pipeline), container.sink.get());
  gst_element_sync_state_with_parent(container.sink.get());
  const PadPtr sink(gst_element_get_static_pad(container.sink.get(), "sink"));
  gst_pad_link(pad, sink.get());
  container.track->stream = name.get();
  container.has_track = true;
  return GST_PAD_PROBE_REMOVE;
}

GstPadProbeReturn watch_film(GstPad *pad, GstPadProbeInfo *info, gpointer data) {
  const GstClockTime time = stream_time_of(pad, GST_PAD_PROBE_INFO_BUFFER(info));
  auto &container = *static_cast<Container *>(data);
  if (GST_CLOCK_TIME_IS_VALID(time)) {
    container.film_begin = std::min<GstClockTime>(container.film_begin, time);
    container.film_end = std::max<GstClockTime>(container.film_end, time);
  }
  return GST_PAD_PROBE_OK;
}

void link_stream(GstElement *, GstPad *pad, gpointer data) {
  auto &container = *static_cast<Container *>(data);
  const CapsPtr caps(gst_pad_get_current_caps(pad));
  if (!caps)
    return;
  container.track->beside.push_back(text_of(pad));
  GstElement *sink = gst_element_factory_make("fakesink", nullptr);
  g_object_set(sink, "sync", FALSE, "async", FALSE, nullptr);
  gst_bin_add(GST_BIN(container.pipeline), sink);
  gst_element_sync_state_with_parent(sink);
  const PadPtr to(gst_element_get_static_pad(sink, "sink"));
  gst_pad_link(pad, to.get());
  const GstStructure *structure = gst_caps_get_structure(caps.get(), 0);
  if (gst_structure_has_name(structure, HAPTIC_KLV_TYPE) ||
      gst_structure_has_name(structure, HAPTIC_TEXT_TYPE))
    gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, find_track, &container, nullptr);
  const std::string_view type = gst_structure_get_name(structure);
  if (!type.starts_with("video/") && !type.starts_with("image/"))
    return;
  gst_structure_get_int(structure, "width", &container.film_width);
  gst_structure_get_int(structure, "height", &container.film_height);
  gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, watch_film, &container, nullptr);
}

struct FrameSize {
  gint width = 0; // px, 0: not known
  gint height = 0;
};

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
        format_text(messages::kTrackIsLonger, seconds(end - container.film_end)));
  const auto [width, height] = frame_size_of(track);
  if (width <= 0 || container.film_width <= 0)
    return;
  // Of a film that lies on its side, author measures the upright frame.
  const bool is_turned = width == container.film_height && height == container.film_width;
  if (!is_turned && (width != container.film_width || height != container.film_height))
    track.remarks.push_back(format_text(messages::kTrackHasOtherFrame, width, height,
                                        container.film_width, container.film_height));
}

void push_sample(GstSample *sample, StreamTrack &track) {
  GstBuffer *buffer = gst_sample_get_buffer(sample);
  const ReadableBuffer readable(buffer);
  if (!readable)
    return;
  track.push({readable.bytes(),
              gst_segment_to_stream_time(gst_sample_get_segment(sample), GST_FORMAT_TIME,
                                         GST_BUFFER_PTS(buffer)),
              GST_BUFFER_DURATION(buffer)});
}

void read_container(const std::string &path, const char *demuxer, std::unique_ptr<TrackForm> form,
                    TrackFile &track, const std::string &wanted) {
  const ElementPtr pipeline = make_pipeline();
  GstElement *source = add_element(pipeline.get(), "filesrc");
  GstElement *demux = add_element(pipeline.get(), demuxer);
  const ElementPtr sink = make_element("appsink");
  g_object_set(source, "location", path.c_str(), nullptr);
  g_object_set(sink.get(), "sync", FALSE, "async", FALSE, nullptr);
  gst_element_link(source, demux);
  Container container;
  container.pipeline = pipeline.get();
  container.sink.reset(GST_ELEMENT(gst_object_ref(sink.get())));
  container.track = &track;
  container.wanted = wanted;
  StreamTrack stream(std::move(form), track);
  g_signal_connect(demux, "pad-added", G_CALLBACK(link_stream), &container);
  Flow flow;
  flow.watch(PadPtr(gst_element_get_static_pad(source, "src")).get());
  const auto pull = [&] {
    while (const auto sample = SamplePtr(gst_app_sink_try_pull_sample(GST_APP_SINK(sink.get()), 0)))
      push_sample(sample.get(), stream);
  };
  std::string failure;
  try {
    const Running running(pipeline.get());
    wait_for(pipeline.get(), GST_MESSAGE_EOS, [&] {
      pull();
      check_length(path, track);
      flow.check(messages::kFileStandsStill);
    });
    pull();
  } catch (const TrackFileError &error) {
    failure = error.what();
  }
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
    track.remarks.push_back("the file ends early: " + failure);
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
  for (const auto &sample : samples)
    if (ending == ".klv")
      append(write_klv(sample));
    else
      bytes += write_text_line(sample) + "\n";
  for (const auto &field : track.coded())
    if (ending == ".klv")
      append(write_klv(field));
    else
      bytes += write_text_line(field) + "\n";
  return bytes;
}

struct BufferTimes {
  std::uint64_t time = 0;
  std::uint64_t duration = 0;
};

void push(GstElement *in, std::span<const std::uint8_t> bytes, BufferTimes times, guint flags) {
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
  gst_buffer_fill(buffer, 0, bytes.data(), bytes.size());
  GST_BUFFER_PTS(buffer) = times.time;
  GST_BUFFER_DURATION(buffer) = times.duration;
  GST_BUFFER_FLAG_SET(buffer, flags);
  gst_app_src_push_buffer(GST_APP_SRC(in), buffer);
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
    count_remark(track, track.samples.size(),
                 "samples of one point beside the fields were left out");
    track.samples.clear();
  }
  return track;
}

void leave_reliefs_out(const std::string &path, TrackFile &track) {
  if (track.empty() || track.reliefs.empty())
    return;
  print_remark(path,
               std::to_string(track.reliefs.size()) + " reliefs beside the motion were left out");
  track.reliefs.clear();
}

void begin_at_zero(TrackFile &track) {
  const auto shift = [](auto &all) {
    std::uint64_t first = kNoTime;
    for (const auto &one : all)
      first = std::min(first, one.time);
    for (auto &one : all)
      one.time -= first;
  };
  shift(track.samples);
  shift(track.fields);
}

void play_track(const std::string &path, const TrackFile &track, const std::string &line,
                const std::function<void(GstElement *pipeline)> &prepare) {
  GError *wrong = nullptr;
  const std::string whole = "appsrc name=in format=time caps=\"" +
                            std::string(caps_of_track(!track.coded().empty())) +
                            "\" ! hapticconvert ! " + line;
  GstElement *made = gst_parse_launch(whole.c_str(), &wrong);
  const ErrorPtr error(wrong);
  const ElementPtr pipeline(made);
  if (!made || error)
    throw_error("\"%s\": %s", path.c_str(), error ? error->message : "unknown");
  const ElementPtr in(gst_bin_get_by_name(GST_BIN(made), "in"));
  if (prepare)
    prepare(made);
  try {
    const Running running(made);
    push_track(in.get(), track);
    wait_for(made, GST_MESSAGE_EOS, throw_if_interrupted);
  } catch (const TrackFileError &failure) {
    throw TrackFileError(is_interrupted() ? failure.what() : about(path, failure.what()));
  }
}

void write_container(const std::string &path, const TrackFile &track, const std::string &line,
                     const std::function<void(GstElement *pipeline)> &prepare) {
  PartFile part(path + ".part");
  play_track(path, track, line + " ! filesink name=out", [&](GstElement *pipeline) {
    const ElementPtr out(gst_bin_get_by_name(GST_BIN(pipeline), "out"));
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
  for (const auto &sample : track.samples)
    push(in, pack_motion_sample(sample.motion), {sample.time, sample.duration}, 0);
  for (const auto &field : track.coded())
    push(in, write_klv(field), {field.time, field.duration},
         is_key_field(field.bytes) ? 0 : GST_BUFFER_FLAG_DELTA_UNIT);
  gst_app_src_end_of_stream(GST_APP_SRC(in));
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
