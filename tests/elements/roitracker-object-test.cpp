// SPDX-License-Identifier: LGPL-2.1-or-later
// What roitracker makes of the objects that a detector marked before it.
#include "video-harness.hpp"

#include <gst/video/gstvideometa.h>
#include <gtest/gtest.h>
#include <vector>

namespace roitracker_object_test {

using haptic::BufferPtr;
using test::ElementPtr;
using test::motion_of;
using test::Texture;
using test::VideoHarness;

constexpr GstClockTime kFrame = 40 * GST_MSECOND;
constexpr int kWidth = 176;
constexpr int kHeight = 144;

struct Mark {
  const char *kind = "face";
  guint x = 0, y = 0, width = 0, height = 0; // px
};

class MarkedObject : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  void SetUp() override { harness.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight); }

  // Frame number i of a texture that moves 2 px to the right and 1 up in each, with marks.
  BufferPtr pass(int i, const std::vector<Mark> &marks) { return pass(i, kWidth, kHeight, marks); }
  BufferPtr pass(int i, int width, int height, const std::vector<Mark> &marks) {
    BufferPtr buffer = to_buffer(texture.frame(width, height, {2.0 * i, -1.0 * i}), harness.info);
    GST_BUFFER_PTS(buffer.get()) = static_cast<GstClockTime>(i) * kFrame;
    for (const Mark &mark : marks)
      gst_buffer_add_video_region_of_interest_meta(buffer.get(), mark.kind, mark.x, mark.y,
                                                   mark.width, mark.height);
    EXPECT_EQ(harness.push(std::move(buffer)), GST_FLOW_OK);
    return harness.pull();
  }

  static std::vector<float> region_of(const BufferPtr &frame) {
    const GstHapticMotionMeta &motion = motion_of(frame);
    return {motion.region_x, motion.region_y, motion.region_width, motion.region_height};
  }

  const std::vector<float> kSquare{73, 57, 30, 30};

  Texture texture{1};
  VideoHarness harness{"roitracker roi-size=30 region=object"};
  ElementPtr tracker = harness.element("roitracker");
};

TEST_F(MarkedObject, UnderThePointerIsTheRegion) {
  const std::vector<Mark> face{{.x = 70, .y = 40, .width = 50, .height = 50}};
  pass(0, face);
  const BufferPtr frame = pass(1, face);
  EXPECT_EQ(region_of(frame), (std::vector<float>{70, 40, 50, 50}));
  const auto found = test::displacement(frame.get());
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->x, 2, 0.05);
  EXPECT_NEAR(found->y, -1, 0.05);
}

TEST_F(MarkedObject, OfSeveralTheSmallestCounts) {
  EXPECT_EQ(region_of(pass(0, {{.x = 0, .y = 0, .width = 176, .height = 144},
                               {.kind = "eye", .x = 80, .y = 65, .width = 20, .height = 14},
                               {.x = 50, .y = 40, .width = 90, .height = 80}})),
            (std::vector<float>{80, 65, 20, 14}));
}

TEST_F(MarkedObject, WhereThereIsNoneTheRegionIsTheSquare) {
  EXPECT_EQ(region_of(pass(0, {})), kSquare);
  EXPECT_EQ(region_of(pass(1, {{.x = 89, .y = 40, .width = 60, .height = 60}})), kSquare);
  EXPECT_EQ(region_of(pass(2, {{.x = 80, .y = 70, .width = 0, .height = 9}})), kSquare);
}

TEST_F(MarkedObject, ThatARoitrackerMarkedIsNone) {
  EXPECT_EQ(
      region_of(pass(0, {{.kind = "haptic-roi", .x = 80, .y = 65, .width = 20, .height = 20}})),
      kSquare);
}

TEST_F(MarkedObject, IsClippedAtTheFrameWhereverItEnds) {
  g_object_set(tracker.get(), "pointer-x", 1.0, "pointer-y", 0.5, nullptr);
  EXPECT_EQ(region_of(pass(0, {{.x = 150, .y = 60, .width = G_MAXUINT, .height = G_MAXUINT}})),
            (std::vector<float>{150, 60, 26, 48}));
}

