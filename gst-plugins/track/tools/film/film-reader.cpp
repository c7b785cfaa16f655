// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/film-reader.hpp"

#include "film/pipeline.hpp"
#include "glue/display-orientation.hpp"
#include "glue/gst-raii.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <filesystem>
#include <gst/app/gstappsink.h>
#include <gst/pbutils/pbutils.h>
#include <mutex>
#include <span>
#include <string_view>

namespace haptic {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr char kSideways[] = "frames that lie on their side";
constexpr guint kQueued = 256; // frames of a stream that wait to be read

// Sampling rates of AAC by their index, Hz (ISO/IEC 14496-3, table 1.18).
constexpr std::array<int, 13> kRates = {96000, 88200, 64000, 48000, 44100, 32000, 24000,
                                        22050, 16000, 12000, 11025, 8000,  7350};

// Types of NAL units (ITU-T H.264, table 7-1).
constexpr unsigned kIdr = 5;
constexpr unsigned kSequenceSet = 7;
constexpr unsigned kPictureSet = 8;
constexpr unsigned kDelimiter = 9;
constexpr unsigned kFiller = 12;

unsigned type_of_unit(Bytes unit) {
  return unit.empty() ? 0 : unit[0] & 0x1FU;
}

std::uint32_t read_number(Bytes bytes, std::size_t &at, std::size_t size) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < size && at < bytes.size(); ++i)
    number = number << 8 | bytes[at++];
  return number;
}

// Returns what stands behind a length of `size` bytes, as much as there is.
Bytes read_unit(Bytes bytes, std::size_t &at, std::size_t size) {
  const std::size_t length = read_number(bytes, at, size);
  const Bytes unit = bytes.subspan(at, std::min(length, bytes.size() - at));
  at += unit.size();
  return unit;
}

// Reads the parameter sets of AVCDecoderConfigurationRecord (ISO/IEC 14496-15, 5.3.3.1). Returns
// the size of the lengths before the NAL units, 0 if it is damaged.
std::size_t read_configuration(Bytes bytes, FilmFormat &format) {
  if (bytes.size() < 7)
    return 0;
  std::size_t at = 5;
  format.sequence_sets.clear();
  format.picture_sets.clear();
  const auto read_sets = [&](unsigned mask, auto &sets) {
    for (std::uint32_t count = read_number(bytes, at, 1) & mask; count > 0; --count) {
      const Bytes unit = read_unit(bytes, at, 2);
      sets.emplace_back(unit.begin(), unit.end());
    }
  };
  read_sets(0x1F, format.sequence_sets);
  read_sets(0xFF, format.picture_sets);
  if (format.sequence_sets.empty() || format.sequence_sets[0].size() < 4 ||
      format.picture_sets.empty())
    return 0;
  return (bytes[4] & 3U) + 1U;
}

std::vector<std::uint8_t> codec_data_of(const GstStructure *structure) {
  const GValue *value = gst_structure_get_value(structure, "codec_data");
  if (!value || !GST_VALUE_HOLDS_BUFFER(value))
    return {};
  const ReadableBuffer readable(gst_value_get_buffer(value));
  return readable ? std::vector(readable.bytes().begin(), readable.bytes().end())
                  : std::vector<std::uint8_t>();
}

std::string text_of(const GstStructure *structure, const char *field) {
  const char *text = gst_structure_get_string(structure, field);
  return text ? text : "";
}

// Returns what of the video no browser plays, or nothing.
std::string unplayable(const GstStructure *caps) {
  constexpr std::array<std::string_view, 7> kProfiles = {
      "constrained-baseline", "baseline",         "main", "high",
      "progressive-high",     "constrained-high", ""};
  const std::string profile = text_of(caps, "profile");
  if (std::ranges::find(kProfiles, profile) == kProfiles.end())
    return "H.264 of the profile " + profile;
  const std::string chroma = text_of(caps, "chroma-format");
  if (!chroma.empty() && chroma != "4:2:0")
    return "frames of the colour format " + chroma;
  const std::string interlacing = text_of(caps, "interlace-mode");
  const std::string coded = text_of(caps, "coded-picture-structure");
  if ((!interlacing.empty() && interlacing != "progressive") ||
      (!coded.empty() && coded != "frame"))
    return "interlaced frames";
  return {};
}

} // namespace

