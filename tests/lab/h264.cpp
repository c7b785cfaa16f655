// SPDX-License-Identifier: LGPL-2.1-or-later
#include "h264.hpp"

#include "frame-sample.hpp"

#include <algorithm>
#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <gst/video/video.h>
#include <stdexcept>
#include <string>

namespace lab {
namespace {

bool is_installed(const char *element) {
  GstElementFactory *factory = gst_element_factory_find(element);
  if (factory)
    gst_object_unref(factory);
  return factory != nullptr;
}

// The chroma planes are grey.
GstBuffer *buffer_of(const cv::Mat &luma) {
  GstVideoInfo info;
  gst_video_info_set_format(&info, GST_VIDEO_FORMAT_I420, static_cast<guint>(luma.cols),
                            static_cast<guint>(luma.rows));
  GstBuffer *buffer = gst_buffer_new_allocate(nullptr, info.size, nullptr);
  gst_buffer_memset(buffer, 0, 128, info.size);
  const auto stride = static_cast<gsize>(GST_VIDEO_INFO_PLANE_STRIDE(&info, 0));
  for (int y = 0; y < luma.rows; ++y)
    gst_buffer_fill(buffer, static_cast<gsize>(y) * stride, luma.ptr(y),
                    static_cast<gsize>(luma.cols));
  return buffer;
}

} // namespace

bool has_h264() {
  gst_init(nullptr, nullptr);
  return is_installed("x264enc") && is_installed("avdec_h264");
}

std::vector<cv::Mat> through_h264(const std::vector<cv::Mat> &clip, int crf) {
  gst_init(nullptr, nullptr);
  // One thread and no processor-specific algorithm: the same frames on every machine. zerolatency
  // has no B frames, and no look-ahead, whose effect would depend on the clip's length.
  const std::string line =
      "appsrc name=in format=time caps=video/x-raw,format=I420,framerate=30/1,width=" +
      std::to_string(clip.front().cols) + ",height=" + std::to_string(clip.front().rows) +
      " ! x264enc pass=qual quantizer=" + std::to_string(crf) +
      " tune=zerolatency threads=1 key-int-max=250 option-string=scenecut=0:cpu-independent=1"
      " ! avdec_h264 max-threads=1 ! appsink name=out sync=false";
  const std::unique_ptr<GstElement, Unref<gst_object_unref>> pipeline(
      gst_parse_launch(line.c_str(), nullptr));
  if (!pipeline)
    throw std::runtime_error("there is no x264enc or no avdec_h264");
  const auto end = [&](const char *name) {
    return std::unique_ptr<GstElement, Unref<gst_object_unref>>(
        gst_bin_get_by_name(GST_BIN(pipeline.get()), name));
  };
  const auto in = end("in");
  const auto out = end("out");
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  for (std::size_t i = 0; i < clip.size(); ++i) {
    GstBuffer *buffer = buffer_of(clip[i]);
    GST_BUFFER_PTS(buffer) = gst_util_uint64_scale(i, GST_SECOND, 30);
    gst_app_src_push_buffer(GST_APP_SRC(in.get()), buffer);
  }
  gst_app_src_end_of_stream(GST_APP_SRC(in.get()));
  constexpr GstClockTime kPatience = 10 * GST_SECOND; // after an error nothing comes
  std::vector<cv::Mat> frames;
  while (const Sample sample{gst_app_sink_try_pull_sample(GST_APP_SINK(out.get()), kPatience)})
    frames.push_back(luma_of(sample.get()));
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  if (frames.size() != clip.size())
    throw std::runtime_error("of a clip of " + std::to_string(clip.size()) + " frames " +
                             std::to_string(frames.size()) + " went through H.264");
  return frames;
}

} // namespace lab
