// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scenes/frame-sample.hpp"

#include <gst/video/video.h>
#include <stdexcept>

namespace lab {

cv::Mat luma_of(GstSample *sample) {
  GstVideoInfo info;
  GstVideoFrame mapped;
  if (!gst_video_info_from_caps(&info, gst_sample_get_caps(sample)) ||
      !gst_video_frame_map(&mapped, &info, gst_sample_get_buffer(sample), GST_MAP_READ))
    throw std::runtime_error("a frame of a clip cannot be read");
  const cv::Mat luma(GST_VIDEO_FRAME_HEIGHT(&mapped), GST_VIDEO_FRAME_WIDTH(&mapped), CV_8UC1,
                     GST_VIDEO_FRAME_PLANE_DATA(&mapped, 0),
                     static_cast<std::size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&mapped, 0)));
  cv::Mat copy = luma.clone();
  gst_video_frame_unmap(&mapped);
  return copy;
}

} // namespace lab
