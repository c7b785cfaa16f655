// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/film-streams.hpp"

#include "film/copied-stream.hpp"
#include "film/pipeline.hpp"
#include "glue/content-only.hpp"

#include <gst/pbutils/pbutils.h>
#include <string_view>

namespace haptic {
namespace {

constexpr gint64 kLongestShow =
    gint64{10} * G_USEC_PER_SEC; // us, from the first stream to the last
constexpr GstClockTime kPollTime = 200 * GST_MSECOND;

} // namespace

// A decoder holds frames for each of its threads, so few threads limit the memory.
void FilmStreams::set_up_element(GstBin *, GstBin *, GstElement *element, gpointer data) {
  GObjectClass *properties = G_OBJECT_GET_CLASS(element);
  if (g_object_class_find_property(properties, "max-threads"))
    g_object_set(element, "max-threads", 2, nullptr);
  const GstElementFactory *factory = gst_element_get_factory(element);
  if (static_cast<FilmStreams *>(data)->use_ == FilmUse::decode && factory &&
      gst_element_factory_list_is_type(const_cast<GstElementFactory *>(factory),
                                       GST_ELEMENT_FACTORY_TYPE_PARSER) &&
      g_object_class_find_property(properties, "config-interval"))
    g_object_set(element, "config-interval", -1, nullptr);
}

FilmStreams::FilmStreams(const std::string &path, FilmUse use, const Poll &poll) : use_(use) {
  gst_init(nullptr, nullptr);
  pipeline_ = make_pipeline();
  GstElement *source = add_element(pipeline_.get(), "filesrc");
  GstElement *parse = add_element(pipeline_.get(), "parsebin");
  g_object_set(source, "location", path.c_str(), nullptr);
  open_content_only(parse, messages::kFileNamesOthers);
  link_elements(source, parse);
  g_signal_connect(parse, "pad-added", G_CALLBACK(block), this);
  g_signal_connect(parse, "autoplug-continue", G_CALLBACK(is_parsed_further), nullptr);
  g_signal_connect(parse, "unknown-type",
                   G_CALLBACK(+[](GstElement *, GstPad *, GstCaps *caps, gpointer data) {
                     static_cast<FilmStreams *>(data)->unknown_ = name_of(caps);
                   }),
                   this);
  g_signal_connect(pipeline_.get(), "deep-element-added", G_CALLBACK(set_up_element), this);
  try {
    gst_element_set_state(pipeline_.get(), GST_STATE_PAUSED);
    wait_for_streams(poll);
    sort();
  } catch (...) {
    gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
    throw;
  }
}

FilmStreams::~FilmStreams() {
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
}

// Blocks a new stream: a muxer must know all streams when it starts.
void FilmStreams::block(GstElement *, GstPad *pad, gpointer data) {
  const auto hold = [](GstPad *, GstPadProbeInfo *, gpointer) { return GST_PAD_PROBE_OK; };
  const gulong probe =
      gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BLOCK_DOWNSTREAM, hold, nullptr, nullptr);
  auto &film = *static_cast<FilmStreams *>(data);
  film.streams_.emplace_back(PadPtr(GST_PAD(gst_object_ref(pad))), probe);
  ++film.shown_;
}

std::vector<GstPad *> FilmStreams::all() const {
  std::vector<GstPad *> pads;
  for (const auto &[pad, probe] : streams_)
    pads.push_back(pad.get());
  return pads;
}

void FilmStreams::sort() {
  for (const auto &[pad, probe] : streams_) {
    const CapsPtr caps = caps_of(pad.get());
    const std::string_view name = name_of(caps.get());
    if (!video_ && (name.starts_with("video/") || name.starts_with("image/")))
      video_ = pad.get();
    else if (name.starts_with("audio/"))
      audio_.push_back(pad.get());
    else
      others_.push_back(pad.get());
  }
  if (!video_)
    throw_error(messages::kVideoIsMissing,
                unknown_.empty() ? "" : (" that is understood, only " + unknown_).c_str());
}

