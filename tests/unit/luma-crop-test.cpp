// SPDX-License-Identifier: LGPL-2.1-or-later
#include "luma-crop.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace {

using haptic::LumaView;
using haptic::Rectangle;

// Luma of a pixel, also its grey in RGB: every pixel has its own value.
std::uint8_t value_at(int x, int y) {
  return static_cast<std::uint8_t>((7 * x + 31 * y) % 256);
}

// A frame of one format with everything but luma (or the three colours) set to 200.
class Frame {
public:
  Frame(GstVideoFormat format, int width, int height) {
    gst_video_info_set_format(&frame_.info, format, static_cast<guint>(width),
                              static_cast<guint>(height));
    memory_.assign(GST_VIDEO_INFO_SIZE(&frame_.info), 200);
    for (guint plane = 0; plane < GST_VIDEO_INFO_N_PLANES(&frame_.info); ++plane)
      frame_.data[plane] = memory_.data() + GST_VIDEO_INFO_PLANE_OFFSET(&frame_.info, plane);
    const guint components = GST_VIDEO_INFO_IS_RGB(&frame_.info) ? 3 : 1;
    for (guint component = 0; component < components; ++component)
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
          static_cast<std::uint8_t *>(GST_VIDEO_FRAME_COMP_DATA(
              &frame_, component))[y * GST_VIDEO_FRAME_COMP_STRIDE(&frame_, component) +
                                   x * GST_VIDEO_FRAME_COMP_PSTRIDE(&frame_, component)] =
              value_at(x, y);
  }

  const GstVideoFrame &frame() const { return frame_; }
  bool owns(const std::uint8_t *pixel) const {
    return pixel >= memory_.data() && pixel < memory_.data() + memory_.size();
  }

private:
  GstVideoFrame frame_{};
  std::vector<std::uint8_t> memory_;
};

class LumaCrop : public ::testing::TestWithParam<const char *> {
protected:
  const GstVideoFormat format = gst_video_format_from_string(GetParam());
};

TEST_P(LumaCrop, ReadsTheLumaOfTheAreaAtOddSizesAndPlaces) {
  for (const int width : {41, 42, 43}) {
    const Frame frame(format, width, 25);
    for (const Rectangle &area :
         {Rectangle{0, 0, width, 25}, Rectangle{5, 3, 11, 7}, Rectangle{width - 1, 24, 1, 1}}) {
      std::vector<std::uint8_t> scratch;
      const LumaView view = haptic::luma_crop(frame.frame(), area, scratch);
      ASSERT_EQ(view.width, area.width);
      ASSERT_EQ(view.height, area.height);
      for (int y = 0; y < area.height; ++y)
        for (int x = 0; x < area.width; ++x)
          ASSERT_EQ(view.pixels[y * view.stride + x], value_at(area.x + x, area.y + y));
    }
  }
}

TEST_P(LumaCrop, ConvertsTheAreaAloneAndOnlyWhereLumaDoesNotStandAlone) {
  const Frame frame(format, 320, 240);
  std::vector<std::uint8_t> scratch;
  const LumaView view = haptic::luma_crop(frame.frame(), {100, 100, 30, 20}, scratch);
  const int pixel_step = GST_VIDEO_FRAME_COMP_PSTRIDE(&frame.frame(), 0);
  EXPECT_EQ(frame.owns(view.pixels), pixel_step == 1);
  EXPECT_EQ(scratch.size(), pixel_step == 1 ? 0U : std::size_t{30} * 20);
}

INSTANTIATE_TEST_SUITE_P(Formats, LumaCrop,
                         ::testing::Values("GRAY8", "I420", "YV12", "NV12", "NV21", "Y42B", "Y444",
                                           "YUY2", "UYVY", "RGB", "BGR", "RGBx", "BGRx", "xRGB",
                                           "xBGR", "RGBA", "BGRA", "ARGB", "ABGR"),
                         [](const auto &format) { return std::string(format.param); });

} // namespace
