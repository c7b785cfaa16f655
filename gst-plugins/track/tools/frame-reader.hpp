// SPDX-License-Identifier: LGPL-2.1-or-later
// Single frames out of a video.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

struct Frame {
  std::vector<std::uint8_t> rgb; ///< width * height * 3, row by row from the top; empty: none
};

/// One for each of these times (ns, rising); none where the file has no video, or it has ended.
std::vector<Frame> read_frames(const std::string &path, const std::vector<std::uint64_t> &times,
                               int width, int height);

} // namespace haptic
