// SPDX-License-Identifier: LGPL-2.1-or-later
// Frames after encoding and decoding with H.264.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

namespace lab {

/// Whether GStreamer's x264enc and avdec_h264 are installed.
bool has_h264();

/// A clip (8-bit luma, sides even) encoded with the constant quality `crf` and decoded again: the
/// first frame is a key frame, each later one predicted from those before. Throws
/// std::runtime_error where that fails.
std::vector<cv::Mat> through_h264(const std::vector<cv::Mat> &clip, int crf);

} // namespace lab
