// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/film-reader.hpp"

#include "film/big-endian.hpp"
#include "film/copied-stream.hpp"
#include "film/film-streams.hpp"
#include "film/pipeline.hpp"
#include "glue/display-orientation.hpp"
#include "glue/gst-raii.hpp"

#include <algorithm>
#include <cstring>
#include <gst/pbutils/pbutils.h>
#include <iterator>
#include <mutex>
#include <span>
#include <utility>

namespace haptic {
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr char kSideways[] = "frames that lie on their side";

// Types of NAL units (ITU-T H.264, table 7-1).
constexpr unsigned kIdr = 5;
constexpr unsigned kSequenceSet = 7;
constexpr unsigned kPictureSet = 8;
constexpr unsigned kDelimiter = 9;
constexpr unsigned kFiller = 12;

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

// Returns what of the video no browser plays, or nothing.
std::string unplayable(const GstStructure *caps) {
  constexpr const char *kPlayed[][3] = {
      {"profile", "constrained-baseline main constrained-high progressive-high",
       "H.264 of the profile %s"},
      {"chroma-format", "4:2:0", "frames of the colour format %s"},
      {"interlace-mode", "progressive", "interlaced frames"},
      {"coded-picture-structure", "frame", "interlaced frames"}};
  for (const auto &[field, played, what] : kPlayed)
    if (const char *text = gst_structure_get_string(caps, field);
        text && !std::strstr(played, text)) // "baseline" and "high" end other names
      return format_text(what, text);
  return {};
}

// What a person calls the stream.
std::string description_of(const GstCaps *caps) {
  // Of caps that a parser has yet to complete there is no description.
  const GCharPtr codec(gst_caps_is_fixed(caps) ? gst_pb_utils_get_codec_description(caps)
                                               : nullptr);
  return codec ? codec.get() : name_of(caps);
}

// Returns the name of the codec (RFC 6381).
std::string mime_of(GstCaps *caps) {
  const GCharPtr name(gst_codec_utils_caps_get_mime_codec(caps));
  return name ? name.get() : "";
}

class Reading {
public:
  Reading(const std::string &path, const std::function<void(FilmFrame &&)> &call)
      : path_(path), call_(call), film_(path, FilmUse::copy) {}

  FilmFormat run() {
    link_video();
    link_sound();
    for (GstPad *pad : film_.others())
      leave_out(pad);
    film_.play();
    return format_;
  }

private:
  void link(GstPad *pad, const char *parser, const char *form, bool is_sound) {
    GstElement *parse = add_element(film_.pipeline(), parser);
    GstElement *filter = add_element(film_.pipeline(), "capsfilter");
    gst_util_set_object_arg(G_OBJECT(filter), "caps", form);
    link_elements(parse, filter);
    link_pad(pad, parse);
    const PadPtr out(gst_element_get_static_pad(filter, "src"));
    read_to_end(film_.pipeline(), out.get());
    watch_buffers(out.get(), [this, is_sound](GstPad *at, GstBuffer *buffer) {
      const std::lock_guard lock(mutex_);
      if (std::exchange(failed_, true)) // by an exception
        return;
      push(at, buffer, is_sound);
      failed_ = false;
    });
  }

  void link_video() {
    const CapsPtr caps = caps_of(film_.video());
    if (!g_str_equal(name_of(caps.get()), "video/x-h264"))
      throw_error(messages::kBrowserLacksVideo, path_.c_str(), description_of(caps.get()).c_str());
    // A browser shows no rotation of these containers.
    watch_events(film_.video(), [this](GstPad *, GstEvent *event) {
      if (const std::string turn = rotation_of(event); !turn.empty() && turn != "rotate-0")
        throw_error(messages::kBrowserLacksVideo, path_.c_str(), kSideways);
    });
    link(film_.video(), "h264parse", "video/x-h264,stream-format=avc,alignment=au", false);
  }

  // The first sound is read.
  void link_sound() {
    const CapsPtr aac(gst_caps_from_string("audio/mpeg,mpegversion={2,4}"));
    for (GstPad *pad : film_.audio()) {
      const CapsPtr caps = caps_of(pad);
      if (pad != film_.audio().front())
        leave_out(pad);
      else if (gst_caps_can_intersect(caps.get(), aac.get()))
        link(pad, "aacparse", "audio/mpeg,stream-format=raw", true);
      else
        throw_error(messages::kBrowserLacksSound, path_.c_str(),
                    description_of(caps.get()).c_str());
    }
  }

  void leave_out(GstPad *pad) {
    if (const std::string name = name_of(caps_of(pad).get()); !name.starts_with("meta/"))
      format_.left_out.push_back(name);
    read_to_end(film_.pipeline(), pad);
  }

