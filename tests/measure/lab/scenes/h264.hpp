// SPDX-License-Identifier: LGPL-2.1-or-later
// Frames after encoding and decoding with H.264.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <vector>

namespace lab {

/// Whether GStreamer's x264enc is installed.
bool has_h264_encoder();

/// Whether GStreamer's x264enc and avdec_h264 are installed.
bool has_h264();

/// A clip (8-bit luma, sides even) encoded with the constant quality `crf` and decoded again: the
/// first frame is a key frame, each later one predicted from those before. Throws
/// std::runtime_error where that fails.
std::vector<cv::Mat> through_h264(const std::vector<cv::Mat> &clip, int crf);

/// Access units of a byte stream (ITU-T H.264, annex B), in the order of decoding.
using H264Stream = std::vector<std::vector<std::uint8_t>>;

/// The clip as `through_h264` encodes it, but each frame predicted from at most so many earlier
/// ones.
H264Stream encode_h264(const std::vector<cv::Mat> &clip, int crf, int references);

/// The first `most` frames of a file, nothing if it holds no H.264.
H264Stream read_h264(const std::filesystem::path &file, std::size_t most);

} // namespace lab
