// SPDX-License-Identifier: LGPL-2.1-or-later
#include "frames/luma-crop.hpp"

#include "glue/gst-raii.hpp"
#include "guarded-frame.hpp"
#include "instruction-sets.hpp"
#include "video-samples.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <utility>
#include <vector>

namespace luma_crop_test {

using haptic::LumaView;
using haptic::Rectangle;

// Luma of a pixel, also its grey in RGB: every pixel has its own value.
std::uint8_t value_at(int x, int y) {
  return static_cast<std::uint8_t>((7 * x + 31 * y) % 256);
}

// Bytes of a row without padding.
int bytes_of_row(GstVideoFormat format, int width) {
  if (format == GST_VIDEO_FORMAT_v210) // six pixels in four words
    return (width + 5) / 6 * 16;
  return width * GST_VIDEO_FORMAT_INFO_PSTRIDE(gst_video_format_get_info(format), 0);
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
          test::set_sample(frame_, component, x, y, value_at(x, y));
  }

  const GstVideoFrame &frame() const { return frame_; }
  bool owns(const std::uint8_t *pixel) const {
    return pixel >= memory_.data() && pixel < memory_.data() + memory_.size();
  }

private:
  GstVideoFrame frame_{};
  std::vector<std::uint8_t> memory_;
};

// The formula, pixel by pixel: Y = (77 R + 150 G + 29 B + 128) / 256, or the luma that there is.
int luma_at(const GstVideoFrame &frame, int x, int y) {
  const auto component = [&](guint index) { return test::get_sample(frame, index, x, y); };
  if (!GST_VIDEO_FORMAT_INFO_IS_RGB(frame.info.finfo))
    return component(0);
  return (77 * component(0) + 150 * component(1) + 29 * component(2) + 128) / 256;
}

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

// The first plane of a frame of random pixels, each of whose rows ends (or begins) at a page that
// may not be read.
class GuardedPlane {
public:
  GuardedPlane(GstVideoFormat format, int width, int height, bool ends)
      : row_bytes_(bytes_of_row(format, width)), memory_(row_bytes_, height) {
    gst_video_info_set_format(&frame_.info, format, static_cast<guint>(width),
                              static_cast<guint>(height));
    std::mt19937 random(static_cast<unsigned>(width));
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(row_bytes_ * height));
    for (auto &byte : bytes)
      byte = static_cast<std::uint8_t>(random());
    const LumaView rows = memory_.filled({bytes.data(), row_bytes_, height, row_bytes_}, ends);
    frame_.data[0] = const_cast<std::uint8_t *>(rows.pixels);
    frame_.info.stride[0] = static_cast<int>(rows.stride);
  }

  const GstVideoFrame &frame() const { return frame_; }

private:
  GstVideoFrame frame_{};
  int row_bytes_;
  test::GuardedFrame memory_;
};

// Widths below, at and above those of all vectors.
TEST_P(LumaCrop, EveryInstructionSetConvertsByTheFormulaAndReadsTheAreaAlone) {
  constexpr int kHeight = 3;
  test::for_instruction_sets([&](const char *name) {
    for (int width = 1; width <= 200; width += width < 70 ? 1 : 13)
      for (const bool ends : {false, true}) {
        const GuardedPlane plane(format, width, kHeight, ends);
        std::vector<std::uint8_t> scratch;
        const LumaView view = haptic::luma_crop(plane.frame(), {0, 0, width, kHeight}, scratch);
        for (int y = 0; y < kHeight; ++y)
          for (int x = 0; x < width; ++x)
            ASSERT_EQ(view.pixels[y * view.stride + x], luma_at(plane.frame(), x, y))
                << name << ", width " << width << ", " << x << ' ' << y;
      }
  });
}

// Frames whose rows follow one another without slack, and whose last (or first) byte lies beside a
// page that may not be read.
TEST_P(LumaCrop, KeptAreasAtEveryBorderAreThoseOfTheFrameAndReadNothingOutside) {
  std::mt19937 random(1);
  const auto between = [&](int least, int most) {
    return std::uniform_int_distribution(least, most)(random);
  };
  test::for_instruction_sets([&](const char *name) {
    for (int i = 0; i < 60; ++i) {
      const int width = between(1, 90);
      const int height = between(1, 30);
      GstVideoFrame frame{};
      gst_video_info_set_format(&frame.info, format, static_cast<guint>(width),
                                static_cast<guint>(height));
      std::vector<std::uint8_t> bytes(
          static_cast<std::size_t>(bytes_of_row(format, width) * height));
      std::ranges::generate(bytes, random);
      test::GuardedFrame memory(static_cast<int>(bytes.size()), 1);
      const auto size = static_cast<int>(bytes.size());
      frame.data[0] = const_cast<std::uint8_t *>(
          memory.filled({bytes.data(), size, 1, size}, i % 2 == 0).pixels);
      frame.info.stride[0] = bytes_of_row(format, width);
      const haptic::FrameLuma luma(frame);
      haptic::KeptLuma kept;
      for (int read = 0; read < 30; ++read) {
        const auto [x, columns] = test::any_part(random, width);
        const auto [y, rows] = test::any_part(random, height);
        const LumaView view = kept.read(luma, {x, y, columns, rows});
        ASSERT_EQ(std::pair(view.width, view.height), std::pair(columns, rows));
        for (int row = 0; row < rows; ++row)
          for (int column = 0; column < columns; ++column)
            ASSERT_EQ(view.pixels[row * view.stride + column], luma_at(frame, x + column, y + row))
                << name << ", " << columns << 'x' << rows << '+' << x << '+' << y << " of " << width
                << 'x' << height;
      }
    }
  });
}

