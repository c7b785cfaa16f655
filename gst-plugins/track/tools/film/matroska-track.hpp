// SPDX-License-Identifier: LGPL-2.1-or-later
// What GStreamer's matroskamux has no property for.
#pragma once

#include <string>

namespace haptic {

/// matroskamux has no name for DNxHD. Where it wrote such a stream as HuffYUV, this writes the name
/// by which others know DNxHD, "AVdn" in V_MS/VFW/FOURCC. Throws TrackFileError.
void name_dnxhd(const std::string &path);

} // namespace haptic
