// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/film-streams.hpp"

#include "film/copied-stream.hpp"

#include <string_view>

namespace haptic {
namespace {

constexpr gint64 kLongestShow = 10'000'000; // us, from the first stream to the last

// Subtitles with a style stay as they are.
gboolean is_parsed_further(GstElement *, GstPad *, GstCaps *caps, gpointer) {
  const std::string_view name = name_of(caps);
  return name != "application/x-ass" && name != "application/x-ssa";
}

// A decoder holds frames for each of its threads, so few threads limit the memory.
void set_up_element(GstBin *, GstBin *, GstElement *element, gpointer is_decoded) {
  GObjectClass *properties = G_OBJECT_GET_CLASS(element);
  if (g_object_class_find_property(properties, "max-threads"))
    g_object_set(element, "max-threads", 2, nullptr);
  const GstElementFactory *factory = gst_element_get_factory(element);
  if (is_decoded && factory &&
      gst_element_factory_list_is_type(const_cast<GstElementFactory *>(factory),
                                       GST_ELEMENT_FACTORY_TYPE_PARSER) &&
      g_object_class_find_property(properties, "config-interval"))
    g_object_set(element, "config-interval", -1, nullptr);
}

} // namespace

FilmStreams::FilmStreams(const std::string &path, FilmUse use, GstClockTime longest_standstill)
    : file_(path, "parsebin") {
  GstElement *parse = file_.reader();
  g_signal_connect(parse, "pad-added", G_CALLBACK(block), this);
  g_signal_connect(parse, "autoplug-continue", G_CALLBACK(is_parsed_further), nullptr);
  g_signal_connect(parse, "unknown-type",
                   G_CALLBACK(+[](GstElement *, GstPad *, GstCaps *caps, gpointer data) {
                     static_cast<FilmStreams *>(data)->unknown_ = name_of(caps);
                   }),
                   this);
  g_signal_connect(pipeline(), "deep-element-added", G_CALLBACK(set_up_element),
                   GINT_TO_POINTER(use == FilmUse::decode));
  wait_for_streams(longest_standstill);
  sort();
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

void FilmStreams::sort() {
  for (const auto &[pad, probe] : streams_) {
    const CapsPtr caps = caps_of(pad.get());
    const std::string_view name = name_of(caps.get());
    all_.push_back(pad.get());
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

// parsebin posts the number of streams and then adds a pad for each. It drops the error of a
// demuxer that finds the damage while it starts, and nothing more is read.
void FilmStreams::wait_for_streams(GstClockTime longest) {
  const MessagePtr message = file_.run(GST_STATE_PAUSED, GST_MESSAGE_STREAM_COLLECTION,
                                       messages::kFileStandsStill, longest);
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

void FilmStreams::play(GstClockTime longest_standstill) {
  gst_bin_sync_children_states(GST_BIN(pipeline()));
  for (const auto &[pad, probe] : streams_) {
    file_.watch(pad.get());
    gst_pad_remove_probe(pad.get(), probe);
  }
  const Running running(pipeline());
  // A muxer may wait for sound, the full queue of the video for the muxer, and the demuxer for that
  // queue.
  file_.run(GST_STATE_PLAYING,
            static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_APPLICATION),
            messages::kFilmStandsStill, longest_standstill);
}

GstElement *read_to_end(GstElement *pipeline, GstPad *pad) {
  GstElement *sink = gst_element_factory_make("fakesink", nullptr);
  g_object_set(sink, "async", FALSE, "sync", FALSE, nullptr);
  gst_bin_add(GST_BIN(pipeline), sink);
  gst_pad_link(pad, PadPtr(gst_element_get_static_pad(sink, "sink")).get());
  return sink;
}

void discard_stream(GstPad *pad) {
  watch_buffers(pad, [](GstPad *, GstBuffer *) { return false; });
}

} // namespace haptic
