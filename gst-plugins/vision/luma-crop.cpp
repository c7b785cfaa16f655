// SPDX-License-Identifier: LGPL-2.1-or-later
#include "luma-crop.hpp"

#include "image-kernels.hpp"

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

LumaView luma_crop(const GstVideoFrame &frame, const Rectangle &area,
                   std::vector<std::uint8_t> &scratch) {
  const bool is_rgb = GST_VIDEO_FORMAT_INFO_IS_RGB(frame.info.finfo);
  const PackedView pixels{first_pixel(frame, area), GST_VIDEO_FRAME_COMP_PSTRIDE(&frame, 0),
                          area.width, area.height, GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0)};
  if (!is_rgb && pixels.pixel_size == 1)
    return {pixels.pixels, area.width, area.height, pixels.stride};
  scratch.resize(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height));
  const auto place = [&](guint component) {
    return static_cast<int>(GST_VIDEO_FRAME_COMP_POFFSET(&frame, component));
  };
  if (is_rgb)
    weigh_colours(pixels, {place(0), place(1), place(2)}, scratch.data(), area.width);
  else
    pick_bytes(pixels, place(0), scratch.data(), area.width);
  return {scratch.data(), area.width, area.height, area.width};
}

} // namespace haptic