struct FilmReader::State {
  std::string path;
  ElementPtr pipeline;
  BusPtr bus;
  GstElement *video_sink = nullptr; // of the pipeline
  GstElement *sound_sink = nullptr;
  std::atomic<bool> has_video = false; // their sinks are linked
  std::atomic<bool> has_sound = false;
  std::mutex mutex;
  std::string problem;               // guarded by mutex: the whole error
  std::vector<std::string> left_out; // guarded by mutex
  FilmFormat format;
  std::size_t length_size = 4; // bytes
  std::vector<std::uint8_t> configuration;
  std::deque<FilmFrame> frames;
  bool over = false;

  void refuse(const std::string &why) {
    const std::lock_guard lock(mutex);
    if (problem.empty())
      problem = why;
  }
  void link(GstPad *pad);
  void read_video_format(const GstStructure *caps);
  void read_sound_format(const GstStructure *caps);
  void append_video(GstBuffer *buffer, std::int64_t time);
  void append(GstSample *sample, bool is_sound);
  bool pull(GstElement *sink, bool is_sound);
  void read_bus();
  bool ended() const;
};

namespace {

// Links the pad to parser and sink, or to a fakesink.
void link_to(GstElement *pipeline, GstPad *pad, const char *parser, GstElement *sink) {
  GstElement *first = parser ? add_element(pipeline, parser) : sink;
  if (parser) {
    gst_bin_add(GST_BIN(pipeline), sink);
    gst_element_link(first, sink);
  }
  const PadPtr to(gst_element_get_static_pad(first, "sink"));
  gst_pad_link(pad, to.get());
  gst_element_sync_state_with_parent(sink);
  gst_element_sync_state_with_parent(first);
}

GstElement *make_sink(const char *form) {
  GstElement *sink = gst_element_factory_make("appsink", nullptr);
  const CapsPtr caps(gst_caps_from_string(form));
  g_object_set(sink, "caps", caps.get(), "sync", FALSE, "async", FALSE, "max-buffers", kQueued,
               nullptr);
  return GST_ELEMENT(gst_object_ref_sink(sink));
}

} // namespace

// The first video and the first sound are read. A browser shows no rotation of these containers.
void FilmReader::State::link(GstPad *pad) {
  CapsPtr caps(gst_pad_get_current_caps(pad));
  if (!caps)
    caps.reset(gst_pad_query_caps(pad, nullptr));
  const GstStructure *structure = gst_caps_get_structure(caps.get(), 0);
  const std::string name = gst_structure_get_name(structure);
  const CapsPtr aac(gst_caps_from_string("audio/mpeg,mpegversion={2,4}"));
  // Of caps that a parser has yet to complete there is no description.
  const GCharPtr codec(
      gst_caps_is_fixed(caps.get()) ? gst_pb_utils_get_codec_description(caps.get()) : nullptr);
  const char *what = codec ? codec.get() : name.c_str();
  if (name.starts_with("video/") && !has_video.exchange(true)) {
    if (name == "video/x-h264")
      return link_to(pipeline.get(), pad, "h264parse", video_sink);
    refuse(format_text(messages::kBrowserLacksVideo, path.c_str(), what));
  } else if (name.starts_with("audio/") && !has_sound) {
    if (gst_caps_can_intersect(caps.get(), aac.get())) {
      has_sound = true;
      return link_to(pipeline.get(), pad, "aacparse", sound_sink);
    }
    refuse(format_text(messages::kBrowserLacksSound, path.c_str(), what));
  } else if (!name.starts_with("meta/")) {
    const std::lock_guard lock(mutex);
    left_out.push_back(name);
  }
  GstElement *rest = add_element(pipeline.get(), "fakesink");
  g_object_set(rest, "sync", FALSE, "async", FALSE, nullptr);
  link_to(pipeline.get(), pad, nullptr, rest);
}

