// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads videos with GStreamer, so that the lab needs no further library.
#include "scenes/pairs.hpp"
#include "scenes/pipeline.hpp"

#include <algorithm>
#include <stdexcept>

namespace lab {
namespace {

namespace fs = std::filesystem;

// Returns nothing if the file is no video. In GStreamer 1.22 a decodebin whose pads of sound are
// not linked hangs now and then.
std::vector<cv::Mat> frames_of(const fs::path &file) {
  constexpr std::size_t kMost = 250;
  const Pipeline pipeline("filesrc name=in ! decodebin caps=video/x-raw(ANY) "
                          "expose-all-streams=false ! videoconvert ! video/x-raw,format=GRAY8 "
                          "! appsink name=out sync=false max-buffers=4",
                          file);
  std::vector<cv::Mat> frames;
  while (frames.size() < kMost) {
    const Sample sample = pipeline.pull();
    if (!sample)
      break;
    frames.push_back(luma_of(sample.get()));
  }
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
