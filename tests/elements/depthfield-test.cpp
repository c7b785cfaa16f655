// SPDX-License-Identifier: LGPL-2.1-or-later
#include "depth-scene.hpp"
#include "relief-buffers.hpp"
#include "samples/motion-sample.hpp"
#include "video-harness.hpp"

#include <algorithm>
#include <cmath>
#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <gtest/gtest.h>
#include <vector>

namespace depthfield_test {

using haptic::BufferPtr;
using haptic::ReliefField;
using test::relief_of;
using test::VideoHarness;

constexpr GstClockTime kFrame = GST_SECOND / 30;
constexpr int kWidth = 640;
constexpr int kHeight = 480;

class DepthField : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }
  void SetUp() override { harness.set_format(GST_VIDEO_FORMAT_GRAY16_LE, kWidth, kHeight); }

  // A frame whose pixels all hold the value.
  BufferPtr pass(guint16 value, GstClockTime time, guint flags = 0) {
    const gsize size = GST_VIDEO_INFO_SIZE(&harness.info);
    BufferPtr buffer(gst_buffer_new_allocate(nullptr, size, nullptr));
    const std::vector<guint16> pixels(size / 2, GUINT16_TO_LE(value));
    gst_buffer_fill(buffer.get(), 0, pixels.data(), size);
    GST_BUFFER_PTS(buffer.get()) = time;
    GST_BUFFER_FLAG_SET(buffer.get(), flags);
    return harness.push(std::move(buffer)) == GST_FLOW_OK ? harness.pull() : nullptr;
  }

  static bool is_gap(const BufferPtr &buffer) {
    return GST_BUFFER_FLAG_IS_SET(buffer.get(), GST_BUFFER_FLAG_GAP);
  }

  VideoHarness harness{"depthfield"};
  test::ElementPtr element = harness.element("depthfield");
};

TEST_F(DepthField, MakesOneReliefOfEachFrameThatExplainsItself) {
  g_object_set(element.get(), "near", 1.0, "far", 3.0, "range", 0.02, "stiffness", 500.0,
               "friction", 0.7, nullptr);
  const BufferPtr buffer = pass(1500, 0);
  EXPECT_FALSE(is_gap(buffer));
  ReliefField relief = relief_of(buffer);
  EXPECT_EQ(relief.frame_width, kWidth);
  EXPECT_EQ(relief.frame_height, kHeight);
  EXPECT_EQ(relief.columns, 64);
  EXPECT_EQ(relief.rows, 48);
  EXPECT_EQ(relief.flags, haptic::kMotionDiscontinuity);
  for (const haptic::ReliefCell &cell : relief.cells) {
    ASSERT_NEAR(cell.height, 0.005, 1e-6);
    ASSERT_EQ(cell.stiffness, 500);
    ASSERT_EQ(cell.friction, 0.7F);
  }
  relief = relief_of(pass(2500, kFrame));
  EXPECT_NEAR(relief.cells[7].height, -0.005, 1e-6);
  EXPECT_EQ(relief.interval, kFrame);
  EXPECT_EQ(relief.flags, 0);
  const haptic::CapsPtr caps(gst_pad_get_current_caps(harness.get()->sinkpad));
  const GstStructure *structure = gst_caps_get_structure(caps.get(), 0);
  EXPECT_STREQ(gst_structure_get_name(structure), "haptics/x-field");
  gint width = 0;
  EXPECT_TRUE(gst_structure_get_int(structure, "width", &width));
  EXPECT_EQ(width, kWidth);
}

TEST_F(DepthField, AFilmThatLosesItsDepthIsAGapAndNoError) {
  EXPECT_FALSE(is_gap(pass(2000, 0)));
  const BufferPtr lost = pass(0, kFrame);
  EXPECT_TRUE(is_gap(lost));
  EXPECT_TRUE(test::is_silent(relief_of(lost)));
  EXPECT_FALSE(is_gap(pass(2000, 2 * kFrame)));
  EXPECT_FALSE(harness.message(GST_MESSAGE_WARNING));
}

