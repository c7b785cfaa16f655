// SPDX-License-Identifier: LGPL-2.1-or-later
// Copies frames out of GStreamer samples.
#pragma once

#include <gst/gst.h>
#include <memory>
#include <opencv2/core.hpp>

namespace lab {

template <auto unref>
struct Unref {
  template <typename T>
  void operator()(T *object) const {
    unref(object);
  }
};
using Sample = std::unique_ptr<GstSample, Unref<gst_sample_unref>>;

/// A copy of the luma. Throws std::runtime_error if the sample holds no frame.
cv::Mat luma_of(GstSample *sample);

} // namespace lab
