// SPDX-License-Identifier: LGPL-2.1-or-later
// How much of a processor hapticarray takes, and what it adds to the latency of a live stream. Run
// by hand on an idle machine:
//   meson devenv -C BUILD tests/measure/benchmarks/hapticarray-element
// Targets: 64 channels at 48 kHz <= 5 % of a core; <= 20 ms added.
#include "glue/gst-raii.hpp"
#include "processor.hpp"
#include "samples/motion-field.hpp"

#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <gst/app/gstappsrc.h>
#include <string>
#include <unistd.h>
#include <vector>

namespace {

constexpr GstClockTime kFrame = GST_SECOND / 30;
constexpr int kSeconds = 60; // of sound

// A jacket of eight columns and eight rows.
std::string write_jacket() {
  std::string path = "/tmp/hapticarray-benchmark-" + std::to_string(getpid()) + ".ini";
  std::ofstream file(path);
  file << "[array]\nunit=cm\ncarrier=160\n";
  for (int i = 0; i < 64; ++i)
    file << "[actuator-" << i + 1 << "]\nx=" << 5 * (i % 8) << "\ny=" << 5 * (i / 8) << "\n";
  return path;
}

// Everything swings, so that each actuator vibrates.
std::vector<std::uint8_t> field_at(int frame) {
  haptic::MotionField field;
  field.interval = kFrame;
  field.frame_width = 352;
  field.frame_height = 288;
  field.columns = 32;
  field.rows = 24;
  const auto speed = static_cast<float>(100 * std::sin(0.1 * frame));
  field.cells.assign(std::size_t{32} * 24, {speed, 20, 1});
  std::vector<std::uint8_t> bytes(haptic::packed_size(field));
  haptic::pack_motion_field(field, bytes);
  return bytes;
}

double processor_time() { // s, of this process
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void push_fields(GstElement *in) {
  for (int i = 0; i < kSeconds * 30; ++i) {
    const auto bytes = field_at(i);
    GstBuffer *buffer = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
    gst_buffer_fill(buffer, 0, bytes.data(), bytes.size());
    GST_BUFFER_PTS(buffer) = static_cast<GstClockTime>(i) * kFrame;
    GST_BUFFER_DURATION(buffer) = kFrame;
    gst_app_src_push_buffer(GST_APP_SRC(in), buffer);
  }
  gst_app_src_end_of_stream(GST_APP_SRC(in));
}

// Processor time for a second of sound.
double share_of_core(const std::string &layout, const char *map) {
  const std::string line =
      "appsrc name=in format=time max-bytes=0 caps=\"" HAPTIC_FIELD_CAPS "\" ! hapticarray map=" +
      std::string(map) + " layout=" + layout + " ! audio/x-raw,rate=48000 ! fakesink sync=false";
  const haptic::ElementPtr pipeline(gst_parse_launch(line.c_str(), nullptr));
  const haptic::ElementPtr in(gst_bin_get_by_name(GST_BIN(pipeline.get()), "in"));
  push_fields(in.get());
  const haptic::BusPtr bus(gst_element_get_bus(pipeline.get()));
  const double begin = processor_time();
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const haptic::MessagePtr end(
      gst_bus_timed_pop_filtered(bus.get(), GST_CLOCK_TIME_NONE,
                                 static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR)));
  const double taken = processor_time() - begin;
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  return GST_MESSAGE_TYPE(end.get()) == GST_MESSAGE_EOS ? taken / kSeconds : 1;
}

// What the latency query of a live pipeline says, ms. A camera of this kind has none of its own.
double live_latency() {
  const haptic::ElementPtr pipeline(gst_parse_launch(
      "videotestsrc is-live=true ! video/x-raw,width=352,height=288,framerate=30/1 ! roitracker ! "
      "velocityavg ! identity name=before ! hapticarray ! fakesink name=out",
      nullptr));
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  gst_element_get_state(pipeline.get(), nullptr, nullptr, GST_CLOCK_TIME_NONE);
  const auto latency = [&](const char *name, const char *pad_name) {
    const haptic::ElementPtr element(gst_bin_get_by_name(GST_BIN(pipeline.get()), name));
    const haptic::PadPtr pad(gst_element_get_static_pad(element.get(), pad_name));
    const haptic::QueryPtr query(gst_query_new_latency());
    GstClockTime least = 0;
    if (gst_pad_peer_query(pad.get(), query.get()))
      gst_query_parse_latency(query.get(), nullptr, &least, nullptr);
    return static_cast<double>(least) / GST_MSECOND;
  };
  const double added = latency("out", "sink") - latency("before", "sink");
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  return added;
}

} // namespace

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  const std::string layout = write_jacket();
  const double field = share_of_core(layout, "field");
  const double stroke = share_of_core(layout, "stroke");
  unlink(layout.c_str());
  const double latency = live_latency();
  std::printf("%s, %ld processors, compiler %s\n", test::processor().c_str(),
              sysconf(_SC_NPROCESSORS_ONLN), __VERSION__);
  std::printf("64 channels, map=field   %5.2f %% of a core\n", 100 * field);
  std::printf("64 channels, map=stroke  %5.2f %% of a core\n", 100 * stroke);
  std::printf("latency added, live      %5.2f ms\n", latency);
  return field <= 0.05 && stroke <= 0.05 && latency <= 20 ? EXIT_SUCCESS : EXIT_FAILURE;
}
