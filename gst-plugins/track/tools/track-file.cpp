// SPDX-License-Identifier: LGPL-2.1-or-later
#include "track-file.hpp"

#include "field-codec.hpp"
#include "gst-raii.hpp"
#include "hjif.hpp"
#include "hmpg-track.hpp"
#include "klv.hpp"
#include "pipeline.hpp"
#include "text-line.hpp"
#include "track-caps.hpp"

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
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    throw_error(messages::kFileIsMissing, path.c_str());
  if (!std::filesystem::is_regular_file(path, error))
    throw_error(messages::kFileIsNone, path.c_str());
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw_error(messages::kFileIsForbidden, path.c_str());
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

// Appends an item of KLV. Returns whether it is a sample or a field.
bool append_item(const KlvItem &item, TrackFile &track) {
  if (item.kind == KlvKind::motion)
    track.samples.push_back(item.sample);
  else if (item.kind == KlvKind::field)
    track.fields.push_back(coded_field_of(item));
  return item.kind == KlvKind::motion || item.kind == KlvKind::field;
}

// The same for a line of text.
bool append_line(TextLine &&line, TrackFile &track) {
  if (line.sample)
    track.samples.push_back(*line.sample);
  else if (line.field)
    track.fields.push_back(std::move(*line.field));
  return line.sample || line.field;
}

// A unit of some bytes may last for hours, and containers have any size.
bool is_too_long(const TrackFile &track) {
  return track.samples.size() > kMostSamples || track.fields.size() > kMostSamples;
}

void check_length(const std::string &path, const TrackFile &track) {
  if (is_too_long(track))
    throw_error(messages::kTrackIsTooLong, path.c_str(), kMostSamples);
}

void read_klv_file(const std::string &path, TrackFile &track) {
  const auto bytes = read_bytes(path);
  KlvReader reader(bytes);
  std::size_t damaged = 0;
  std::size_t others = 0;
  while (const auto item = reader.next()) {
    if (append_item(*item, track))
      continue;
    if (item->kind == KlvKind::damaged)
      track.remarks.push_back("damage at byte " + std::to_string(item->offset) + ": " +
                              item->error),
          ++damaged;
    else
      ++others;
    if (damaged > 20)
      throw_error(messages::kTrackFileIsDamaged, path.c_str());
  }
  count_remark(track, others, "sets of other origin, version or kind were passed over");
}

void read_text_file(const std::string &path, TrackFile &track) {
  const auto bytes = read_bytes(path);
  std::string_view text(reinterpret_cast<const char *>(bytes.data()), bytes.size());
  std::size_t wrong = 0;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.find_first_not_of(" \t\r") == std::string_view::npos)
      continue;
    auto read = read_text_line(line);
    const std::string error = read.error;
    if (!append_line(std::move(read), track) && ++wrong <= 5)
      track.remarks.push_back("line " + std::to_string(number) + ": " + error);
  }
  if (wrong > 5)
    count_remark(track, wrong - 5, "further lines were left out");
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

// The streams of a container: the track is linked to `convert`, the others to a fakesink.
struct Container {
  GstElement *pipeline = nullptr;
  GstElement *convert = nullptr;
  std::atomic<bool> has_track = false;
  std::atomic<bool> all_known = false; // no more streams will be found
  TrackFile *track = nullptr;
};

void link_stream(GstElement *, GstPad *pad, gpointer data) {
  auto &container = *static_cast<Container *>(data);
  const CapsPtr caps(gst_pad_get_current_caps(pad));
  if (!caps)
    return;
  const GstStructure *structure = gst_caps_get_structure(caps.get(), 0);
  const bool is_track = gst_structure_has_name(structure, HAPTIC_KLV_TYPE) ||
                        gst_structure_has_name(structure, HAPTIC_TEXT_TYPE);
  GstElement *next = nullptr;
  if (is_track && !container.has_track) {
    container.has_track = true;
    next = GST_ELEMENT(gst_object_ref(container.convert));
  } else {
    gint width = 0;
    gint height = 0;
    std::string text = gst_structure_get_name(structure);
    if (gst_structure_get_int(structure, "width", &width) &&
        gst_structure_get_int(structure, "height", &height))
      text += ", " + std::to_string(width) + " x " + std::to_string(height);
    container.track->beside.push_back(text);
    next = gst_element_factory_make("fakesink", nullptr);
    g_object_set(next, "sync", FALSE, "async", FALSE, nullptr);
    gst_bin_add(GST_BIN(container.pipeline), GST_ELEMENT(gst_object_ref(next)));
    gst_element_sync_state_with_parent(next);
  }
  GstPad *sink = gst_element_get_static_pad(next, "sink");
  gst_pad_link(pad, sink);
  gst_object_unref(sink);
  gst_object_unref(next);
}

