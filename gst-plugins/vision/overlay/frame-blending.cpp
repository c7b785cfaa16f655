// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/frame-blending.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace haptic {
namespace {

// Returns a view of the part of a frame that holds a rectangle. `x` and `y` become the rectangle's
// place in it. Blending converts whole rows, so a small part is cheaper than the frame.
GstVideoFrame part_of(const GstVideoFrame &frame, const Rectangle &rectangle, int &x, int &y) {
  constexpr int kGrid = 2; // whole samples of chroma
  const int left = rectangle.x / kGrid * kGrid;
  const int top = rectangle.y / kGrid * kGrid;
  x = rectangle.x - left;
  y = rectangle.y - top;
  GstVideoFrame part = frame;
  part.info.width = std::min((x + rectangle.width + kGrid - 1) / kGrid * kGrid,
                             GST_VIDEO_FRAME_WIDTH(&frame) - left);
  part.info.height = std::min((y + rectangle.height + kGrid - 1) / kGrid * kGrid,
                              GST_VIDEO_FRAME_HEIGHT(&frame) - top);
  const GstVideoFormatInfo *format = frame.info.finfo;
  for (guint plane = 0; plane < GST_VIDEO_FRAME_N_PLANES(&frame); ++plane) {
    gint components[GST_VIDEO_MAX_COMPONENTS];
    gst_video_format_info_component(format, plane, components);
    const auto component = static_cast<guint>(components[0]);
    const std::ptrdiff_t rows = GST_VIDEO_FORMAT_INFO_SCALE_HEIGHT(format, component, top);
    const std::ptrdiff_t columns = GST_VIDEO_FORMAT_INFO_SCALE_WIDTH(format, component, left);
    part.data[plane] = static_cast<guint8 *>(frame.data[plane]) +
                       rows * GST_VIDEO_FRAME_PLANE_STRIDE(&frame, plane) +
                       columns * GST_VIDEO_FORMAT_INFO_PSTRIDE(format, component);
  }
  return part;
}

// gst_video_frame_copy() leaves out half of the last pair of pixels of YUY2 and UYVY of odd width.
GstVideoFrame whole_pairs(const GstVideoFrame &frame) {
  GstVideoFrame whole = frame;
  if (GST_VIDEO_FRAME_N_PLANES(&frame) == 1 &&
      GST_VIDEO_FORMAT_INFO_W_SUB(frame.info.finfo, 1) == 1)
    whole.info.width = GST_ROUND_UP_2(whole.info.width);
  return whole;
}

} // namespace

OverlayPixels paint(const OverlayDrawing &drawing) {
  const Rectangle &extent = drawing.extent();
  const auto width = static_cast<guint>(extent.width);
  const auto height = static_cast<guint>(extent.height);
  const gsize stride = 4 * static_cast<gsize>(width);
  BufferPtr pixels(gst_buffer_new_allocate(nullptr, stride * height, nullptr));
  gst_buffer_add_video_meta(pixels.get(), GST_VIDEO_FRAME_FLAG_NONE,
                            GST_VIDEO_OVERLAY_COMPOSITION_FORMAT_RGB, width, height);
  GstMapInfo map;
  gst_buffer_map(pixels.get(), &map, GST_MAP_WRITE);
  std::fill_n(map.data, map.size, guint8{0});
  drawing.paint(map.data, static_cast<int>(stride));
  gst_buffer_unmap(pixels.get(), &map);
  return {std::move(pixels), extent};
}

CompositionPtr compose(const OverlayPixels &overlay, int x, int y) {
  const RectanglePtr rectangle(gst_video_overlay_rectangle_new_raw(
      overlay.pixels.get(), x, y, static_cast<guint>(overlay.extent.width),
      static_cast<guint>(overlay.extent.height),
      GST_VIDEO_OVERLAY_FORMAT_FLAG_PREMULTIPLIED_ALPHA));
  return CompositionPtr(gst_video_overlay_composition_new(rectangle.get()));
}

bool copy_pixels(const GstVideoFrame &from, GstVideoFrame &to) {
  const GstVideoFrame source = whole_pairs(from);
  GstVideoFrame target = whole_pairs(to);
  return gst_video_frame_copy(&target, &source);
}

bool blend(const OverlayPixels &overlay, GstVideoFrame &frame) {
  int x = 0;
  int y = 0;
  GstVideoFrame part = part_of(frame, overlay.extent, x, y);
  return gst_video_overlay_composition_blend(compose(overlay, x, y).get(), &part);
}

} // namespace haptic
