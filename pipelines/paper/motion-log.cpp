// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs a pipeline and logs the patches and the pointer events of its roitracker, which is named
// `tracker`. paper.sh draws the paper's figures from these logs.
//
// Usage: motion-log FOLDER LAUNCH-LINE
//   FOLDER/patches.csv   one row per patch: frame, time (s), region and patch (px), dx and dy (px)
//   FOLDER/pointers.csv  one row per upstream pointer event: time (s), x and y (0..1)
//   FOLDER/earlier.grey, FOLDER/later.grey
//                        the pair of frames with the largest mean displacement: luma, row by row
//   FOLDER/pair.csv      frame number and size of that pair
// Frames must be GRAY8 at the tracker.
#include "glue/gst-raii.hpp"
#include "glue/pointer-event.hpp"
#include "gsthapticmotionmeta.h"
#include "seconds.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <gst/video/video.h>
#include <iostream>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace {

using haptic::seconds;

struct Frame {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> grey;
};

struct Log {
  explicit Log(const std::string &into)
      : folder(into), patches(into + "/patches.csv"), pointers(into + "/pointers.csv") {
    patches << "frame,time,region_x,region_y,region_width,region_height,x,y,dx,dy\n";
    pointers << "time,x,y\n";
  }
  bool complete() { return patches.flush() && pointers.flush(); }

  const std::string folder;

  // Streaming thread.
  std::ofstream patches;
  GstSegment segment{};
  long number = 0;
  Frame previous;
  double largest_displacement = 0; // px, mean over the patches of the pair on disk
  bool pair_written = true;

  std::mutex mutex;
  std::ofstream pointers; // under the mutex: hapticsink's pointer thread writes
};

std::optional<Frame> luma(GstPad *pad, GstBuffer *buffer) {
  const haptic::CapsPtr caps(gst_pad_get_current_caps(pad));
  GstVideoInfo info;
  if (!caps || !gst_video_info_from_caps(&info, caps.get()) ||
      GST_VIDEO_INFO_FORMAT(&info) != GST_VIDEO_FORMAT_GRAY8)
    return {};
  GstVideoFrame mapped;
  if (!gst_video_frame_map(&mapped, &info, buffer, GST_MAP_READ))
    return {};
  Frame frame{GST_VIDEO_INFO_WIDTH(&info), GST_VIDEO_INFO_HEIGHT(&info), {}};
  const auto *pixels = static_cast<const std::uint8_t *>(GST_VIDEO_FRAME_PLANE_DATA(&mapped, 0));
  for (int y = 0; y < frame.height; ++y) {
    const auto *row = pixels + std::ptrdiff_t{y} * GST_VIDEO_FRAME_PLANE_STRIDE(&mapped, 0);
    frame.grey.insert(frame.grey.end(), row, row + frame.width);
  }
  gst_video_frame_unmap(&mapped);
  return frame;
}

bool write_grey(const std::string &path, const Frame &frame) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char *>(frame.grey.data()),
             static_cast<std::streamsize>(frame.grey.size()));
  return static_cast<bool>(file.flush());
}

void log_frame(Log &log, GstPad *pad, GstBuffer *buffer) {
  ++log.number;
  auto frame = luma(pad, buffer);
  const GstHapticMotionMeta *meta = gst_buffer_get_haptic_motion_meta(buffer);
  double displacement = 0; // px, mean
  if (meta) {
    const double time =
        seconds(gst_segment_to_running_time(&log.segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer)));
    for (guint i = 0; i < meta->n_patches; ++i) {
      const GstHapticPatch &p = meta->patches[i];
      log.patches << log.number << ',' << time << ',' << meta->region_x << ',' << meta->region_y
                  << ',' << meta->region_width << ',' << meta->region_height << ',' << p.x << ','
                  << p.y << ',' << p.dx << ',' << p.dy << '\n';
      displacement += std::hypot(double{p.dx}, double{p.dy}) / meta->n_patches;
    }
  }
  constexpr guint kFewestPatches = 5; // fewer make no figure of the flow
  if (frame && !log.previous.grey.empty() && meta && meta->n_patches >= kFewestPatches &&
      displacement > log.largest_displacement) {
    log.largest_displacement = displacement;
    std::ofstream pair(log.folder + "/pair.csv");
    pair << "frame,width,height\n"
         << log.number << ',' << frame->width << ',' << frame->height << '\n';
    log.pair_written = pair.flush() && write_grey(log.folder + "/earlier.grey", log.previous) &&
                       write_grey(log.folder + "/later.grey", *frame);
  }
  if (frame)
    log.previous = std::move(*frame);
}

