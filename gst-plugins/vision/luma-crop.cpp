// SPDX-License-Identifier: LGPL-2.1-or-later
#include "luma-crop.hpp"

namespace haptic {
namespace {

// One component of the frame: its first byte in the area, and the steps to the next ones.
struct Component {
  const std::uint8_t *first;
  std::ptrdiff_t pixel_step;
  std::ptrdiff_t row_step;

  Component(const GstVideoFrame &frame, guint index, const Rectangle &area)
      : pixel_step(GST_VIDEO_FRAME_COMP_PSTRIDE(&frame, index)),
        row_step(GST_VIDEO_FRAME_COMP_STRIDE(&frame, index)) {
    first = static_cast<const std::uint8_t *>(GST_VIDEO_FRAME_COMP_DATA(&frame, index)) +
            area.y * row_step + area.x * pixel_step;
  }

  const std::uint8_t *row(int y) const { return first + y * row_step; }
};

void gather(const Component &luma, const Rectangle &area, std::uint8_t *out) {
  for (int y = 0; y < area.height; ++y) {
    const std::uint8_t *in = luma.row(y);
    for (int x = 0; x < area.width; ++x)
      *out++ = in[x * luma.pixel_step];
  }
}

// Y = (77 R + 150 G + 29 B + 128) / 256: the weights of BT.601 in 256ths.
void weigh(const Component &red, const Component &green, const Component &blue,
           const Rectangle &area, std::uint8_t *out) {
  const std::ptrdiff_t step = red.pixel_step;
  for (int y = 0; y < area.height; ++y) {
    const std::uint8_t *r = red.row(y);
    const std::uint8_t *g = green.row(y);
    const std::uint8_t *b = blue.row(y);
    for (int x = 0; x < area.width; ++x)
      *out++ = static_cast<std::uint8_t>(
          (77 * r[x * step] + 150 * g[x * step] + 29 * b[x * step] + 128) >> 8);
  }
}

} // namespace

LumaView luma_crop(const GstVideoFrame &frame, const Rectangle &area,
                   std::vector<std::uint8_t> &scratch) {
  LumaView view{nullptr, area.width, area.height, area.width};
  const bool is_rgb = GST_VIDEO_FORMAT_INFO_IS_RGB(frame.info.finfo);
  const Component first(frame, 0, area);
  if (!is_rgb && first.pixel_step == 1) {
    view.pixels = first.first;
    view.stride = first.row_step;
    return view;
  }
  scratch.resize(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height));
  if (is_rgb)
    weigh(first, Component(frame, 1, area), Component(frame, 2, area), area, scratch.data());
  else
    gather(first, area, scratch.data());
  view.pixels = scratch.data();
  return view;
}

} // namespace haptic