// Appends one set or one line. Its time is that of its buffer.
void append_buffer(GstSample *sample, TrackFile &track) {
  GstBuffer *buffer = gst_sample_get_buffer(sample);
  GstMapInfo map;
  if (!gst_buffer_map(buffer, &map, GST_MAP_READ))
    return;
  const std::span<const std::uint8_t> bytes(map.data, map.size);
  const std::uint64_t time = gst_segment_to_stream_time(gst_sample_get_segment(sample),
                                                        GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  const std::size_t fields = track.fields.size();
  bool is_item = false;
  if (begins_with(bytes, kTextName))
    is_item =
        append_line(read_text_line({reinterpret_cast<const char *>(map.data), map.size}), track);
  else if (const auto item = KlvReader(bytes).next())
    is_item = append_item(*item, track);
  if (is_item)
    (track.fields.size() > fields ? track.fields.back().time : track.samples.back().time) = time;
  gst_buffer_unmap(buffer, &map);
}

// Reads the bus: warnings become remarks, an error becomes `failure`. Returns true at the end.
bool read_messages(GstBus *bus, TrackFile &track, std::string &failure) {
  bool over = false;
  while (GstMessage *message = gst_bus_timed_pop(bus, GST_MSECOND)) {
    GError *error = nullptr;
    if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
      failure = error_of(message);
    } else if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_WARNING) {
      gst_message_parse_warning(message, &error, nullptr);
      track.remarks.emplace_back(error->message);
    }
    over = over || GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS;
    g_clear_error(&error);
    gst_message_unref(message);
  }
  return over || !failure.empty();
}

// `form` is the one that the container does not hold: hapticconvert passes the same form on
// untouched, and only a conversion recovers times and finds damage.
void read_container(const std::string &path, const char *demuxer, const char *form,
                    TrackFile &track) {
  const ElementPtr pipeline = make_pipeline();
  GstElement *source = add_element(pipeline.get(), "filesrc");
  GstElement *demux = add_element(pipeline.get(), demuxer);
  GstElement *convert = add_element(pipeline.get(), "hapticconvert");
  GstElement *sink = add_element(pipeline.get(), "appsink");
  g_object_set(source, "location", path.c_str(), nullptr);
  const CapsPtr caps(gst_caps_from_string(form));
  g_object_set(sink, "caps", caps.get(), "sync", FALSE, "async", FALSE, nullptr);
  gst_element_link(source, demux);
  gst_element_link(convert, sink);
  Container container;
  container.pipeline = pipeline.get();
  container.convert = convert;
  container.track = &track;
  g_signal_connect(demux, "pad-added", G_CALLBACK(link_stream), &container);
  g_signal_connect(demux, "no-more-pads", G_CALLBACK(+[](GstElement *, gpointer data) {
                     static_cast<Container *>(data)->all_known = true;
                   }),
                   &container);
  const BusPtr bus(gst_element_get_bus(pipeline.get()));
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  // Without a track nothing reaches the appsink: the end is on the bus.
  std::string failure;
  for (bool over = false; !over;) {
    while (GstSample *sample = gst_app_sink_try_pull_sample(GST_APP_SINK(sink), 0)) {
      append_buffer(sample, track);
      gst_sample_unref(sample);
    }
    over = read_messages(bus.get(), track, failure) ||
           (container.has_track && gst_app_sink_is_eos(GST_APP_SINK(sink))) ||
           (container.all_known && !container.has_track);
  }
  while (GstSample *sample = gst_app_sink_try_pull_sample(GST_APP_SINK(sink), 0)) {
    append_buffer(sample, track);
    gst_sample_unref(sample);
  }
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  check_length(path, track);
  if (!container.has_track && track.beside.empty())
    throw_error(messages::kContainerIsEmpty, path.c_str());
  if (!container.has_track)
    throw_error(messages::kContainerHasNoTrack, path.c_str(), track.beside.front().c_str());
  if (!failure.empty() && track.empty())
    throw_error("\"%s\": %s", path.c_str(), failure.c_str());
  if (!failure.empty())
    track.remarks.push_back("the file ends early: " + failure);
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
  for (const auto &field : track.fields)
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

void write_container(const std::string &path, const TrackFile &track, const std::string &line) {
  GError *error = nullptr;
  const std::string caps =
      track.fields.empty() ? "haptics/x-raw,modality=velocity,layout=point" : HAPTIC_KLV_CAPS;
  const std::string whole = "appsrc name=in format=time caps=\"" + caps + "\" ! hapticconvert ! " +
                            line + " ! filesink name=out";
  GstElement *made = gst_parse_launch(whole.c_str(), &error);
  if (!made || error) {
    const std::string what = error ? error->message : "unknown";
    g_clear_error(&error);
    if (made)
      gst_object_unref(made);
    throw_error("\"%s\": %s", path.c_str(), what.c_str());
  }
  const ElementPtr pipeline(made);
  const ElementPtr in(gst_bin_get_by_name(GST_BIN(made), "in"));
  const ElementPtr out(gst_bin_get_by_name(GST_BIN(made), "out"));
  g_object_set(out.get(), "location", path.c_str(), nullptr);
  gst_element_set_state(made, GST_STATE_PLAYING);
  for (const auto &sample : track.samples)
    push(in.get(), pack_motion_sample(sample.motion), {sample.time, sample.duration}, 0);
  for (const auto &field : track.fields)
    push(in.get(), write_klv(field), {field.time, field.duration},
         is_key_field(field.bytes) ? 0 : GST_BUFFER_FLAG_DELTA_UNIT);
  gst_app_src_end_of_stream(GST_APP_SRC(in.get()));
  const BusPtr bus(gst_element_get_bus(made));
  GstMessage *message =
      gst_bus_timed_pop_filtered(bus.get(), GST_CLOCK_TIME_NONE,
                                 static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
  std::string failure;
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR)
    failure = error_of(message);
  gst_message_unref(message);
  gst_element_set_state(made, GST_STATE_NULL);
  if (!failure.empty())
    throw_error("\"%s\": %s", path.c_str(), failure.c_str());
}

[[noreturn]] void discard_output(const std::string &part, const std::string &path) {
  const int reason = errno;
  std::remove(part.c_str());
  throw_error(messages::kOutputFails, path.c_str(), std::strerror(reason));
}

} // namespace

