// SPDX-License-Identifier: LGPL-2.1-or-later
#include "frames/luma-crop.hpp"

#include "pixels/image-kernels.hpp"

namespace haptic {
namespace {

// All formats that are read have luma, or all colours, in the first plane.
const std::uint8_t *first_pixel(const GstVideoFrame &frame, const Rectangle &area) {
  const std::ptrdiff_t row_step = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0);
  const std::ptrdiff_t pixel_step = GST_VIDEO_FRAME_COMP_PSTRIDE(&frame, 0);
  return static_cast<const std::uint8_t *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0)) +
         area.y * row_step + area.x * pixel_step;
}

} // namespace

LumaView FrameLuma::plane(const Rectangle &area) const {
  if (GST_VIDEO_FORMAT_INFO_IS_RGB(frame_.info.finfo) ||
      GST_VIDEO_FRAME_COMP_PSTRIDE(&frame_, 0) != 1)
    return {};
  return {first_pixel(frame_, area), area.width, area.height,
          GST_VIDEO_FRAME_PLANE_STRIDE(&frame_, 0)};
}

void FrameLuma::convert(const Rectangle &area, std::uint8_t *to, std::ptrdiff_t stride) const {
  const PackedView pixels{first_pixel(frame_, area), GST_VIDEO_FRAME_COMP_PSTRIDE(&frame_, 0),
                          area.width, area.height, GST_VIDEO_FRAME_PLANE_STRIDE(&frame_, 0)};
  const auto place = [this](guint component) {
    return static_cast<int>(GST_VIDEO_FRAME_COMP_POFFSET(&frame_, component));
  };
  const GstVideoFormatInfo *format = frame_.info.finfo;
  const auto depth = GST_VIDEO_FORMAT_INFO_DEPTH(format, 0);
  if (GST_VIDEO_FORMAT_INFO_FORMAT(format) == GST_VIDEO_FORMAT_v210)
    unpack_v210(pixels, area.x, to, stride);
  else if (GST_VIDEO_FORMAT_INFO_FORMAT(format) == GST_VIDEO_FORMAT_Y210)
    // Little-endian, bits at the upper end. GStreamer 1.22 converts it so, but describes it
    // otherwise.
    pick_bytes(pixels, place(0) + 1, to, stride);
  else if (GST_VIDEO_FORMAT_INFO_IS_RGB(format))
    weigh_colours(pixels, {place(0), place(1), place(2)}, to, stride);
  else if (depth == 8)
    pick_bytes(pixels, place(0), to, stride);
  else if (depth + GST_VIDEO_FORMAT_INFO_SHIFT(format, 0) == 16)
    pick_bytes(pixels, place(0) + (GST_VIDEO_FORMAT_INFO_IS_LE(format) ? 1 : 0), to, stride);
  else
    cut_ten_bits(pixels, to, stride);
}

LumaView luma_crop(const GstVideoFrame &frame, const Rectangle &area,
                   std::vector<std::uint8_t> &scratch) {
  const FrameLuma luma(frame);
  if (const LumaView plane = luma.plane(area); plane.pixels)
    return plane;
  scratch.resize(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height));
  luma.convert(area, scratch.data(), area.width);
  return {scratch.data(), area.width, area.height, area.width};
}

} // namespace haptic
