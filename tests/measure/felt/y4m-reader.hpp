// SPDX-License-Identifier: LGPL-2.1-or-later
// The frames of a film that comes through a pipe.
#pragma once

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <istream>
#include <opencv2/core.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace test {

/// YUV4MPEG2, 8 bits: 4:2:0 or luma alone.
class Y4mReader {
public:
  explicit Y4mReader(std::istream &stream) : stream_(stream) {
    std::string line;
    std::getline(stream_, line);
    std::istringstream words(line);
    std::string word;
    words >> word;
    int numerator = 0;
    int denominator = 0;
    bool has_colour = true;
    if (word != "YUV4MPEG2")
      throw std::runtime_error("the input is no YUV4MPEG2");
    while (words >> word) {
      const char *value = word.c_str() + 1;
      if (word[0] == 'W')
        width_ = std::atoi(value);
      else if (word[0] == 'H')
        height_ = std::atoi(value);
      else if (word[0] == 'F' && std::sscanf(value, "%d:%d", &numerator, &denominator) == 2)
        seconds = static_cast<float>(denominator) / static_cast<float>(std::max(numerator, 1));
      else if (word == "Cmono")
        has_colour = false;
      else if (word[0] == 'C' && !word.starts_with("C420"))
        throw std::runtime_error("the input must be 4:2:0 or mono, not " + word);
    }
    if (width_ < 1 || height_ < 1 || !(seconds > 0))
      throw std::runtime_error("the input has no size or no rate");
    if (has_colour)
      colour_.resize(static_cast<std::size_t>((width_ + 1) / 2) * ((height_ + 1) / 2) * 2);
  }

  /// False at the end.
  bool next(cv::Mat &luma) {
    std::string line;
    if (!std::getline(stream_, line))
      return false;
    if (!line.starts_with("FRAME"))
      throw std::runtime_error("the input is damaged");
    luma.create(height_, width_, CV_8U);
    return stream_.read(reinterpret_cast<char *>(luma.data),
                        static_cast<std::streamsize>(luma.total())) &&
           stream_.read(colour_.data(), static_cast<std::streamsize>(colour_.size()));
  }

  float seconds = 0; ///< between frames

private:
  std::istream &stream_;
  int width_ = 0;
  int height_ = 0;
  std::vector<char> colour_; // of a frame; not used
};

} // namespace test
