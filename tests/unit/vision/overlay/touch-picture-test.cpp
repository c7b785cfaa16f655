// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/touch-picture.hpp"

#include "counted-allocations.hpp"
#include "frames/luma-crop.hpp"
#include "frames/mapped-frame.hpp"
#include "video-harness.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace touch_picture_test {

using haptic::BufferPtr;
using haptic::Dent;
using haptic::DentPainter;
using haptic::MappedFrame;
using haptic::ReliefField;
using haptic::ReliefShading;
using test::Frame;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// A grey level that says where a pixel was: 0.5 per px to the right.
Frame ramp() {
  Frame frame(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      frame.pixels[static_cast<std::size_t>(y * kWidth + x)] =
          static_cast<std::uint8_t>(x / 2 + 40);
  return frame;
}

int sample(const MappedFrame &frame, guint component, int x, int y) {
  return *test::sample_of(frame.frame(), component, x, y);
}

class TouchPicture : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }
};

TEST_F(TouchPicture, ADentPullsTowardsItsMiddleByTheStatedAmount) {
  const auto info = test::video_info(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  const BufferPtr buffer = test::to_buffer(ramp(), info);
  MappedFrame frame(info, buffer.get(), GST_MAP_READWRITE);
  // 4 mm of depth, 2 px for each.
  const Dent dent = haptic::dent_at(160.5, 120.5, 0.004, 2, kHeight);
  EXPECT_DOUBLE_EQ(dent.pull, 8);
  EXPECT_DOUBLE_EQ(dent.radius, 40);
  DentPainter().paint(dent, frame.frame());
  const auto was_at = [&](int x) { return 2 * (sample(frame, 0, x, 120) - 40) + 0.5; };
  const int most = static_cast<int>(std::lround(40 / std::sqrt(5.0))); // where the pull is greatest
  EXPECT_NEAR(was_at(160 + most), 160 + most + 8, 1.5);
  EXPECT_NEAR(was_at(160 - most), 160 - most - 8, 1.5);
  EXPECT_NEAR(was_at(160), 160, 1.5) << "the middle stays";
  for (int x = 121; x < 199; ++x)
    EXPECT_GE(was_at(x + 1), was_at(x)) << x << ": nothing is folded";
}

TEST_F(TouchPicture, ADentIsContinuousAtItsRimAndNothingBeyond) {
  const auto info = test::video_info(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  const BufferPtr before = test::to_buffer(ramp(), info);
  const BufferPtr after = test::to_buffer(ramp(), info);
  MappedFrame plain(info, before.get());
  MappedFrame frame(info, after.get(), GST_MAP_READWRITE);
  DentPainter().paint(haptic::dent_at(150, 100, 1, 100, kHeight), frame.frame()); // the deepest
  int changed = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double r = std::hypot(x + 0.5 - 150, y + 0.5 - 100);
      const int difference = std::abs(sample(frame, 0, x, y) - sample(plain, 0, x, y));
      changed += difference > 0;
      if (r >= 40) {
        ASSERT_EQ(difference, 0) << x << ' ' << y;
      } else if (r >= 38) {
        ASSERT_LE(difference, 1) << x << ' ' << y;
      }
    }
  EXPECT_GT(changed, 1500);
}

TEST_F(TouchPicture, WithoutTouchOrSenseThereIsNoDent) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(haptic::dent_at(10, 10, 0, 5, kHeight).pull, 0);
  EXPECT_EQ(haptic::dent_at(10, 10, 0.01, 0, kHeight).pull, 0);
  EXPECT_EQ(haptic::dent_at(10, 10, nan, 5, kHeight).pull, 0);
  EXPECT_EQ(haptic::dent_at(nan, 10, 0.01, 5, kHeight).pull, 0);
  EXPECT_EQ(haptic::dent_at(10, 10, 1, 100, kHeight).pull, 10) << "a quarter of the radius";
}

