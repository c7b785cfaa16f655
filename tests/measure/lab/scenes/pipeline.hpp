// SPDX-License-Identifier: LGPL-2.1-or-later
// A GStreamer pipeline between elements named `in` and `out`.
#pragma once

#include "scenes/frame-sample.hpp"

#include <filesystem>
#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <string>

namespace lab {

/// Plays until its end of life. Throws std::runtime_error if an element is not installed.
class Pipeline {
public:
  /// `file`: location of `in`, unless empty.
  explicit Pipeline(const std::string &line, const std::filesystem::path &file = {});
  ~Pipeline() { gst_element_set_state(pipeline_.get(), GST_STATE_NULL); }
  Pipeline(const Pipeline &) = delete;
  Pipeline &operator=(const Pipeline &) = delete;

  /// For a pipeline that begins with an appsrc.
  GstAppSrc *in() const { return GST_APP_SRC(in_.get()); }

  /// The next sample of the appsink `out`. Nothing at the end, or after an error.
  Sample pull() const {
    constexpr GstClockTime kPatience = 10 * GST_SECOND; // after an error nothing comes
    return Sample{gst_app_sink_try_pull_sample(GST_APP_SINK(out_.get()), kPatience)};
  }

private:
  using Element = std::unique_ptr<GstElement, Unref<gst_object_unref>>;
  Element pipeline_;
  Element in_;
  Element out_;
};

} // namespace lab