// Returns the first message of this type. Throws the error of the pipeline instead.
MessagePtr FilmStreams::wait_for(GstMessageType wanted, const Poll &poll) {
  const BusPtr bus(gst_element_get_bus(pipeline_.get()));
  std::string missing;
  for (;;) {
    const MessagePtr message(gst_bus_timed_pop_filtered(
        bus.get(), kPollTime,
        static_cast<GstMessageType>(wanted | GST_MESSAGE_ERROR | GST_MESSAGE_ELEMENT)));
    poll();
    if (!message)
      continue;
    const GstMessageType type = GST_MESSAGE_TYPE(message.get());
    const bool is_own = GST_MESSAGE_SRC(message.get()) == GST_OBJECT(pipeline_.get());
    if (type == GST_MESSAGE_ERROR)
      throw TrackFileError(missing.empty() || is_own ? error_of(message.get()) : missing);
    if ((type & wanted) != 0)
      return MessagePtr(gst_message_ref(message.get()));
    if (gst_is_missing_plugin_message(message.get())) {
      const GCharPtr what(gst_missing_plugin_message_get_description(message.get()));
      missing = format_text(messages::kDecoderIsMissing, what.get());
    }
  }
}

// parsebin posts the number of streams and then adds a pad for each.
void FilmStreams::wait_for_streams(const Poll &poll) {
  const MessagePtr message = wait_for(GST_MESSAGE_STREAM_COLLECTION, poll);
  GstStreamCollection *collection = nullptr;
  gst_message_parse_stream_collection(message.get(), &collection);
  const std::size_t count = gst_stream_collection_get_size(collection);
  gst_object_unref(collection);
  const gint64 latest = g_get_monotonic_time() + kLongestShow;
  while (shown_ < count && g_get_monotonic_time() < latest)
    g_usleep(1000);
  if (shown_ < count)
    throw_error(messages::kStreamsAreUnclear);
}

void FilmStreams::watch(GstPad *pad) {
  const auto count = [](GstPad *, GstPadProbeInfo *, gpointer data) {
    ++*static_cast<std::atomic<std::size_t> *>(data);
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, count, &flowed_, nullptr);
}

void FilmStreams::play(const Poll &poll, GstClockTime longest_standstill) {
  gst_bin_sync_children_states(GST_BIN(pipeline_.get()));
  for (const auto &[pad, probe] : streams_) {
    watch(pad.get());
    gst_pad_remove_probe(pad.get(), probe);
  }
  // A muxer may wait for sound, the full queue of the video for the muxer, and the demuxer for that
  // queue. Polls are counted, not seconds: a process that was stopped does not poll.
  int polls = 0;
  std::size_t flowed = 0;
  const auto poll_flow = [&] {
    poll();
    polls = flowed == flowed_ ? polls + 1 : 0;
    flowed = flowed_;
    if (polls * kPollTime > longest_standstill)
      throw_error(messages::kFilmStandsStill, static_cast<int>(longest_standstill / GST_SECOND));
  };
  gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
  try {
    wait_for(static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_APPLICATION), poll_flow);
  } catch (...) {
    gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
    throw;
  }
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
}

void read_to_end(const FilmStreams &film, GstPad *pad) {
  GstElement *sink = add_element(film.pipeline(), "fakesink");
  g_object_set(sink, "async", FALSE, "sync", FALSE, nullptr);
  link_pad(pad, sink);
}

void discard_stream(GstPad *pad) {
  gst_pad_add_probe(
      pad, GST_PAD_PROBE_TYPE_BUFFER,
      [](GstPad *, GstPadProbeInfo *, gpointer) { return GST_PAD_PROBE_DROP; }, nullptr, nullptr);
}

GstClockTime running_time_of(GstPad *pad, const GstBuffer *buffer) {
  const EventPtr event(gst_pad_get_sticky_event(pad, GST_EVENT_SEGMENT, 0));
  const GstClockTime time =
      GST_BUFFER_PTS_IS_VALID(buffer) ? GST_BUFFER_PTS(buffer) : GST_BUFFER_DTS(buffer);
  if (!event || !GST_CLOCK_TIME_IS_VALID(time))
    return GST_CLOCK_TIME_NONE;
  const GstSegment *segment = nullptr;
  gst_event_parse_segment(event.get(), &segment);
  return gst_segment_to_running_time(segment, GST_FORMAT_TIME, time);
}

} // namespace haptic
