// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads the luma of a part of a mapped frame, whatever its format, and touches nothing else.
#pragma once

#include "patch-tracker.hpp"

#include <gst/video/video.h>
#include <vector>

/// The formats that luma_crop() reads: 8 bits per component, YUV, RGB or grey.
#define HAPTIC_VIDEO_FORMATS                                                                       \
  "{ GRAY8, I420, YV12, NV12, NV21, Y42B, Y444, YUY2, UYVY, RGB, BGR, RGBx, BGRx, xRGB, xBGR, "    \
  "RGBA, BGRA, ARGB, ABGR }"

namespace haptic {

/// `area` lies inside the frame. The view points into the frame where the luma stands alone in
/// memory; else the area alone is converted (ITU-R BT.601 weights for RGB) into `scratch`, which
/// must live as long as the view. The frame must stay mapped.
LumaView luma_crop(const GstVideoFrame &frame, const Rectangle &area,
                   std::vector<std::uint8_t> &scratch);

} // namespace haptic
