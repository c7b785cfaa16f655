// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads real frames from a folder: pairs with true flow, and clips without.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace lab {

/// Two frames and the displacement of each pixel of the first, NaN if unknown.
struct TruePair {
  std::string name;
  cv::Mat previous; ///< 8-bit luma
  cv::Mat current;
  cv::Mat2f flow; ///< px
};

/// In a folder, in one of the two usual layouts:
/// NAME_gt.flo (or NAME.flo) beside two frames whose names begin with NAME, in alphabetical
/// order (Middlebury); or image_2|image_0/NUMBER_10.png, NUMBER_11.png and flow_occ/NUMBER_10.png
/// (KITTI). Throws std::runtime_error, with the file's name, if a file cannot be read.
std::vector<TruePair> read_pairs(const std::filesystem::path &folder);

struct Clip {
  std::string name;
  std::vector<cv::Mat> frames; ///< 8-bit luma, one after the other
};

/// The files of the folder whose names are those of videos, in alphabetical order.
std::vector<std::filesystem::path> videos_in(const std::filesystem::path &folder);

/// Evenly spread runs of neighbouring frames, from every file of the folder that is a video.
/// Throws std::runtime_error where there is none.
std::vector<Clip> read_clips(const std::filesystem::path &folder, int runs, int length);

} // namespace lab
