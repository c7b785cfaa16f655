// SPDX-License-Identifier: LGPL-2.1-or-later
// Reads the luma of a part of a mapped frame of any supported format.
#pragma once

#include "pixels/kept-luma.hpp"

#include <gst/video/video.h>
#include <vector>

// 8 bits per component, YUV, RGB or grey.
#define HAPTIC_BYTE_FORMATS                                                                        \
  "GRAY8, I420, YV12, NV12, NV21, Y42B, Y444, YUY2, UYVY, RGB, BGR, RGBx, BGRx, xRGB, xBGR, "      \
  "RGBA, BGRA, ARGB, ABGR"

/// The formats that can be drawn on.
#define HAPTIC_DRAWN_FORMATS "{ " HAPTIC_BYTE_FORMATS " }"

/// The formats that can be read.
#define HAPTIC_VIDEO_FORMATS                                                                       \
  "{ " HAPTIC_BYTE_FORMATS ", NV16, P010_10LE, I420_10LE, I422_10LE, Y210, v210, "                 \
  "GRAY16_LE, GRAY16_BE }"

namespace haptic {

/// The luma of a frame that stays mapped. RGB: Y = 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601,
/// section 2.5.1). More than 8 bits are cut off, as videoconvert does it without dithering.
/// Converting reads no byte outside the pixels of the area; of v210, outside their 32-bit words.
class FrameLuma final : public LumaSource {
public:
  explicit FrameLuma(const GstVideoFrame &frame) : frame_(frame) {}

  LumaView plane(const Rectangle &area) const override;
  void convert(const Rectangle &area, std::uint8_t *to, std::ptrdiff_t stride) const override;

private:
  const GstVideoFrame &frame_;
};

/// Returns the luma of `area`. The view points into the frame if luma is a plane of its own;
/// otherwise into `scratch`, to which the area alone is converted. The frame must stay mapped, and
/// `scratch` must live as long as the view.
LumaView luma_crop(const GstVideoFrame &frame, const Rectangle &area,
                   std::vector<std::uint8_t> &scratch);

} // namespace haptic
