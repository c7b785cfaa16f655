// Single pictures out of a video.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

struct Picture {
  std::vector<std::uint8_t> rgb; ///< width * height * 3, row by row from the top; empty: none
};

/// One for each of these times (ns, rising); none where the file has no video, or it has ended.
std::vector<Picture> read_pictures(const std::string &path, const std::vector<std::uint64_t> &times,
                                   int width, int height);

} // namespace haptic