// Each sum of weights once, with the greatest and the least colours.
TEST(LumaCropColours, EveryColourIsRoundedByTheFormula) {
  constexpr int kLevels[] = {0, 1, 2, 63, 64, 127, 128, 191, 254, 255};
  GstVideoFrame frame{};
  gst_video_info_set_format(&frame.info, GST_VIDEO_FORMAT_BGRx, 2560, 10);
  std::vector<std::uint8_t> bytes;
  for (const int blue : kLevels)
    for (const int red : kLevels)
      for (int green = 0; green < 256; ++green)
        for (const int byte : {blue, green, red, 255 - green})
          bytes.push_back(static_cast<std::uint8_t>(byte));
  frame.data[0] = bytes.data();
  test::for_instruction_sets([&](const char *name) {
    std::vector<std::uint8_t> scratch;
    const LumaView view = haptic::luma_crop(frame, {0, 0, 2560, 10}, scratch);
    for (int y = 0; y < 10; ++y)
      for (int x = 0; x < 2560; ++x)
        ASSERT_EQ(view.pixels[y * view.stride + x], luma_at(frame, x, y)) << name;
  });
}

class LumaWithoutColours : public LumaCrop {};

TEST_P(LumaWithoutColours, IsThatOfVideoconvertWithoutDithering) {
  gst_init(nullptr, nullptr);
  std::mt19937 random(3);
  for (const int width : {1, 2, 47, 48, 49, 643}) {
    constexpr int kHeight = 37;
    GstVideoInfo in;
    GstVideoInfo out;
    const auto columns = static_cast<guint>(width);
    gst_video_info_set_format(&in, format, columns, kHeight);
    gst_video_info_set_format(
        &out, GST_VIDEO_INFO_IS_GRAY(&in) ? GST_VIDEO_FORMAT_GRAY8 : GST_VIDEO_FORMAT_Y444, columns,
        kHeight);
    out.colorimetry = in.colorimetry;
    const auto buffer_of = [](const GstVideoInfo &info) {
      return haptic::BufferPtr(
          gst_buffer_new_allocate(nullptr, GST_VIDEO_INFO_SIZE(&info), nullptr));
    };
    const haptic::BufferPtr source = buffer_of(in);
    const haptic::BufferPtr target = buffer_of(out);
    GstMapInfo bytes;
    gst_buffer_map(source.get(), &bytes, GST_MAP_WRITE);
    std::generate_n(bytes.data, bytes.size, [&] { return static_cast<std::uint8_t>(random()); });
    gst_buffer_unmap(source.get(), &bytes);
    GstVideoFrame from;
    GstVideoFrame to;
    gst_video_frame_map(&from, &in, source.get(), GST_MAP_READWRITE);
    gst_video_frame_map(&to, &out, target.get(), GST_MAP_READWRITE);
    // Ones below the upper eight bits: rounding would show.
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < width; ++x)
        test::set_sample(from, 0, x, y, static_cast<std::uint8_t>(random()));
    GstVideoConverter *converter = gst_video_converter_new(
        &in, &out,
        gst_structure_new("options", GST_VIDEO_CONVERTER_OPT_DITHER_METHOD,
                          GST_TYPE_VIDEO_DITHER_METHOD, GST_VIDEO_DITHER_NONE, nullptr));
    gst_video_converter_frame(converter, &from, &to);
    gst_video_converter_free(converter);
    std::vector<std::uint8_t> scratch;
    const LumaView view = haptic::luma_crop(from, {0, 0, width, kHeight}, scratch);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < width; ++x)
        ASSERT_EQ(view.pixels[y * view.stride + x], test::get_sample(to, 0, x, y))
            << width << ": " << x << ' ' << y;
    gst_video_frame_unmap(&to);
    gst_video_frame_unmap(&from);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, LumaWithoutColours,
                         ::testing::Values("GRAY8", "I420", "YV12", "NV12", "NV21", "Y42B", "Y444",
                                           "YUY2", "UYVY", "NV16", "P010_10LE", "I420_10LE",
                                           "I422_10LE", "Y210", "v210", "GRAY16_LE", "GRAY16_BE"),
                         [](const auto &format) { return std::string(format.param); });

INSTANTIATE_TEST_SUITE_P(Formats, LumaCrop,
                         ::testing::Values("GRAY8", "I420", "YV12", "NV12", "NV21", "Y42B", "Y444",
                                           "YUY2", "UYVY", "RGB", "BGR", "RGBx", "BGRx", "xRGB",
                                           "xBGR", "RGBA", "BGRA", "ARGB", "ABGR", "NV16",
                                           "P010_10LE", "I420_10LE", "I422_10LE", "Y210", "v210",
                                           "GRAY16_LE", "GRAY16_BE"),
                         [](const auto &format) { return std::string(format.param); });

} // namespace luma_crop_test