TEST_F(TouchPicture, ADentIsRoundOnPixelsThatAreNotSquare) {
  auto info = test::video_info(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  GST_VIDEO_INFO_PAR_N(&info) = 2;
  const BufferPtr buffer = test::to_buffer(ramp(), info);
  const BufferPtr before = test::to_buffer(ramp(), info);
  MappedFrame frame(info, buffer.get(), GST_MAP_READWRITE);
  MappedFrame plain(info, before.get());
  DentPainter().paint(haptic::dent_at(160, 120, 1, 100, kHeight), frame.frame());
  int farthest = 0;
  for (int x = 0; x < kWidth; ++x)
    if (sample(frame, 0, x, 120) != sample(plain, 0, x, 120))
      farthest = std::max(farthest, std::abs(x - 160));
  EXPECT_LE(farthest, 20);
  EXPECT_GE(farthest, 16);
}

TEST_F(TouchPicture, EveryFormatIsDentedWithinTheRadiusAlone) {
  const haptic::CapsPtr caps(gst_caps_from_string(GST_VIDEO_CAPS_MAKE(HAPTIC_DRAWN_FORMATS)));
  const GValue *formats = gst_structure_get_value(gst_caps_get_structure(caps.get(), 0), "format");
  for (guint n = 0; n < gst_value_list_get_size(formats); ++n) {
    const char *name = g_value_get_string(gst_value_list_get_value(formats, n));
    const auto info = test::video_info(gst_video_format_from_string(name), kWidth + 1, kHeight - 1);
    Frame picture(kWidth + 1, kHeight - 1);
    for (std::size_t i = 0; i < picture.pixels.size(); ++i)
      picture.pixels[i] = static_cast<std::uint8_t>(i % (kWidth + 1) / 2 + 40);
    const BufferPtr before = test::to_buffer(picture, info);
    const BufferPtr after = test::to_buffer(picture, info);
    MappedFrame plain(info, before.get());
    MappedFrame frame(info, after.get(), GST_MAP_READWRITE);
    DentPainter().paint(haptic::dent_at(160, 120, 0.004, 2, kHeight - 1), frame.frame());
    int changed = 0;
    int astray = 0;
    for (guint c = 0; c < GST_VIDEO_FRAME_N_COMPONENTS(&frame.frame()); ++c)
      for (int y = 0; y < GST_VIDEO_FRAME_COMP_HEIGHT(&frame.frame(), c); ++y)
        for (int x = 0; x < GST_VIDEO_FRAME_COMP_WIDTH(&frame.frame(), c); ++x) {
          if (sample(frame, c, x, y) == sample(plain, c, x, y))
            continue;
          ++changed;
          const double px =
              (x + 0.5) * (kWidth + 1) / GST_VIDEO_FRAME_COMP_WIDTH(&frame.frame(), c);
          const double py =
              (y + 0.5) * (kHeight - 1) / GST_VIDEO_FRAME_COMP_HEIGHT(&frame.frame(), c);
          astray += std::hypot(px - 160, py - 120) > 40;
        }
    EXPECT_GT(changed, 1000) << name;
    EXPECT_EQ(astray, 0) << name;
  }
}

TEST_F(TouchPicture, ADentAtACornerOrOnATinyFrameDoesNoHarm) {
  for (const auto &[width, height] : {std::pair(16, 16), {17, 13}, {1, 1}, {400, 12}})
    for (const auto format :
         {GST_VIDEO_FORMAT_I420, GST_VIDEO_FORMAT_YUY2, GST_VIDEO_FORMAT_BGRx}) {
      const auto info = test::video_info(format, width, height);
      const BufferPtr buffer = test::to_buffer(Frame(width, height, 90), info);
      MappedFrame frame(info, buffer.get(), GST_MAP_READWRITE);
      for (const double at : {0.0, 1.0, 1e30, -1e30})
        DentPainter().paint(haptic::dent_at(at * width, at * height, 1, 100, height),
                            frame.frame());
      EXPECT_EQ(sample(frame, 0, 0, 0), 90) << "an even picture stays even";
    }
}

// Shading

ReliefField relief(double (*height)(int, int)) {
  ReliefField field;
  field.frame_width = kWidth;
  field.frame_height = kHeight;
  field.columns = 32;
  field.rows = 24;
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 32; ++x)
      field.cells.push_back({static_cast<float>(height(x, y)), 100, 0, 1});
  return field;
}

struct Shaded {
  explicit Shaded(const ReliefField &relief, GstVideoFormat format = GST_VIDEO_FORMAT_RGB)
      : info(test::video_info(format, kWidth, kHeight)),
        buffer(test::to_buffer(Frame(kWidth, kHeight, 100), info)),
        frame(info, buffer.get(), GST_MAP_READWRITE) {
    ReliefShading shading;
    shading.read(relief, 1);
    shading.paint(frame.frame());
  }
  int at(int x, int y) const { return sample(frame, 0, x, y); }
  GstVideoInfo info;
  BufferPtr buffer;
  MappedFrame frame;
};

