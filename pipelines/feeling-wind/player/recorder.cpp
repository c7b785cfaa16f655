// SPDX-License-Identifier: LGPL-2.1-or-later
#include "player/recorder.hpp"

#include <atomic>
#include <gst/app/gstappsrc.h>

namespace program {

using haptic::BufferPtr;
using haptic::BusPtr;
using haptic::CapsPtr;
using haptic::ElementPtr;
using haptic::ErrorPtr;
using haptic::EventPtr;
using haptic::MessagePtr;
using haptic::PadPtr;

namespace {

// An encoder that is too slow loses frames and does not delay the hand. 60 frames of 1920x1080 fit
// into 256 MiB.
constexpr const char *kFilm =
    "appsrc name=film format=time max-buffers=60 max-bytes=268435456 leaky-type=downstream ! "
    "videoconvert ! "
    "video/x-raw,format=I420 ! x264enc tune=zerolatency speed-preset=veryfast key-int-max=30 ! "
    "h264parse ! queue ! mux. ";
constexpr const char *kTrack = "appsrc name=track format=time max-bytes=0 ! hapticconvert ! ";
constexpr const char *kSoundInput = "appsrc name=sound format=time max-bytes=0 ! audioconvert ! "
                                    "audioresample ! avenc_aac ! aacparse ! queue ! mux. ";
constexpr GstClockTime kPatience = 10 * GST_SECOND; // for the encoder at the end

// The muxer of MPEG-TS fails at an input that never had anything. The sound of a film may have
// ended, or be under way, when a recording begins: then a moment of silence stands for it.
void end_input(GstAppSrc *input) {
  const CapsPtr known(gst_app_src_get_caps(input));
  if (!known && g_str_equal(GST_OBJECT_NAME(input), "sound")) {
    constexpr gsize kFrames = 1024; // of an AAC packet
    const CapsPtr caps(
        gst_caps_from_string("audio/x-raw,format=F32LE,layout=interleaved,rate=48000,channels=1"));
    gst_app_src_set_caps(input, caps.get());
    GstBuffer *silence = gst_buffer_new_allocate(nullptr, kFrames * sizeof(float), nullptr);
    gst_buffer_memset(silence, 0, 0, kFrames * sizeof(float));
    GST_BUFFER_PTS(silence) = 0;
    GST_BUFFER_DURATION(silence) = gst_util_uint64_scale(kFrames, GST_SECOND, 48000);
    gst_app_src_push_buffer(input, silence);
  }
  gst_app_src_end_of_stream(input);
}

bool ends_in(const std::string &text, const char *ending) {
  return g_str_has_suffix(text.c_str(), ending);
}

} // namespace

// What the taps of one recording share.
struct Recorder::Shared {
  std::atomic<GstClockTime> start = GST_CLOCK_TIME_NONE; // running time of the first frame
};

// Copies the buffers of a pad of the player to an input of the recording, and its end: sound may be
// shorter than the film, and a muxer waits for each of its inputs.
struct Recorder::Tap {
  std::shared_ptr<Shared> shared;
  ElementPtr input;
  bool is_film;
  bool has_caps = false; // streaming thread of the pad

  void push(GstPad *pad, GstBuffer *buffer);
  void push(GstEvent *event);
};

void Recorder::Tap::push(GstEvent *event) {
  if (GST_EVENT_TYPE(event) == GST_EVENT_EOS)
    end_input(GST_APP_SRC(input.get()));
  else if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS)
    has_caps = false;
}