TEST_F(MarkedObject, OfALargeOneTheRegionIsThePartAboutThePointer) {
  EXPECT_EQ(region_of(pass(0, {{.x = 0, .y = 0, .width = 176, .height = 144}})),
            (std::vector<float>{52, 36, 72, 72})); // half of the shorter side of the frame
}

TEST_F(MarkedObject, ThatIsLongAndThinIsMeasuredAboutThePointer) {
  harness.set_format(GST_VIDEO_FORMAT_GRAY8, 704, 576);
  for (const Mark &mark : {Mark{.x = 200, .y = 278, .width = 300, .height = 20},
                           Mark{.x = 342, .y = 150, .width = 20, .height = 280}}) {
    pass(0, 704, 576, {mark});
    const auto found = test::displacement(pass(1, 704, 576, {mark}).get());
    ASSERT_TRUE(found.has_value()) << mark.width;
    EXPECT_NEAR(found->x, 2, 0.05);
    EXPECT_NEAR(found->y, -1, 0.05);
  }
}

TEST_F(MarkedObject, TooSmallToBeMeasuredIsNone) {
  EXPECT_EQ(region_of(pass(0, {{.x = 84, .y = 68, .width = 9, .height = 30}})), kSquare);
}

TEST_F(MarkedObject, ThatTremblesKeepsTheSizeOfItsRegion) {
  const auto marked = [&](int i, guint x, guint width) {
    return region_of(pass(i, {{.x = x, .y = 50, .width = width, .height = 40}}));
  };
  for (int i = 0; i < 6; i += 2) {
    EXPECT_EQ(marked(i, 70, 40), (std::vector<float>{70, 50, 40, 40})) << i;
    EXPECT_EQ(marked(i + 1, 69, 42), (std::vector<float>{70, 50, 40, 40})) << i;
  }
  EXPECT_EQ(marked(6, 65, 50), (std::vector<float>{65, 50, 50, 40}));
}

TEST_F(MarkedObject, ThatTremblesStaysUnderThePointer) {
  pass(0, {{.x = 70, .y = 50, .width = 33, .height = 40}});
  EXPECT_EQ(region_of(pass(1, {{.x = 88, .y = 50, .width = 36, .height = 40}})),
            (std::vector<float>{88, 50, 36, 40}));
}

TEST_F(MarkedObject, CountsOnlyIfItIsAskedFor) {
  gst_util_set_object_arg(G_OBJECT(tracker.get()), "region", "square");
  EXPECT_EQ(region_of(pass(0, {{.x = 70, .y = 40, .width = 50, .height = 50}})), kSquare);
}

TEST_F(MarkedObject, ThatIsPressedIsTheThingAndItsRegionGoesWithIt) {
  const std::vector<Mark> face{{.x = 70, .y = 40, .width = 50, .height = 50}};
  pass(0, face);
  g_object_set(tracker.get(), "pressed", TRUE, nullptr);
  pass(1, face);
  for (int i = 2; i < 11; ++i)
    pass(i, {{.x = 80, .y = 65, .width = 20, .height = 14}}); // of something else
  const BufferPtr frame = pass(11, {});
  EXPECT_EQ(motion_of(frame).hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD));
  // As in the frame before.
  const std::vector<float> region = region_of(frame);
  EXPECT_NEAR(region[0], 70 + 18, 1);
  EXPECT_NEAR(region[1], 40 - 9, 1);
  EXPECT_EQ(region[2], 50);
  EXPECT_EQ(region[3], 50);
  // Let go, the object under the pointer counts again.
  g_object_set(tracker.get(), "pressed", FALSE, nullptr);
  pass(12, {});
  EXPECT_EQ(region_of(pass(13, face)), (std::vector<float>{70, 40, 50, 50}));
}

} // namespace roitracker_object_test