  void read_video_format(GstCaps *all) {
    const GstStructure *caps = gst_caps_get_structure(all, 0);
    const auto data = codec_data_of(caps);
    if (data == configuration_)
      return;
    if (!configuration_.empty())
      throw_error(messages::kFilmChanges, path_.c_str());
    if (const std::string what = unplayable(caps); !what.empty())
      throw_error(messages::kBrowserLacksVideo, path_.c_str(), what.c_str());
    configuration_ = data;
    length_size_ = read_configuration(configuration_, format_);
    if (length_size_ == 0)
      throw_error(messages::kBrowserLacksVideo, path_.c_str(), "a damaged head of H.264");
    format_.video_codec = mime_of(all);
    gst_structure_get_int(caps, "width", &format_.width);
    gst_structure_get_int(caps, "height", &format_.height);
    gst_structure_get_fraction(caps, "pixel-aspect-ratio", &format_.pixel_aspect_n,
                               &format_.pixel_aspect_d);
    gint n = 0;
    gint d = 1;
    if (gst_structure_get_fraction(caps, "framerate", &n, &d) && d > 0)
      format_.frame_rate = static_cast<double>(n) / d;
  }

  void read_sound_format(GstCaps *caps) {
    const GstStructure *structure = gst_caps_get_structure(caps, 0);
    format_.sound = codec_data_of(structure);
    format_.sound_codec = mime_of(caps);
    gst_structure_get_int(structure, "channels", &format_.sound_channels);
    // A frame in a transport stream has room for a known rate and number of channels only.
    const guint8 *data = format_.sound.data();
    const auto size = static_cast<guint>(format_.sound.size());
    if (size >= 2 && (data[0] & 7U) != 7 && gst_codec_utils_aac_get_channels(data, size) > 0)
      format_.sound_rate = static_cast<int>(gst_codec_utils_aac_get_sample_rate(data, size));
    if (format_.sound_rate == 0)
      throw_error(messages::kBrowserLacksSound, path_.c_str(), "AAC of an uncommon form");
  }

  void push_video(GstBuffer *buffer, std::int64_t time) {
    const ReadableBuffer readable(buffer);
    if (!readable)
      return;
    FilmFrame frame;
    frame.time = time;
    for (std::size_t at = 0; at < readable.bytes().size();) {
      const Bytes unit = read_unit(readable.bytes(), at, length_size_);
      const unsigned type = unit.empty() ? 0 : unit[0] & 0x1FU;
      if (unit.empty() || type == kSequenceSet || type == kPictureSet || type == kDelimiter ||
          type == kFiller)
        continue;
      frame.is_idr = frame.is_idr || type == kIdr;
      put_number(frame.bytes, unit.size(), 4);
      std::ranges::copy(unit, std::back_inserter(frame.bytes));
    }
    if (!frame.bytes.empty())
      call_(std::move(frame));
  }

  void push(GstPad *pad, GstBuffer *buffer, bool is_sound) {
    const CapsPtr caps = caps_of(pad);
    if (!is_sound)
      read_video_format(caps.get());
    else if (format_.sound.empty())
      read_sound_format(caps.get());
    GstSegment segment = segment_of(pad).value();
    const GstClockTime begin = GST_BUFFER_PTS(buffer);
    guint64 time = 0;
    const gint sign = GST_CLOCK_TIME_IS_VALID(begin)
                          ? gst_segment_to_stream_time_full(&segment, GST_FORMAT_TIME, begin, &time)
                          : 0;
    if (sign == 0)
      throw_error(messages::kFilmHasNoTimes, path_.c_str());
    const GstClockTime length = GST_BUFFER_DURATION(buffer);
    if (!is_sound)
      segment.start = 0; // the first shown frame depends on those that an edit list hides before it
    if (!gst_segment_clip(&segment, GST_FORMAT_TIME, begin,
                          GST_CLOCK_TIME_IS_VALID(length) ? begin + length : length, nullptr,
                          nullptr))
      return;
    const std::int64_t signed_time = sign * static_cast<std::int64_t>(time);
    if (!is_sound)
      return push_video(buffer, signed_time);
    if (const ReadableBuffer readable(buffer); readable)
      call_({true, false, signed_time, {readable.bytes().begin(), readable.bytes().end()}});
  }

  const std::string path_;
  const std::function<void(FilmFrame &&)> &call_;
  // Of the streaming threads, one at a time.
  std::mutex mutex_;
  FilmFormat format_;
  std::size_t length_size_ = 4; // bytes
  std::vector<std::uint8_t> configuration_;
  bool failed_ = false;
  FilmStreams film_;
};

} // namespace

FilmFormat read_film(const std::string &path, const std::function<void(FilmFrame &&)> &call) {
  check_readable(path);
  if (!orientation_in(path).empty())
    throw_error(messages::kBrowserLacksVideo, path.c_str(), kSideways);
  return naming(path, [&] { return Reading(path, call).run(); });
}

} // namespace haptic