TEST_F(TouchPicture, ALevelSurfaceStaysAsItIsAndATiltedOneIsUniform) {
  const Shaded level(relief([](int, int) { return 0.01; }));
  const Shaded lit(relief([](int x, int) { return 0.001 * x; }));
  const Shaded dark(relief([](int, int y) { return -0.001 * y; }));
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      ASSERT_EQ(level.at(x, y), 100);
      ASSERT_NEAR(lit.at(x, y), lit.at(160, 120), 1);
      ASSERT_NEAR(dark.at(x, y), dark.at(160, 120), 1);
    }
  EXPECT_GT(lit.at(160, 120), 105) << "it faces the light at the top left";
  EXPECT_LT(dark.at(160, 120), 95);
}

TEST_F(TouchPicture, AStepIsSeenWhereItIs) {
  const Shaded shaded(relief([](int x, int) { return x < 16 ? 0.0 : 0.005; }));
  // The step lies between two cells of 1/240 m, whose slopes reach over both.
  const double slope = 0.005 * 240 / 2;
  const double length = std::hypot(1, slope);
  EXPECT_NEAR(shaded.at(160, 120), 100 * (1 + slope / 2) / length, 1.5);
  for (const int x : {0, 80, 140, 180, 240, 319})
    EXPECT_EQ(shaded.at(x, 120), 100) << x;
  const Shaded down(relief([](int x, int) { return x < 16 ? 0.005 : 0.0; }));
  EXPECT_NEAR(down.at(160, 120), 100 * (1 - slope / 2) / length, 1.5);
}

TEST_F(TouchPicture, HolesAreNotShaded) {
  ReliefField tilted = relief([](int x, int) { return 0.002 * x; });
  tilted.cells[12 * 32 + 16] = {};
  const Shaded shaded(tilted);
  for (int y = 120; y < 130; ++y)
    for (int x = 160; x < 170; ++x)
      ASSERT_EQ(shaded.at(x, y), 100);
  EXPECT_GT(shaded.at(145, 125), 105);
  EXPECT_GT(shaded.at(185, 125), 105);
}

TEST_F(TouchPicture, ShadingChangesBrightnessNotBlackNorChroma) {
  const ReliefField tilted = relief([](int x, int) { return 0.002 * x; });
  const Shaded shaded(tilted, GST_VIDEO_FORMAT_I420);
  EXPECT_GT(shaded.at(160, 120), 105);
  for (int y = 0; y < kHeight / 2; ++y)
    for (int x = 0; x < kWidth / 2; ++x)
      ASSERT_EQ(sample(shaded.frame, 1, x, y), 128);
  const auto info = test::video_info(GST_VIDEO_FORMAT_I420, kWidth, kHeight);
  const BufferPtr black = test::to_buffer(Frame(kWidth, kHeight, 16), info);
  MappedFrame frame(info, black.get(), GST_MAP_READWRITE);
  ReliefShading shading;
  shading.read(tilted, 1);
  shading.paint(frame.frame());
  EXPECT_EQ(sample(frame, 0, 160, 120), 16);
}

TEST_F(TouchPicture, NothingIsAllocatedAfterTheFirstFrame) {
  const auto info = test::video_info(GST_VIDEO_FORMAT_I420, kWidth, kHeight);
  const BufferPtr buffer = test::to_buffer(ramp(), info);
  MappedFrame frame(info, buffer.get(), GST_MAP_READWRITE);
  const ReliefField tilted = relief([](int x, int) { return 0.002 * x; });
  DentPainter dents;
  ReliefShading shading;
  const auto paint = [&](double x, double depth) {
    shading.read(tilted, 0.5);
    shading.paint(frame.frame());
    dents.paint(haptic::dent_at(x, 120.3, depth, 2, kHeight), frame.frame());
  };
  paint(5, 0.001);
  const long before = test::allocations;
  for (int i = 0; i < 20; ++i)
    paint(5 + 15.3 * i, 0.0005 * i);
  EXPECT_EQ(test::allocations, before);
}

} // namespace touch_picture_test