TrackFile read_track_file(const std::string &path) {
  const auto head = first_bytes(path);
  TrackFile track;
  const auto text = std::find_if_not(head.begin(), head.end(),
                                     [](std::uint8_t c) { return c == ' ' || c == '\n'; });
  if (std::ranges::equal(std::span(head).first(std::min(head.size(), kKlvDesignator.size())),
                         kKlvDesignator)) {
    track.form = "KLV";
    read_klv_file(path, track);
  } else if (begins_with(head, kTextName)) {
    track.form = "text lines";
    read_text_file(path, track);
  } else if (looks_like_unit(head)) {
    track.form = "MPEG haptics, binary";
    read_hmpg_file(path, track);
  } else if (text != head.end() && *text == '{') {
    track.form = "MPEG haptics, JSON";
    read_hjif_file(path, track);
  } else if (!head.empty() && head[0] == 0x47 && (head.size() < 189 || head[188] == 0x47)) {
    track.form = "KLV in MPEG-TS";
    read_container(path, "tsdemux", HAPTIC_TEXT_TYPE, track);
  } else if (begins_with(head, kMatroskaMagic)) {
    track.form = "text lines in Matroska";
    read_container(path, "matroskademux", HAPTIC_KLV_CAPS, track);
  } else {
    throw_error(messages::kTrackFormIsUnknown, path.c_str());
  }
  std::erase_if(track.samples, [](const TrackSample &sample) { return sample.time == kNoTime; });
  std::erase_if(track.fields, [](const CodedField &field) { return field.time == kNoTime; });
  if (!track.samples.empty() && !track.fields.empty()) {
    count_remark(track, track.samples.size(),
                 "samples of one point beside the fields were left out");
    track.samples.clear();
  }
  return track;
}

void write_track_file(const std::string &path, const TrackFile &track) {
  const std::string ending = std::filesystem::path(path).extension().string();
  const std::string part = path + ".part";
  if (!track.fields.empty() && (ending == ".hmpg" || ending == ".hjif"))
    throw_error(messages::kOutputHoldsPoints, path.c_str());
  if (ending == ".ts") {
    write_container(part, track, HAPTIC_KLV_TYPE " ! mpegtsmux ! hapticmark");
  } else if (ending == ".mkv") {
    write_container(part, track, HAPTIC_TEXT_TYPE " ! matroskamux ! hapticmark");
  } else if (ending == ".klv" || ending == ".txt" || ending == ".hmpg" || ending == ".hjif") {
    std::ofstream file(part, std::ios::binary);
    file << bytes_of(track, ending) << std::flush;
    if (!file)
      discard_output(part, path);
  } else {
    throw_error(messages::kOutputFormIsUnknown, path.c_str());
  }
  if (std::rename(part.c_str(), path.c_str()) != 0)
    discard_output(part, path);
}

} // namespace haptic