GstPadProbeReturn on_buffer(GstPad *pad, GstPadProbeInfo *info, gpointer data) {
  log_frame(*static_cast<Log *>(data), pad, GST_PAD_PROBE_INFO_BUFFER(info));
  return GST_PAD_PROBE_OK;
}

GstPadProbeReturn on_event(GstPad * /*pad*/, GstPadProbeInfo *info, gpointer data) {
  if (GstEvent *event = GST_PAD_PROBE_INFO_EVENT(info); GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT)
    gst_event_copy_segment(event, &static_cast<Log *>(data)->segment);
  return GST_PAD_PROBE_OK;
}

GstPadProbeReturn on_upstream(GstPad * /*pad*/, GstPadProbeInfo *info, gpointer data) {
  auto &log = *static_cast<Log *>(data);
  if (const auto position = haptic::parse_pointer_event(GST_PAD_PROBE_INFO_EVENT(info));
      position && GST_CLOCK_TIME_IS_VALID(position->timestamp)) {
    const std::lock_guard lock(log.mutex);
    log.pointers << seconds(position->timestamp) << ',' << position->x << ',' << position->y
                 << '\n';
  }
  return GST_PAD_PROBE_OK;
}

int fail(const std::string &text) {
  std::cerr << "motion-log: " << text << "\n";
  return 1;
}

int run(const std::string &folder, const char *line) {
  GError *error = nullptr;
  const haptic::ElementPtr pipeline(gst_parse_launch(line, &error));
  const haptic::ErrorPtr owned(error);
  if (error)
    return fail(error->message);
  if (!pipeline || !GST_IS_BIN(pipeline.get()))
    return fail("the launch line is no pipeline; separate at least two elements with !");
  const haptic::ElementPtr tracker(gst_bin_get_by_name(GST_BIN(pipeline.get()), "tracker"));
  if (!tracker)
    return fail("no element of the line is named tracker; write roitracker name=tracker");
  Log log(folder);
  const haptic::PadPtr pad(gst_element_get_static_pad(tracker.get(), "src"));
  gst_pad_add_probe(pad.get(), GST_PAD_PROBE_TYPE_BUFFER, on_buffer, &log, nullptr);
  gst_pad_add_probe(pad.get(), GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM, on_event, &log, nullptr);
  gst_pad_add_probe(pad.get(), GST_PAD_PROBE_TYPE_EVENT_UPSTREAM, on_upstream, &log, nullptr);
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const haptic::BusPtr bus(gst_element_get_bus(pipeline.get()));
  GstMessage *message =
      gst_bus_timed_pop_filtered(bus.get(), GST_CLOCK_TIME_NONE,
                                 static_cast<GstMessageType>(GST_MESSAGE_EOS | GST_MESSAGE_ERROR));
  std::string reason;
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_ERROR) {
    GError *wrong = nullptr;
    gst_message_parse_error(message, &wrong, nullptr);
    reason = wrong->message;
    g_error_free(wrong);
  }
  gst_message_unref(message);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  if (!reason.empty())
    return fail(reason);
  if (!log.complete() || !log.pair_written)
    return fail("'" + folder + "' cannot be written; give another folder");
  if (log.largest_displacement <= 0)
    return fail("nothing moved under the pointer; use another video or another hand");
  return 0;
}

} // namespace

int main(int argc, char **argv) {
  gst_init(&argc, &argv);
  if (argc != 3)
    return fail("usage: motion-log FOLDER LAUNCH-LINE");
  return run(argv[1], argv[2]);
}