TEST_F(DepthField, MillimetresTakenForMetresAreSilenceAndOneWarning) {
  g_object_set(element.get(), "scale", 1.0, nullptr);
  for (GstClockTime i = 0; i < 3; ++i)
    EXPECT_TRUE(is_gap(pass(2000, i * kFrame)));
  const test::MessagePtr message = harness.message(GST_MESSAGE_WARNING);
  ASSERT_TRUE(message);
  GError *error = nullptr;
  gst_message_parse_warning(message.get(), &error, nullptr);
  EXPECT_NE(std::string(error->message).find("Correct kind and scale"), std::string::npos);
  g_error_free(error);
  EXPECT_FALSE(harness.message(GST_MESSAGE_WARNING));
}

TEST_F(DepthField, AFrameShorterThanItsFormatIsAnError) {
  BufferPtr buffer(gst_buffer_new_allocate(nullptr, 100, nullptr));
  GST_BUFFER_PTS(buffer.get()) = 0;
  EXPECT_EQ(harness.push(std::move(buffer)), GST_FLOW_ERROR);
  EXPECT_TRUE(harness.message(GST_MESSAGE_ERROR));
}

TEST_F(DepthField, EveryPropertyMayBeSetWhileRunningAndEachReliefIsValid) {
  for (GstClockTime i = 0; i < 60; ++i) {
    test::flip_every_property(element.get(), static_cast<int>(i % 20));
    relief_of(pass(static_cast<guint16>(300 * i), i * kFrame));
  }
}

TEST_F(DepthField, ReadsTheFrameOfTheCapsFromABufferOfALargerOne) {
  constexpr gsize kStride = 2UL * kWidth * 2;
  BufferPtr buffer(gst_buffer_new_allocate(nullptr, kStride * kHeight, nullptr));
  std::vector<guint16> pixels(kStride / 2 * kHeight);
  for (std::size_t i = 0; i < pixels.size(); ++i) // what is right of the frame is nearer
    pixels[i] = GUINT16_TO_LE(i % (kStride / 2) < kWidth ? 2000 : 1000);
  gst_buffer_fill(buffer.get(), 0, pixels.data(), kStride * kHeight);
  GST_BUFFER_PTS(buffer.get()) = 0;
  gsize offsets[GST_VIDEO_MAX_PLANES] = {};
  gint strides[GST_VIDEO_MAX_PLANES] = {static_cast<gint>(kStride)};
  gst_buffer_add_video_meta_full(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE,
                                 GST_VIDEO_FORMAT_GRAY16_LE, 2 * kWidth, kHeight, 1, offsets,
                                 strides);
  ASSERT_EQ(harness.push(std::move(buffer)), GST_FLOW_OK);
  const ReliefField relief = relief_of(harness.pull());
  for (const haptic::ReliefCell &cell : relief.cells)
    ASSERT_EQ(cell.height, relief.cells[0].height);
}

TEST_F(DepthField, CutsTheDepthFromAFrameThatHasItBesideThePicture) {
  const test::ElementPtr pipeline(gst_parse_launch(
      "videotestsrc num-buffers=3 ! video/x-raw,format=GRAY8,width=256,height=64 ! "
      "videocrop left=128 ! depthfield kind=disparity scale=76 ! fakesink",
      nullptr));
  EXPECT_EQ(test::run_to_end(pipeline.get()), std::nullopt);
}

// Two cameras beside each other see a scene whose surfaces have grain: left | right, GRAY8.
class StereoPair {
public:
  static constexpr int kWide = test::DepthScene::kWidth;
  static constexpr int kHigh = test::DepthScene::kHeight;

  StereoPair() {
    for (int y = 0; y < kHigh; ++y)
      draw_row(y);
  }
  static double disparity(double x, double y) {
    constexpr double kFocalTimesBaseline = 600 * 0.05; // px m
    return kFocalTimesBaseline / test::DepthScene::depth(x, y, 0.5);
  }

