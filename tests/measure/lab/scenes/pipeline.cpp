// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scenes/pipeline.hpp"

#include <stdexcept>

namespace lab {

Pipeline::Pipeline(const std::string &line, const std::filesystem::path &file) {
  gst_init(nullptr, nullptr);
  pipeline_.reset(gst_parse_launch(line.c_str(), nullptr));
  if (!pipeline_)
    throw std::runtime_error("an element of this pipeline is missing: " + line);
  in_.reset(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "in"));
  out_.reset(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "out"));
  if (!file.empty())
    g_object_set(in_.get(), "location", file.c_str(), nullptr);
  gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING);
}

} // namespace lab
