// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scenes/h264.hpp"

#include "scenes/pipeline.hpp"

#include <gst/video/video.h>
#include <stdexcept>
#include <string>

namespace lab {
namespace {

bool is_installed(const char *element) {
  gst_init(nullptr, nullptr);
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

// One thread and no processor-specific algorithm: the same frames on every machine. zerolatency
// has no B frames, and no look-ahead, whose effect would depend on the clip's length.
std::string encoder(const std::vector<cv::Mat> &clip, int crf) {
  return "appsrc name=in format=time caps=video/x-raw,format=I420,framerate=30/1,width=" +
         std::to_string(clip.front().cols) + ",height=" + std::to_string(clip.front().rows) +
         " ! x264enc pass=qual quantizer=" + std::to_string(crf) +
         " tune=zerolatency threads=1 key-int-max=250 option-string=scenecut=0:cpu-independent=1";
}

constexpr const char *kByteStream =
    "video/x-h264,stream-format=byte-stream,alignment=au ! appsink name=out sync=false";

void push(const std::vector<cv::Mat> &clip, const Pipeline &pipeline) {
  for (std::size_t i = 0; i < clip.size(); ++i) {
    GstBuffer *buffer = buffer_of(clip[i]);
    GST_BUFFER_PTS(buffer) = gst_util_uint64_scale(i, GST_SECOND, 30);
    gst_app_src_push_buffer(pipeline.in(), buffer);
  }
  gst_app_src_end_of_stream(pipeline.in());
}

H264Stream pull_units(const Pipeline &pipeline, std::size_t most) {
  H264Stream stream;
  while (stream.size() < most) {
    const Sample sample = pipeline.pull();
    if (!sample)
      break;
    GstBuffer *buffer = gst_sample_get_buffer(sample.get());
    stream.emplace_back(gst_buffer_get_size(buffer));
    gst_buffer_extract(buffer, 0, stream.back().data(), stream.back().size());
  }
  return stream;
}

} // namespace

bool has_h264_encoder() {
  return is_installed("x264enc");
}

bool has_h264() {
  return has_h264_encoder() && is_installed("avdec_h264");
}

std::vector<cv::Mat> through_h264(const std::vector<cv::Mat> &clip, int crf) {
  const Pipeline pipeline(encoder(clip, crf) +
                          " ! avdec_h264 max-threads=1 ! appsink name=out sync=false");
  push(clip, pipeline);
  std::vector<cv::Mat> frames;
  while (const Sample sample = pipeline.pull())
    frames.push_back(luma_of(sample.get()));
  if (frames.size() != clip.size())
    throw std::runtime_error("of a clip of " + std::to_string(clip.size()) + " frames " +
                             std::to_string(frames.size()) + " went through H.264");
  return frames;
}

H264Stream encode_h264(const std::vector<cv::Mat> &clip, int crf, int references) {
  const Pipeline pipeline(encoder(clip, crf) + " ref=" + std::to_string(references) + " ! " +
                          kByteStream);
  push(clip, pipeline);
  H264Stream stream = pull_units(pipeline, clip.size());
  if (stream.size() != clip.size())
    throw std::runtime_error("a clip cannot be encoded with H.264");
  return stream;
}

H264Stream read_h264(const std::filesystem::path &file, std::size_t most) {
  const Pipeline pipeline("filesrc name=in ! parsebin ! h264parse ! " + std::string(kByteStream),
                          file);
  return pull_units(pipeline, most);
}

} // namespace lab