void FilmReader::State::read_video_format(const GstStructure *caps) {
  const auto data = codec_data_of(caps);
  if (data == configuration)
    return;
  if (!configuration.empty())
    throw_error(messages::kFilmChanges, path.c_str());
  if (const std::string what = unplayable(caps); !what.empty())
    throw_error(messages::kBrowserLacksVideo, path.c_str(), what.c_str());
  configuration = data;
  length_size = read_configuration(configuration, format);
  if (length_size == 0)
    throw_error(messages::kBrowserLacksVideo, path.c_str(), "a damaged head of H.264");
  gst_structure_get_int(caps, "width", &format.width);
  gst_structure_get_int(caps, "height", &format.height);
  gst_structure_get_fraction(caps, "pixel-aspect-ratio", &format.pixel_aspect_n,
                             &format.pixel_aspect_d);
  gint n = 0;
  gint d = 1;
  if (gst_structure_get_fraction(caps, "framerate", &n, &d) && d > 0)
    format.frame_rate = static_cast<double>(n) / d;
}

void FilmReader::State::read_sound_format(const GstStructure *caps) {
  format.sound = codec_data_of(caps);
  gst_structure_get_int(caps, "channels", &format.sound_channels);
  // A frame in a transport stream has room for a known rate and number of channels only.
  const std::size_t rate =
      format.sound.size() < 2 ? kRates.size() : (format.sound[0] & 7U) << 1 | format.sound[1] >> 7;
  if (rate >= kRates.size() || (format.sound[1] >> 3 & 0xFU) == 0)
    throw_error(messages::kBrowserLacksSound, path.c_str(), "AAC of an uncommon form");
  format.sound_rate = kRates.at(rate);
}

void FilmReader::State::append_video(GstBuffer *buffer, std::int64_t time) {
  const ReadableBuffer readable(buffer);
  if (!readable)
    return;
  FilmFrame frame;
  frame.time = time;
  for (std::size_t at = 0; at < readable.bytes().size();) {
    const Bytes unit = read_unit(readable.bytes(), at, length_size);
    const unsigned type = type_of_unit(unit);
    if (unit.empty() || type == kSequenceSet || type == kPictureSet || type == kDelimiter ||
        type == kFiller)
      continue;
    frame.is_idr = frame.is_idr || type == kIdr;
    auto out = frame.bytes.size();
    frame.bytes.resize(out + 4 + unit.size());
    for (const unsigned shift : {24U, 16U, 8U, 0U})
      frame.bytes[out++] = static_cast<std::uint8_t>(unit.size() >> shift);
    std::ranges::copy(unit, &frame.bytes[out]);
  }
  if (!frame.bytes.empty())
    frames.push_back(std::move(frame));
}

void FilmReader::State::append(GstSample *sample, bool is_sound) {
  GstBuffer *buffer = gst_sample_get_buffer(sample);
  const GstStructure *caps = gst_caps_get_structure(gst_sample_get_caps(sample), 0);
  if (!is_sound)
    read_video_format(caps);
  else if (format.sound.empty())
    read_sound_format(caps);
  const GstSegment *segment = gst_sample_get_segment(sample);
  if (GST_CLOCK_TIME_IS_VALID(segment->stop) && GST_BUFFER_PTS_IS_VALID(buffer) &&
      GST_BUFFER_PTS(buffer) >= segment->stop)
    return;
  guint64 time = 0;
  const gint sign =
      GST_BUFFER_PTS_IS_VALID(buffer)
          ? gst_segment_to_stream_time_full(segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer), &time)
          : 0;
  if (sign == 0)
    throw_error(messages::kFilmHasNoTimes, path.c_str());
  const std::int64_t signed_time = sign * static_cast<std::int64_t>(time);
  if (!is_sound)
    return append_video(buffer, signed_time);
  if (const ReadableBuffer readable(buffer); readable)
    frames.push_back(
        {true, false, signed_time, {readable.bytes().begin(), readable.bytes().end()}});
}

bool FilmReader::State::pull(GstElement *sink, bool is_sound) {
  const SamplePtr sample(gst_app_sink_try_pull_sample(GST_APP_SINK(sink), 0));
  if (sample)
    append(sample.get(), is_sound);
  return sample != nullptr;
}

bool FilmReader::State::ended() const {
  return (!has_video || gst_app_sink_is_eos(GST_APP_SINK(video_sink))) &&
         (!has_sound || gst_app_sink_is_eos(GST_APP_SINK(sound_sink)));
}

