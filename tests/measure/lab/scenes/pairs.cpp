// SPDX-License-Identifier: LGPL-2.1-or-later
#include "scenes/pairs.hpp"

#include <algorithm>
#include <bit>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

namespace lab {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "the numbers of .flo files are");

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

cv::Mat read_luma(const fs::path &path) {
  cv::Mat frame = cv::imread(path.string(), cv::IMREAD_GRAYSCALE);
  if (frame.empty())
    throw std::runtime_error("'" + path.string() + "' cannot be read as a frame");
  return frame;
}

cv::Mat2f read_flo(const fs::path &path) {
  constexpr float kTag = 202021.25F;
  constexpr float kKnown = 1e9F; // what is larger stands for "unknown"
  std::ifstream file(path, std::ios::binary);
  float tag = 0;
  std::int32_t size[2] = {};
  file.read(reinterpret_cast<char *>(&tag), sizeof tag);
  file.read(reinterpret_cast<char *>(size), sizeof size);
  if (!file || tag != kTag || std::min(size[0], size[1]) < 1)
    throw std::runtime_error("'" + path.string() + "' is not a .flo file");
  // Check the size in the header before allocating.
  const auto bytes = static_cast<std::uintmax_t>(size[0]) * static_cast<std::uintmax_t>(size[1]) *
                     sizeof(cv::Vec2f);
  if (fs::file_size(path) != sizeof tag + sizeof size + bytes)
    throw std::runtime_error("'" + path.string() + "' is not as long as its " +
                             std::to_string(size[0]) + "x" + std::to_string(size[1]) +
                             " pixels need");
  cv::Mat2f flow(size[1], size[0]);
  file.read(reinterpret_cast<char *>(flow.data), static_cast<std::streamsize>(bytes));
  if (!file)
    throw std::runtime_error("'" + path.string() + "' cannot be read");
  for (auto &v : flow)
    if (!(std::abs(v[0]) < kKnown && std::abs(v[1]) < kKnown))
      v = {kUnknown, kUnknown};
  return flow;
}

// 16-bit colours: valid, v and u in blue, green and red.
cv::Mat2f read_kitti(const fs::path &path) {
  const cv::Mat stored = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
  if (stored.type() != CV_16UC3)
    throw std::runtime_error("'" + path.string() + "' is not a flow frame of KITTI");
  cv::Mat2f flow(stored.size());
  const auto decoded = [](std::uint16_t value) { return (static_cast<float>(value) - 32768) / 64; };
  for (int y = 0; y < stored.rows; ++y)
    for (int x = 0; x < stored.cols; ++x) {
      const auto &[valid, v, u] = stored.at<cv::Vec3w>(y, x).val;
      flow(y, x) = valid ? cv::Vec2f(decoded(u), decoded(v)) : cv::Vec2f(kUnknown, kUnknown);
    }
  return flow;
}

std::vector<fs::path> files_of(const fs::path &folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto &entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file())
      files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

bool is_frame(const fs::path &path) {
  return path.extension() == ".png" || path.extension() == ".ppm" || path.extension() == ".jpg";
}

TruePair checked(TruePair pair) {
  if (pair.previous.size() != pair.current.size() || pair.previous.size() != pair.flow.size())
    throw std::runtime_error("the two frames and the flow of '" + pair.name +
                             "' are not of one size");
  return pair;
}

void add_middlebury(const fs::path &folder, std::vector<TruePair> &pairs) {
  const auto files = files_of(folder);
  for (const fs::path &truth : files) {
    if (truth.extension() != ".flo")
      continue;
    std::string name = truth.stem().string();
    if (name.ends_with("_gt"))
      name.resize(name.size() - 3);
    std::vector<fs::path> frames;
    std::ranges::copy_if(files, std::back_inserter(frames), [&](const fs::path &file) {
      return is_frame(file) && file.filename().string().starts_with(name);
    });
    if (frames.size() != 2)
      throw std::runtime_error("beside '" + truth.string() + "' there should be two frames " +
                               name + "*.png, there are " + std::to_string(frames.size()));
    pairs.push_back(checked({name, read_luma(frames[0]), read_luma(frames[1]), read_flo(truth)}));
  }
}

void add_kitti(const fs::path &folder, std::vector<TruePair> &pairs) {
  for (const fs::path &truth : files_of(folder / "flow_occ")) {
    const std::string name = truth.stem().string(); // ends with _10
    const std::string next = name.substr(0, name.rfind('_')) + "_11.png";
    for (const char *images : {"image_2", "image_0"})
      if (fs::exists(folder / images / next)) {
        pairs.push_back(checked({"KITTI " + name, read_luma(folder / images / (name + ".png")),
                                 read_luma(folder / images / next), read_kitti(truth)}));
        break;
      }
  }
}

} // namespace

std::vector<TruePair> read_pairs(const fs::path &folder) {
  std::vector<TruePair> pairs;
  add_middlebury(folder, pairs);
  add_kitti(folder, pairs);
  if (pairs.empty())
    throw std::runtime_error("in '" + folder.string() +
                             "' there is no pair of frames with true flow: NAME_gt.flo beside two "
                             "frames NAME*.png, or KITTI's folders flow_occ and image_2");
  return pairs;
}

} // namespace lab