void Recorder::Tap::push(GstPad *pad, GstBuffer *buffer) {
  const EventPtr event(gst_pad_get_sticky_event(pad, GST_EVENT_SEGMENT, 0));
  if (!event || !GST_BUFFER_PTS_IS_VALID(buffer))
    return;
  const GstSegment *segment = nullptr;
  gst_event_parse_segment(event.get(), &segment);
  const GstClockTime time =
      gst_segment_to_running_time(segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  GstClockTime start = shared->start;
  if (is_film && !GST_CLOCK_TIME_IS_VALID(start))
    shared->start = start = time;
  if (!GST_CLOCK_TIME_IS_VALID(start) || !GST_CLOCK_TIME_IS_VALID(time) || time < start)
    return;
  if (!has_caps) {
    const CapsPtr caps(gst_pad_get_current_caps(pad));
    gst_app_src_set_caps(GST_APP_SRC(input.get()), caps.get());
    has_caps = true;
  }
  GstBuffer *copy = gst_buffer_copy(buffer);
  GST_BUFFER_PTS(copy) = time - start;
  GST_BUFFER_DTS(copy) = GST_CLOCK_TIME_NONE;
  gst_app_src_push_buffer(GST_APP_SRC(input.get()), copy);
}

std::string Recorder::start(const Player &player, const std::string &path) {
  if (pipeline_) // waiting for it would stop keys and mouse, also those that take the force off
    return "The recording before is not complete yet. Try again in some seconds.";
  const bool transport_stream = ends_in(path, ".ts");
  if (!transport_stream && !ends_in(path, ".mkv"))
    return "The name of a recording ends in .ts or .mkv.";
  const bool sound = player.has_sound();
  const std::string line = std::string(kFilm) + kTrack +
                           (transport_stream ? "meta/x-klv" : "text/x-raw") + " ! queue ! mux. " +
                           (sound ? kSoundInput : "") +
                           (transport_stream ? "mpegtsmux" : "matroskamux") +
                           " name=mux ! hapticmark ! filesink name=file";
  GError *error = nullptr;
  pipeline_.reset(
      gst_parse_launch_full(line.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, &error));
  const ErrorPtr owned(error);
  if (!pipeline_)
    return std::string("It cannot record: ") + error->message +
           ". Install the packages gstreamer1.0-plugins-bad, gstreamer1.0-plugins-ugly and "
           "gstreamer1.0-libav.";
  path_ = path;
  const ElementPtr file(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "file"));
  g_object_set(file.get(), "location", path.c_str(), nullptr);
  const BusPtr bus(gst_element_get_bus(pipeline_.get()));
  watch_ = gst_bus_add_watch(
      bus.get(),
      [](GstBus *, GstMessage *message, gpointer self) noexcept -> gboolean {
        static_cast<Recorder *>(self)->handle_message(message);
        return G_SOURCE_CONTINUE;
      },
      this);
  shared_ = std::make_shared<Shared>();
  recording_ = true;
  gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
  tap(player, "tracker", "src", "film");
  tap(player, "motion", "src", "track");
  if (sound)
    tap(player, "volume", "sink", "sound");
  return "";
}

void Recorder::tap(const Player &player, const char *element, const char *pad, const char *input) {
  const ElementPtr from = player.element(element);
  PadPtr source(gst_element_get_static_pad(from.get(), pad));
  auto *state = new Tap{shared_, ElementPtr(gst_bin_get_by_name(GST_BIN(pipeline_.get()), input)),
                        std::string(input) == "film"}; // freed with the probe
  const gulong probe = gst_pad_add_probe(
      source.get(),
      static_cast<GstPadProbeType>(GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM),
      [](GstPad *from_pad, GstPadProbeInfo *info, gpointer self) noexcept {
        auto &tap = *static_cast<Tap *>(self);
        if (info->type & GST_PAD_PROBE_TYPE_BUFFER)
          tap.push(from_pad, GST_PAD_PROBE_INFO_BUFFER(info));
        else
          tap.push(GST_PAD_PROBE_INFO_EVENT(info));
        return GST_PAD_PROBE_OK;
      },
      state, [](gpointer self) { delete static_cast<Tap *>(self); });
  probes_.emplace_back(std::move(source), probe);
}

void Recorder::stop() {
  if (!recording_)
    return;
  recording_ = false;
  for (const auto &[pad, probe] : probes_)
    gst_pad_remove_probe(pad.get(), probe);
  probes_.clear();
  for (const char *input : {"film", "track", "sound"})
    if (const ElementPtr element{gst_bin_get_by_name(GST_BIN(pipeline_.get()), input)})
      end_input(GST_APP_SRC(element.get()));
}

void Recorder::finish() {
  stop();
  if (!pipeline_)
    return;
  const BusPtr bus(gst_element_get_bus(pipeline_.get()));
  const MessagePtr message(gst_bus_timed_pop_filtered(
      bus.get(), kPatience, static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
  if (message)
    handle_message(message.get());
  else
    end("The recording " + path_ + " could not be completed in time.");
}

void Recorder::handle_message(GstMessage *message) {
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_EOS)
    return end("Recorded into " + path_ + ".");
  if (GST_MESSAGE_TYPE(message) != GST_MESSAGE_ERROR)
    return;
  GError *error = nullptr;
  gst_message_parse_error(message, &error, nullptr);
  const ErrorPtr owned(error);
  end(std::string("The recording ended: ") + error->message + " Choose another file.");
}

void Recorder::end(const std::string &sentence) {
  stop();
  if (watch_)
    g_source_remove(watch_);
  watch_ = 0;
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  pipeline_.reset();
  on_end_(sentence);
}

} // namespace program
