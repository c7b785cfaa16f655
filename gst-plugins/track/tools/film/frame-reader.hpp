// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads single frames of a video.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

/// width * height * 3 bytes of red, green and blue, row by row from the top.
using Frame = std::vector<std::uint8_t>;

/// Returns a frame for each of these times (ns, rising). It is empty where the file has no video or
/// the video has ended. `width` is a multiple of four, so that no row is padded.
std::vector<Frame> read_frames(const std::string &path, const std::vector<std::uint64_t> &times,
                               int width, int height);

} // namespace haptic