  std::vector<guint8> pixels = std::vector<guint8>(2UL * kWide * kHigh);

private:
  static double noise(int x, int y) {
    std::uint32_t n =
        static_cast<std::uint32_t>(x) * 374761393U + static_cast<std::uint32_t>(y) * 668265263U;
    n = (n ^ n >> 13U) * 1274126177U;
    return (n ^ n >> 16U) % 256;
  }
  static guint8 grain(double x, double y) {
    constexpr double kGrain = 2.5; // px
    const double left = std::floor(x / kGrain);
    const double part = x / kGrain - left;
    const int row = static_cast<int>(y / kGrain);
    return static_cast<guint8>((1 - part) * noise(static_cast<int>(left), row) +
                               part * noise(static_cast<int>(left) + 1, row));
  }
  // The right camera sees what is nearest; what the left one does not see has its own grain.
  void draw_row(int y) {
    guint8 *left = &pixels[2UL * kWide * static_cast<unsigned>(y)];
    guint8 *right = left + kWide;
    std::vector<double> nearest(kWide, 0);
    for (int x = 0; x < kWide; ++x) {
      left[x] = grain(x, y);
      right[x] = grain(x, y + 5000);
    }
    for (double x = 0; x < kWide; x += 0.25) {
      const double d = disparity(x, y);
      const auto at = static_cast<int>(std::lround(x - d));
      if (at < 0 || d <= nearest[static_cast<unsigned>(at)])
        continue;
      nearest[static_cast<unsigned>(at)] = d;
      right[at] = grain(at + d, y);
    }
  }
};

// GStreamer's own element matches the pair. It makes the largest disparity of a frame 255.
TEST_F(DepthField, TouchesWhatAPairOfCamerasSees) {
  const test::ElementPtr matcher(gst_element_factory_make("disparity", nullptr));
  if (!matcher)
    GTEST_SKIP() << "no element disparity: install gstreamer1.0-opencv";
  const test::ElementPtr pipeline(gst_parse_launch(
      "appsrc name=pair format=time ! tee name=t ! queue ! videocrop right=640 ! videoconvert ! "
      "d.sink_left t. ! queue ! videocrop left=640 ! videoconvert ! d.sink_right "
      "disparity name=d method=sgbm ! videoconvert ! video/x-raw,format=GRAY8 ! "
      "depthfield kind=disparity scale=255 near=1 far=4 ! appsink name=reliefs sync=false",
      nullptr));
  const test::ElementPtr source(gst_bin_get_by_name(GST_BIN(pipeline.get()), "pair"));
  const test::ElementPtr sink(gst_bin_get_by_name(GST_BIN(pipeline.get()), "reliefs"));
  const haptic::CapsPtr caps(
      gst_caps_from_string("video/x-raw,format=GRAY8,width=1280,height=360,framerate=30/1"));
  gst_app_src_set_caps(GST_APP_SRC(source.get()), caps.get());
  const StereoPair pair;
  for (GstClockTime n = 0; n < 3; ++n) { // its end may overtake a frame in the matcher
    GstBuffer *frame = gst_buffer_new_memdup(pair.pixels.data(), pair.pixels.size());
    GST_BUFFER_PTS(frame) = n * kFrame;
    gst_app_src_push_buffer(GST_APP_SRC(source.get()), frame);
  }
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  const haptic::SamplePtr sample(
      gst_app_sink_try_pull_sample(GST_APP_SINK(sink.get()), 20 * GST_SECOND));
  ASSERT_TRUE(sample);
  const BufferPtr buffer(gst_buffer_ref(gst_sample_get_buffer(sample.get())));
  const ReliefField relief = relief_of(buffer);
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);

  double largest = 0;
  for (int y = 0; y < StereoPair::kHigh; ++y)
    for (int x = 0; x < StereoPair::kWide; ++x)
      largest = std::max(largest, StereoPair::disparity(x, y));
  constexpr double kRange = 0.04; // m
  std::vector<double> errors;
  const double side = 640.0 / relief.columns;
  for (std::size_t i = 0; i < relief.cells.size(); ++i) {
    const double x = (static_cast<double>(i % relief.columns) + 0.5) * side;
    const double y = (static_cast<double>(i / relief.columns) + 0.5) * side;
    const double v = StereoPair::disparity(x, y) / largest; // 1 at near, 1/4 at far
    if (relief.cells[i].validity > 0)
      errors.push_back(std::abs(static_cast<double>(relief.cells[i].height) -
                                kRange * ((v - 0.25) / 0.75 - 0.5)));
  }
  std::ranges::sort(errors);
  ASSERT_GT(errors.size(), relief.cells.size() * 85 / 100); // the left border has no match
  EXPECT_LE(errors[errors.size() / 2], 0.02 * kRange);
  EXPECT_LE(errors[errors.size() * 9 / 10], 0.03 * kRange);
}

} // namespace depthfield_test
