// SPDX-License-Identifier: LGPL-2.1-or-later
// gst-launch-1.0 with another clock: CLOCK_RATE times as fast as that of the machine. Into the file
// DRIFT_LOG it writes, for each packet that a payloader sends or rtponesender gives, `sent` or
// `received`, the kind of payload (video or not), the time stamp of RTP, and the running time in s.
//
//   CLOCK_RATE=1.01 DRIFT_LOG=FILE drifting-launch -e PIPELINE...
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <glib-unix.h>
#include <gst/gst.h>
#include <gst/rtp/gstrtpbuffer.h>
#include <string>

namespace {

std::FILE *log_file = nullptr;

void write_time(GstPad *pad, GstBuffer *buffer, const char *what) {
  GstRTPBuffer rtp = GST_RTP_BUFFER_INIT;
  if (!gst_rtp_buffer_map(buffer, GST_MAP_READ, &rtp))
    return;
  GstEvent *event = gst_pad_get_sticky_event(pad, GST_EVENT_SEGMENT, 0);
  if (event) {
    const GstSegment *segment = nullptr;
    gst_event_parse_segment(event, &segment);
    const auto time = gst_segment_to_running_time(segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
    if (GST_CLOCK_TIME_IS_VALID(time))
      std::fprintf(log_file, "%s %s %u %.6f\n", what,
                   gst_rtp_buffer_get_payload_type(&rtp) == 96 ? "video" : "track",
                   gst_rtp_buffer_get_timestamp(&rtp), static_cast<double>(time) / 1e9);
    gst_event_unref(event);
  }
  gst_rtp_buffer_unmap(&rtp);
}

void log_packets(GstPad *pad, const char *what) {
  const auto type =
      static_cast<GstPadProbeType>(GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_BUFFER_LIST);
  gst_pad_add_probe(
      pad, type,
      [](GstPad *source, GstPadProbeInfo *info, gpointer user) {
        const auto *name = static_cast<const char *>(user);
        if (info->type & GST_PAD_PROBE_TYPE_BUFFER)
          write_time(source, GST_PAD_PROBE_INFO_BUFFER(info), name);
        else if (GstBufferList *list = GST_PAD_PROBE_INFO_BUFFER_LIST(info))
          for (guint i = 0; i < gst_buffer_list_length(list); ++i)
            write_time(source, gst_buffer_list_get(list, i), name);
        return GST_PAD_PROBE_OK;
      },
      const_cast<char *>(what), nullptr);
}

// The wall clock of a machine is as fast as its other clocks.
void use_clock_for_reports(GstElement *element, const std::string &name) {
  if (name == "rtpbin")
    gst_util_set_object_arg(G_OBJECT(element), "ntp-time-source", "clock-time");
}

// What the payloaders send, and what the pads recv_rtp_src_%u of the receiver give.
void prepare(GstElement *element) {
  GstElementFactory *factory = gst_element_get_factory(element);
  const std::string name = factory ? GST_OBJECT_NAME(factory) : "";
  use_clock_for_reports(element, name);
  const bool sends = name == "rtph264pay" || name == "rtpklvpay";
  if (!sends && name != "rtponesender")
    return;
  gst_element_foreach_src_pad(
      element,
      [](GstElement *, GstPad *pad, gpointer user) -> gboolean {
        if (!g_str_has_prefix(GST_OBJECT_NAME(pad), "send"))
          log_packets(pad, static_cast<const char *>(user));
        return TRUE;
      },
      const_cast<char *>(sends ? "sent" : "received"));
}

} // namespace

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  if (argc < 3 || std::strcmp(argv[1], "-e") != 0)
    return EXIT_FAILURE;
  GError *error = nullptr;
  GstElement *pipeline = gst_parse_launchv(const_cast<const gchar **>(argv + 2), &error);
  if (!pipeline || error) {
    std::fprintf(stderr, "ERROR: %s\n", error ? error->message : "no pipeline");
    return EXIT_FAILURE;
  }
  log_file = std::fopen(std::getenv("DRIFT_LOG"), "w");
  GstIterator *elements = gst_bin_iterate_recurse(GST_BIN(pipeline));
  gst_iterator_foreach(
      elements,
      [](const GValue *value, gpointer) { prepare(GST_ELEMENT(g_value_get_object(value))); },
      nullptr);
  gst_iterator_free(elements);
  auto *clock = GST_CLOCK(g_object_new(GST_TYPE_SYSTEM_CLOCK, nullptr));
  const GstClockTime now = gst_clock_get_internal_time(clock);
  const auto rate =
      static_cast<GstClockTime>(std::lround(std::atof(std::getenv("CLOCK_RATE")) * 1e6));
  gst_clock_set_calibration(clock, now, now, rate, 1'000'000);
  gst_pipeline_use_clock(GST_PIPELINE(pipeline), clock);
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  std::puts("PLAYING");
  std::fflush(stdout);
  g_unix_signal_add(
      SIGINT,
      [](gpointer user) -> gboolean {
        gst_element_send_event(GST_ELEMENT(user), gst_event_new_eos());
        return G_SOURCE_REMOVE;
      },
      pipeline);
  GMainLoop *loop = g_main_loop_new(nullptr, FALSE);
  GstBus *bus = gst_element_get_bus(pipeline);
  gst_bus_add_signal_watch(bus);
  g_signal_connect_swapped(bus, "message::eos", G_CALLBACK(g_main_loop_quit), loop);
  g_signal_connect_swapped(bus, "message::error", G_CALLBACK(g_main_loop_quit), loop);
  g_signal_connect(bus, "message::latency", G_CALLBACK(+[](GstBus *, GstMessage *, GstBin *bin) {
                     gst_bin_recalculate_latency(bin);
                   }),
                   pipeline);
  g_main_loop_run(loop);
  gst_element_set_state(pipeline, GST_STATE_NULL);
  std::fclose(log_file);
  return EXIT_SUCCESS;
}