// Waits a moment for a message.
void FilmReader::State::read_bus() {
  {
    const std::lock_guard lock(mutex);
    if (!problem.empty())
      throw TrackFileError(problem);
  }
  const MessagePtr message(gst_bus_timed_pop_filtered(
      bus.get(), GST_MSECOND,
      static_cast<GstMessageType>(GST_MESSAGE_ERROR | GST_MESSAGE_EOS | GST_MESSAGE_TAG)));
  if (!message)
    return;
  if (GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_ERROR)
    throw_error("\"%s\": %s", path.c_str(), error_of(message.get()).c_str());
  if (GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_EOS) {
    over = true;
    return;
  }
  GstTagList *tags = nullptr;
  gst_message_parse_tag(message.get(), &tags);
  gchar *text = nullptr;
  gst_tag_list_get_string(tags, GST_TAG_IMAGE_ORIENTATION, &text);
  const GCharPtr rotation(text);
  gst_tag_list_unref(tags);
  if (rotation && !g_str_equal(text, "rotate-0"))
    throw_error(messages::kBrowserLacksVideo, path.c_str(), kSideways);
}

FilmReader::FilmReader(const std::string &path) : state_(std::make_unique<State>()) {
  State &state = *state_;
  state.path = path;
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    throw_error(messages::kFileIsMissing, path.c_str());
  if (!std::filesystem::is_regular_file(path, error))
    throw_error(messages::kFileIsNone, path.c_str());
  if (!orientation_in(path).empty())
    throw_error(messages::kBrowserLacksVideo, path.c_str(), kSideways);
  state.pipeline = make_pipeline();
  state.bus.reset(gst_element_get_bus(state.pipeline.get()));
  state.video_sink = make_sink("video/x-h264,stream-format=avc,alignment=au");
  // What an edit list hides before the first shown frame, this frame depends on.
  gst_base_sink_set_drop_out_of_segment(GST_BASE_SINK(state.video_sink), FALSE);
  state.sound_sink = make_sink("audio/mpeg,stream-format=raw");
  GstElement *source = add_element(state.pipeline.get(), "filesrc");
  GstElement *parse = add_element(state.pipeline.get(), "parsebin");
  g_object_set(source, "location", path.c_str(), nullptr);
  gst_element_link(source, parse);
  g_signal_connect(parse, "pad-added", G_CALLBACK(+[](GstElement *, GstPad *pad, gpointer data) {
                     auto &all = *static_cast<State *>(data);
                     try {
                       all.link(pad);
                     } catch (const std::exception &failure) {
                       all.refuse(failure.what());
                     }
                   }),
                   &state);
  gst_element_set_state(state.pipeline.get(), GST_STATE_PLAYING);
}

FilmReader::~FilmReader() {
  gst_element_set_state(state_->pipeline.get(), GST_STATE_NULL);
  gst_object_unref(state_->video_sink);
  gst_object_unref(state_->sound_sink);
}

std::optional<FilmFrame> FilmReader::next() {
  State &state = *state_;
  while (state.frames.empty() && !(state.over && state.ended())) {
    bool pulled = state.has_video && state.pull(state.video_sink, false);
    pulled = (state.has_sound && state.pull(state.sound_sink, true)) || pulled;
    if (!pulled)
      state.read_bus();
    if (!pulled && state.over)
      break;
  }
  if (state.frames.empty()) {
    if (!state.has_video)
      throw_error("\"%s\": %s", state.path.c_str(),
                  format_text(messages::kVideoIsMissing, "").c_str());
    const std::lock_guard lock(state.mutex);
    state.format.left_out = state.left_out;
    return std::nullopt;
  }
  FilmFrame frame = std::move(state.frames.front());
  state.frames.pop_front();
  return frame;
}

const FilmFormat &FilmReader::format() const noexcept {
  return state_->format;
}

std::string codecs_of(const FilmFormat &format) {
  const auto &set = format.sequence_sets.at(0); // its header, profile, constraints, level
  const unsigned object = format.sound.empty() ? 0U : format.sound[0] >> 3;
  const std::string video = format_text("avc1.%02X%02X%02X", set[1], set[2], set[3]);
  return format.sound.empty() ? video : video + format_text(",mp4a.40.%u", object);
}

} // namespace haptic
