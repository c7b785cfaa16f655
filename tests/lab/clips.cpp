// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads videos with GStreamer, so that the lab needs no further library.
#include "frame-sample.hpp"
#include "pairs.hpp"

#include <algorithm>
#include <gst/app/gstappsink.h>
#include <stdexcept>

namespace lab {
namespace {

namespace fs = std::filesystem;

// Returns nothing if the file is no video.
std::vector<cv::Mat> frames_of(const fs::path &file) {
  constexpr std::size_t kMost = 250;
  GstElement *pipeline = gst_parse_launch(
      "filesrc name=file ! decodebin ! videoconvert ! video/x-raw,format=GRAY8 ! appsink name=out "
      "sync=false max-buffers=4",
      nullptr);
  if (!pipeline)
    throw std::runtime_error("no pipeline for clips: is gstreamer1.0-plugins-base installed?");
  GstElement *source = gst_bin_get_by_name(GST_BIN(pipeline), "file");
  g_object_set(source, "location", file.c_str(), nullptr);
  gst_object_unref(source);
  GstElement *out = gst_bin_get_by_name(GST_BIN(pipeline), "out");
  std::vector<cv::Mat> frames;
  gst_element_set_state(pipeline, GST_STATE_PLAYING);
  constexpr GstClockTime kPatience = 5 * GST_SECOND; // a file that is no video never gives one
  while (frames.size() < kMost) {
    const Sample sample(gst_app_sink_try_pull_sample(GST_APP_SINK(out), kPatience));
    if (!sample)
      break;
    frames.push_back(luma_of(sample.get()));
  }
  gst_element_set_state(pipeline, GST_STATE_NULL);
  gst_object_unref(out);
  gst_object_unref(pipeline);
  return frames;
}

bool is_video(const fs::path &path) {
  return path.extension() == ".mp4" || path.extension() == ".avi" || path.extension() == ".mkv" ||
         path.extension() == ".webm";
}

} // namespace

std::vector<fs::path> videos_in(const fs::path &folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto &entry : fs::directory_iterator(folder, error))
    if (is_video(entry.path()))
      files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

std::vector<Clip> read_clips(const fs::path &folder, int runs, int length) {
  gst_init(nullptr, nullptr);
  std::vector<Clip> clips;
  for (const fs::path &file : videos_in(folder)) {
    const std::vector<cv::Mat> frames = frames_of(file);
    const int most = static_cast<int>(frames.size()) - length;
    for (int run = 0; run < runs && most >= 0; ++run) {
      const auto first = frames.begin() + (runs > 1 ? most * run / (runs - 1) : 0);
      clips.push_back({file.stem().string(), {first, first + length}});
    }
  }
  if (clips.empty())
    throw std::runtime_error("in '" + folder.string() +
                             "' there is no video (.mp4, .avi, .mkv, .webm) that can be decoded");
  return clips;
}

} // namespace lab
