// SPDX-License-Identifier: LGPL-2.1-or-later
#include "program/film-file.hpp"

#include <csignal>
#include <cstdio>
#include <gst/app/gstappsrc.h>

namespace film {

namespace {

volatile std::sig_atomic_t interrupted = 0;

void need_element(const char *name, const char *cure) {
  GstElementFactory *factory = gst_element_factory_find(name);
  if (!factory)
    throw FilmError(std::string("GStreamer does not find the element ") + name + "; " + cure);
  gst_object_unref(factory);
}

haptic::CapsPtr caps_of(const std::string &text) {
  return haptic::CapsPtr(gst_caps_from_string(text.c_str()));
}

haptic::ElementPtr source_of(GstElement *pipeline, const char *name, const std::string &caps,
                             std::uint64_t most_bytes) {
  haptic::ElementPtr source(gst_bin_get_by_name(GST_BIN(pipeline), name));
  g_object_set(source.get(), "format", GST_FORMAT_TIME, "caps", caps_of(caps).get(), "block", TRUE,
               "max-bytes", most_bytes, nullptr);
  return source;
}

void end_source(GstElement *source) {
  gst_app_src_end_of_stream(GST_APP_SRC(source));
}

} // namespace

FilmFile::FilmFile(const std::string &path, int width, int height, int rate, int quality)
    : path_(path), part_(path + ".part"), rate_(rate) {
  for (const int signal : {SIGINT, SIGTERM})
    std::signal(signal, [](int) { interrupted = 1; });
  need_element("x264enc", "as root run: apt-get install gstreamer1.0-plugins-ugly");
  need_element("h264parse", "as root run: apt-get install gstreamer1.0-plugins-bad");
  need_element("hapticconvert", "run it by: meson devenv -C build wind-film");
  const bool matroska = path.ends_with(".mkv");
  const std::string line =
      "appsrc name=film ! x264enc name=encoder ! h264parse ! queue ! mux. "
      "appsrc name=track ! hapticconvert ! " +
      std::string(matroska ? "text/x-raw ! queue max-size-time=0 ! mux. matroskamux"
                           : "meta/x-klv ! queue max-size-time=0 ! mux. mpegtsmux") +
      " name=mux ! hapticmark ! filesink name=file";
  GError *error = nullptr;
  pipeline_.reset(gst_parse_launch(line.c_str(), &error));
  const haptic::ErrorPtr owned(error);
  if (error)
    throw FilmError(std::string(error->message) + "; install all packages that demo.sh lists");
  const haptic::ElementPtr encoder(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "encoder"));
  gst_util_set_object_arg(G_OBJECT(encoder.get()), "speed-preset", "superfast");
  gst_util_set_object_arg(G_OBJECT(encoder.get()), "pass", "qual");
  // Without a buffer that is checked: its usual 2 Mbit/s would limit every quality.
  g_object_set(encoder.get(), "quantizer", static_cast<guint>(quality), "vbv-buf-capacity", 0U,
               "key-int-max", rate, nullptr);
  const haptic::ElementPtr file(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "file"));
  g_object_set(file.get(), "location", part_.c_str(), nullptr);
  const std::string size = ", width=" + std::to_string(width) +
                           ", height=" + std::to_string(height) +
                           ", framerate=" + std::to_string(rate) + "/1, pixel-aspect-ratio=1/1";
  constexpr std::uint64_t kFrames = 8;
  film_ =
      source_of(pipeline_.get(), "film", "video/x-raw, format=I420, colorimetry=bt709" + size,
                kFrames * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height));
  track_ = source_of(pipeline_.get(), "track", HAPTIC_FIELD_CAPS + size, 0);
  bus_.reset(gst_element_get_bus(pipeline_.get()));
  // After an error nothing empties the sources: their end wakes a thread that waits in push().
  gst_bus_set_sync_handler(
      bus_.get(),
      [](GstBus *, GstMessage *message, gpointer data) noexcept {
        const auto &self = *static_cast<FilmFile *>(data);
        if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR)
          for (const haptic::ElementPtr *source : {&self.film_, &self.track_})
            end_source(source->get());
        return GST_BUS_PASS;
      },
      this, nullptr);
  if (gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING) == GST_STATE_CHANGE_FAILURE)
    throw_error();
}

FilmFile::~FilmFile() {
  if (pipeline_)
    gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  std::remove(part_.c_str());
}

void FilmFile::throw_error() {
  const haptic::MessagePtr message(gst_bus_pop_filtered(bus_.get(), GST_MESSAGE_ERROR));
  GError *error = nullptr;
  if (message)
    gst_message_parse_error(message.get(), &error, nullptr);
  const haptic::ErrorPtr owned(error);
  throw FilmError(std::string(error ? error->message : "the film could not be written") +
                  " Give another name, or make room on the disk.");
}

void FilmFile::push(GstElement *source, haptic::BufferPtr buffer) {
  const auto second = static_cast<guint64>(rate_);
  GST_BUFFER_PTS(buffer.get()) = gst_util_uint64_scale(count_, GST_SECOND, second);
  GST_BUFFER_DURATION(buffer.get()) =
      gst_util_uint64_scale(count_ + 1, GST_SECOND, second) - GST_BUFFER_PTS(buffer.get());
  if (gst_app_src_push_buffer(GST_APP_SRC(source), buffer.release()) != GST_FLOW_OK)
    throw_error();
}

void FilmFile::write(std::span<const std::uint8_t> frame, const haptic::MotionField &field) {
  if (interrupted)
    throw FilmError("interrupted: there is no film; run the command again");
  haptic::BufferPtr motion(gst_buffer_new_allocate(nullptr, haptic::packed_size(field), nullptr));
  GstMapInfo map;
  gst_buffer_map(motion.get(), &map, GST_MAP_WRITE);
  haptic::pack_motion_field(field, {map.data, map.size});
  gst_buffer_unmap(motion.get(), &map);
  push(track_.get(), std::move(motion));
  push(film_.get(), haptic::BufferPtr(gst_buffer_new_memdup(frame.data(), frame.size())));
  ++count_;
  const haptic::MessagePtr message(gst_bus_peek(bus_.get()));
  if (message && GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_ERROR)
    throw_error();
}

void FilmFile::finish() {
  end_source(film_.get());
  end_source(track_.get());
  const haptic::MessagePtr message(
      gst_bus_timed_pop_filtered(bus_.get(), GST_CLOCK_TIME_NONE,
                                 static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
  if (GST_MESSAGE_TYPE(message.get()) == GST_MESSAGE_ERROR) {
    gst_bus_post(bus_.get(), gst_message_ref(message.get()));
    throw_error();
  }
  gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  if (std::rename(part_.c_str(), path_.c_str()) != 0)
    throw FilmError("'" + path_ + "' cannot be written; give another name");
}

} // namespace film
