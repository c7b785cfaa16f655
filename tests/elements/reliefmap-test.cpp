// SPDX-License-Identifier: LGPL-2.1-or-later
#include "relief-buffers.hpp"
#include "video-harness.hpp"

#include <gtest/gtest.h>

namespace reliefmap_test {

using haptic::ReliefField;
using test::Frame;
using test::VideoHarness;

constexpr int kWidth = 320;
constexpr int kHeight = 180;

class ReliefMap : public ::testing::TestWithParam<GstVideoFormat> {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }
};

TEST_P(ReliefMap, WhatIsLightStandsHigh) {
  VideoHarness harness("reliefmap");
  harness.set_format(GetParam(), kWidth, kHeight);
  Frame frame(kWidth, kHeight, 0);
  for (int y = 0; y < kHeight; ++y)
    for (int x = kWidth / 2; x < kWidth; ++x)
      frame.at(x, y) = 255;
  const ReliefField relief = test::relief_of(harness.pass(frame, 0));
  ASSERT_EQ(relief.columns, 40);
  for (std::size_t i = 0; i < relief.cells.size(); ++i) {
    ASSERT_NEAR(relief.cells[i].height, i % 40 < 20 ? -0.01 : 0.01, 1e-5) << i;
    ASSERT_EQ(relief.cells[i].validity, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, ReliefMap,
                         ::testing::Values(GST_VIDEO_FORMAT_RGB, GST_VIDEO_FORMAT_BGR,
                                           GST_VIDEO_FORMAT_RGBx, GST_VIDEO_FORMAT_xBGR,
                                           GST_VIDEO_FORMAT_BGRA, GST_VIDEO_FORMAT_ARGB),
                         [](const auto &format) {
                           return std::string(gst_video_format_to_string(format.param));
                         });

class ReliefMapElement : public ReliefMap {};

TEST_F(ReliefMapElement, ATableThatIsNoneIsAnErrorWithItsCure) {
  for (const auto &[table, cure] : {std::pair("velvet", "Use generic, fabric, foliage"),
                                    {"/dev/null", "touch-table.md"},
                                    {"/nowhere.ini", "touch-table.md"}}) {
    const test::ElementPtr pipeline(gst_parse_launch(
        "videotestsrc num-buffers=1 ! videoconvert ! reliefmap name=map ! fakesink", nullptr));
    const test::ElementPtr map(gst_bin_get_by_name(GST_BIN(pipeline.get()), "map"));
    g_object_set(map.get(), "table", table, nullptr);
    const auto error = test::run_to_end(pipeline.get());
    ASSERT_TRUE(error) << table;
    EXPECT_NE(error->find(cure), std::string::npos) << *error;
  }
}

TEST_F(ReliefMapElement, RunsWithEachBuiltInTable) {
  for (const char *table : {"generic", "fabric", "foliage"}) {
    const std::string line = std::string("videotestsrc num-buffers=2 ! videoconvert ! reliefmap "
                                         "table=") +
                             table + " ! fakesink";
    const test::ElementPtr pipeline(gst_parse_launch(line.c_str(), nullptr));
    EXPECT_EQ(test::run_to_end(pipeline.get()), std::nullopt) << table;
  }
}

} // namespace reliefmap_test
