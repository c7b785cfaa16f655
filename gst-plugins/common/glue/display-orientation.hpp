// SPDX-License-Identifier: LGPL-2.1-or-later
// The camera's rotation inside the coded video: the display orientation SEI message of H.264 and
// H.265. It survives any container; players with FFmpeg obey it, GStreamer 1.22 does not read it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace haptic {

/// Returns the video-direction of videoflip that does what the tag image-orientation of GStreamer
/// says: "90r", "180" or "90l"; "auto" for others.
const char *direction_of(std::string_view orientation);

/// Returns the NAL unit with the message, without its start code. The orientation is "rotate-90",
/// "rotate-180" or "rotate-270", clockwise; for others the unit is empty.
std::vector<std::uint8_t> orientation_unit(std::string_view orientation, bool is_h265);

/// Returns the orientation of the first such message at the begin of a file, in any container; ""
/// without one. A message of another form, by other encoders, is not found.
std::string orientation_in(const std::string &path);

} // namespace haptic
