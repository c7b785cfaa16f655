// SPDX-License-Identifier: LGPL-2.1-or-later
#include "glue/pointer-event.hpp"
#include "video-harness.hpp"

#include <cmath>
#include <cstring>
#include <gst/app/gstappsink.h>
#include <gst/controller/gstdirectcontrolbinding.h>
#include <gst/controller/gstinterpolationcontrolsource.h>
#include <gst/video/gstvideometa.h>
#include <gst/video/gstvideopool.h>
#include <gst/video/navigation.h>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

namespace roitracker_test {

using haptic::BufferPtr;
using haptic::EventPtr;
using test::ElementPtr;
using test::Frame;
using test::motion_of;
using test::Shift;
using test::Texture;
using test::VideoHarness;

constexpr GstClockTime kFrame = 40 * GST_MSECOND;
constexpr int kWidth = 176;
constexpr int kHeight = 144;

GstVideoRegionOfInterestMeta *roi_of(const BufferPtr &buffer) {
  gpointer cursor = nullptr;
  return reinterpret_cast<GstVideoRegionOfInterestMeta *>(gst_buffer_iterate_meta_filtered(
      buffer.get(), &cursor, GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE));
}

// The parameter haptic-motion of the region.
struct RegionMotion {
  double vx = NAN, vy = NAN; // px/s
  double confidence = NAN;
  std::string model;
};

RegionMotion region_motion(const BufferPtr &buffer) {
  RegionMotion motion;
  const GstStructure *fields =
      gst_video_region_of_interest_meta_get_param(roi_of(buffer), "haptic-motion");
  if (!fields)
    return motion;
  gst_structure_get(fields, "vx", G_TYPE_DOUBLE, &motion.vx, "vy", G_TYPE_DOUBLE, &motion.vy,
                    "confidence", G_TYPE_DOUBLE, &motion.confidence, nullptr);
  motion.model = gst_structure_get_string(fields, "model");
  return motion;
}

guint64 statistic(GstElement *tracker, const char *name) {
  GstStructure *stats = nullptr;
  g_object_get(tracker, "stats", &stats, nullptr);
  guint64 value = G_MAXUINT64;
  gst_structure_get_uint64(stats, name, &value);
  gst_structure_free(stats);
  return value;
}

double get_double(GstElement *element, const char *name) {
  gdouble value = -1;
  g_object_get(element, name, &value, nullptr);
  return value;
}

class RoiTracker : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  void SetUp() override {
    g_object_set(tracker.get(), "roi-size", 30, nullptr);
    harness.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  }

  Frame moved(Shift shift) const { return texture.frame(kWidth, kHeight, shift); }

  // Frame number i of uniform motion, 2 px to the right and 1 up each.
  Frame moving(int i) const { return moved({2.0 * i, -1.0 * i}); }

  BufferPtr pass_moving(int i) {
    return harness.pass(moving(i), static_cast<GstClockTime>(i) * kFrame);
  }

  static void expect_motion(const BufferPtr &buffer, Shift shift) {
    const auto found = test::displacement(buffer.get());
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->x, shift.x, 0.05);
    EXPECT_NEAR(found->y, shift.y, 0.05);
  }

  void point_haptic(double x, double y, double z = 0) {
    haptic::PointerPosition position;
    position.x = x;
    position.y = y;
    position.z = z;
    EXPECT_TRUE(gst_harness_push_upstream_event(harness.get(),
                                                haptic::make_pointer_event(position).release()));
  }

  void point_with(const char *source) {
    gst_util_set_object_arg(G_OBJECT(tracker.get()), "pointer-source", source);
  }

  void move_mouse(double x, double y) {
    gst_harness_push_upstream_event(
        harness.get(),
        gst_event_new_navigation(gst_structure_new(
            "application/x-gst-navigation", "event", G_TYPE_STRING, "mouse-move", "button",
            G_TYPE_INT, 0, "pointer_x", G_TYPE_DOUBLE, x, "pointer_y", G_TYPE_DOUBLE, y, nullptr)));
  }

  Texture texture{1};
  VideoHarness harness{"roitracker"};
  ElementPtr tracker = harness.element("roitracker");
};

// What a frame carries

TEST_F(RoiTracker, EachFrameCarriesWhatWasMeasuredSinceTheOneBefore) {
  const BufferPtr first = pass_moving(0);
  EXPECT_EQ(motion_of(first).flags, static_cast<guint>(GST_HAPTIC_MOTION_DISCONTINUITY));
  EXPECT_EQ(motion_of(first).n_patches, 0U);
  EXPECT_EQ(motion_of(first).interval, 0U);
  for (int i = 1; i < 4; ++i) {
    const BufferPtr frame = pass_moving(i);
    expect_motion(frame, {2, -1});
    const GstHapticMotionMeta &motion = motion_of(frame);
    EXPECT_EQ(motion.flags, 0U);
    EXPECT_EQ(motion.interval, kFrame);
    EXPECT_EQ(motion.frame_width, static_cast<guint>(kWidth));
    EXPECT_EQ(motion.frame_height, static_cast<guint>(kHeight));
    EXPECT_EQ(motion.pointer_x, kWidth / 2.0F);
    EXPECT_EQ(motion.pointer_y, kHeight / 2.0F);
    EXPECT_EQ(motion.region_x, 73);
    EXPECT_EQ(motion.region_y, 57);
    EXPECT_EQ(motion.region_width, 30);
    EXPECT_EQ(motion.region_height, 30);
    EXPECT_GE(motion.n_candidates, motion.n_patches);
  }
}

TEST_F(RoiTracker, TheRegionIsMarkedInTheWayOtherToolsUnderstand) {
  const BufferPtr frame = pass_moving(0);
  const GstVideoRegionOfInterestMeta *roi = roi_of(frame);
  ASSERT_NE(roi, nullptr);
  EXPECT_STREQ(g_quark_to_string(roi->roi_type), "haptic-roi");
  EXPECT_EQ(roi->x, 73U);
  EXPECT_EQ(roi->y, 57U);
  EXPECT_EQ(roi->w, 30U);
  EXPECT_EQ(roi->h, 30U);
}

TEST_F(RoiTracker, TheRegionHasTheMotionForReadersWithoutTheHeader) {
  EXPECT_EQ(region_motion(pass_moving(0)).confidence, 0);
  for (int i = 1; i < 4; ++i) {
    const RegionMotion motion = region_motion(pass_moving(i));
    EXPECT_NEAR(motion.vx, 2 * 25, 1.5);
    EXPECT_NEAR(motion.vy, -1 * 25, 1.5);
    EXPECT_GT(motion.confidence, 0.8);
    EXPECT_EQ(motion.model, "translation");
  }
}

TEST_F(RoiTracker, ScalingTheFrameDropsTheMotionOfTheRegionWhoseUnitsWouldBeWrong) {
  VideoHarness scaling(
      "roitracker roi-size=30 ! videoscale ! capsfilter caps=video/x-raw,width=352,height=288");
  scaling.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  scaling.pass(moving(0), 0);
  const BufferPtr frame = scaling.pass(moving(1), kFrame);
  ASSERT_NE(roi_of(frame), nullptr);
  EXPECT_EQ(roi_of(frame)->w, 60U);
  EXPECT_EQ(gst_video_region_of_interest_meta_get_param(roi_of(frame), "haptic-motion"), nullptr);
}

TEST_F(RoiTracker, TheRegionGrowsWithTheFrameUnlessItsSizeIsSet) {
  g_object_set(tracker.get(), "roi-size", 0, nullptr);
  harness.set_format(GST_VIDEO_FORMAT_GRAY8, 352, 288);
  EXPECT_EQ(motion_of(harness.pass(Frame(352, 288), 0)).region_width, 30);
  harness.set_format(GST_VIDEO_FORMAT_GRAY8, 704, 576);
  EXPECT_EQ(motion_of(harness.pass(Frame(704, 576), 0)).region_width, 60);
  g_object_set(tracker.get(), "roi-size", 44, nullptr);
  EXPECT_EQ(motion_of(harness.pass(Frame(704, 576), kFrame)).region_width, 44);
}

TEST_F(RoiTracker, AMarkedFrameIsMarkedAnew) {
  VideoHarness two("roitracker pointer-x=0.1 ! roitracker pointer-x=0.75");
  two.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  const BufferPtr frame = two.pass(moving(0), 0);
  EXPECT_EQ(gst_buffer_get_n_meta(frame.get(), GST_VIDEO_REGION_OF_INTEREST_META_API_TYPE), 1U);
  EXPECT_EQ(motion_of(frame).pointer_x, 132);
  EXPECT_EQ(gst_buffer_get_n_meta(frame.get(), gst_meta_get_info(GST_HAPTIC_MOTION_META_NAME)->api),
            1U);
}

TEST_F(RoiTracker, ScalingTheFrameScalesItsMotion) {
  VideoHarness scaling(
      "roitracker roi-size=30 ! videoscale ! capsfilter caps=video/x-raw,width=352,height=216");
  scaling.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  scaling.pass(moving(0), 0);
  const BufferPtr frame = scaling.pass(moving(1), kFrame);
  expect_motion(frame, {2 * 2, -1 * 1.5});
  EXPECT_EQ(motion_of(frame).frame_width, 352U);
  EXPECT_EQ(motion_of(frame).frame_height, 216U);
  EXPECT_EQ(motion_of(frame).region_width, 60);
  EXPECT_EQ(motion_of(frame).pointer_x, 176);
}

// Borders may be about the picture, and nothing says how wide.
TEST_F(RoiTracker, AFrameOfAnotherShapeHasNoMotion) {
  VideoHarness scaling("roitracker ! videoscale ! "
                       "capsfilter caps=video/x-raw,width=352,height=352,pixel-aspect-ratio=1/1");
  scaling.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  EXPECT_EQ(gst_buffer_get_haptic_motion_meta(scaling.pass(moving(0), 0).get()), nullptr);
}

TEST_F(RoiTracker, ScalingBelievesNoNumberOfPatches) {
  const BufferPtr frame(gst_buffer_new());
  GstHapticMotionMeta &motion = test::add_motion(frame);
  motion.frame_width = kWidth;
  motion.frame_height = kHeight;
  motion.n_patches = G_MAXUINT;
  GstVideoInfo in;
  GstVideoInfo out;
  gst_video_info_set_format(&in, GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  gst_video_info_set_format(&out, GST_VIDEO_FORMAT_GRAY8, 2 * kWidth, 2 * kHeight);
  GstVideoMetaTransform scaled{&in, &out};
  const BufferPtr larger(gst_buffer_new());
  ASSERT_TRUE(gst_meta_get_info(GST_HAPTIC_MOTION_META_NAME)
                  ->transform_func(larger.get(), &motion.meta, frame.get(),
                                   gst_video_meta_transform_scale_get_quark(), &scaled));
  EXPECT_EQ(motion_of(larger).frame_width, 2U * kWidth);
}

TEST_F(RoiTracker, CroppingTheFrameDropsWhatWouldBeWrong) {
  VideoHarness cropping("roitracker ! videocrop left=8 ! identity");
  cropping.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  EXPECT_EQ(gst_buffer_get_haptic_motion_meta(cropping.pass(moving(0), 0).get()), nullptr);
}

// Pixels and memory

TEST_F(RoiTracker, AFrameThatNobodyElseHoldsGoesThroughAsItIs) {
  BufferPtr in = test::to_buffer(moving(0), harness.info);
  GST_BUFFER_PTS(in.get()) = 0;
  GstBuffer *const address = in.get();
  harness.push(std::move(in));
  EXPECT_EQ(harness.pull().get(), address);
}

TEST_F(RoiTracker, AFrameThatOthersHoldIsSharedByReferenceAndStaysUntouched) {
  for (int i = 0; i < 3; ++i) {
    const BufferPtr held = test::to_buffer(moving(i), harness.info);
    GST_BUFFER_PTS(held.get()) = static_cast<GstClockTime>(i) * kFrame;
    harness.push(BufferPtr(gst_buffer_ref(held.get())));
    const BufferPtr out = harness.pull();
    EXPECT_NE(out.get(), held.get());
    EXPECT_EQ(gst_buffer_peek_memory(out.get(), 0), gst_buffer_peek_memory(held.get(), 0));
    EXPECT_EQ(gst_buffer_get_haptic_motion_meta(held.get()), nullptr);
    GstMapInfo map;
    gst_buffer_map(held.get(), &map, GST_MAP_READ);
    EXPECT_EQ(std::vector<std::uint8_t>(map.data, map.data + map.size), moving(i).pixels);
    gst_buffer_unmap(held.get(), &map);
    EXPECT_EQ(GST_BUFFER_PTS(out.get()), GST_BUFFER_PTS(held.get()));
    if (i > 0)
      expect_motion(out, {2, -1});
  }
}

TEST_F(RoiTracker, BehindATeeBothBranchesHaveTheSameMemory) {
  const ElementPtr pipeline(gst_parse_launch(
      "videotestsrc num-buffers=5 ! video/x-raw,format=I420,width=176,height=144 ! tee name=t "
      "t. ! queue ! roitracker ! appsink name=tracked sync=false "
      "t. ! queue ! appsink name=plain sync=false",
      nullptr));
  const ElementPtr tracked(gst_bin_get_by_name(GST_BIN(pipeline.get()), "tracked"));
  const ElementPtr plain(gst_bin_get_by_name(GST_BIN(pipeline.get()), "plain"));
  gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  for (int i = 0; i < 5; ++i) {
    const auto next_of = [](const ElementPtr &sink) {
      return haptic::SamplePtr(
          gst_app_sink_try_pull_sample(GST_APP_SINK(sink.get()), 10 * GST_SECOND));
    };
    const haptic::SamplePtr one = next_of(tracked);
    const haptic::SamplePtr other = next_of(plain);
    ASSERT_TRUE(one && other);
    EXPECT_EQ(gst_buffer_peek_memory(gst_sample_get_buffer(one.get()), 0),
              gst_buffer_peek_memory(gst_sample_get_buffer(other.get()), 0));
  }
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
}

TEST_F(RoiTracker, ABufferReturnsToItsPoolOnlyWhenNobodyReadsItsMemory) {
  GstBufferPool *pool = gst_video_buffer_pool_new();
  GstStructure *config = gst_buffer_pool_get_config(pool);
  const haptic::CapsPtr caps(gst_video_info_to_caps(&harness.info));
  gst_buffer_pool_config_set_params(config, caps.get(), kWidth * kHeight, 1, 1);
  gst_buffer_pool_set_config(pool, config);
  gst_buffer_pool_set_active(pool, TRUE);

  GstBuffer *buffer = nullptr;
  gst_buffer_pool_acquire_buffer(pool, &buffer, nullptr);
  BufferPtr held(buffer);
  GST_BUFFER_PTS(held.get()) = 0;
  harness.push(BufferPtr(gst_buffer_ref(held.get())));
  BufferPtr out = harness.pull();
  held.reset();

  GstBufferPoolAcquireParams at_once{};
  at_once.flags = GST_BUFFER_POOL_ACQUIRE_FLAG_DONTWAIT;
  EXPECT_NE(gst_buffer_pool_acquire_buffer(pool, &buffer, &at_once), GST_FLOW_OK);
  out.reset();
  EXPECT_NE(gst_buffer_pool_acquire_buffer(pool, &buffer, &at_once), GST_FLOW_OK)
      << "it is the frame to compare the next one with";
  const haptic::QueryPtr drain(gst_query_new_drain());
  gst_pad_query(GST_PAD_PEER(harness.get()->srcpad), drain.get());
  ASSERT_EQ(gst_buffer_pool_acquire_buffer(pool, &buffer, &at_once), GST_FLOW_OK)
      << "whoever drains wants every buffer back";
  gst_buffer_unref(buffer);
  gst_buffer_pool_set_active(pool, FALSE);
  gst_object_unref(pool);
}

TEST_F(RoiTracker, AsksForOneBufferMoreThanDownstreamWants) {
  const haptic::CapsPtr caps(gst_video_info_to_caps(&harness.info));
  const auto ask = [&] {
    haptic::QueryPtr query(gst_query_new_allocation(caps.get(), TRUE));
    EXPECT_TRUE(gst_pad_peer_query(harness.get()->srcpad, query.get()));
    return query;
  };
  const auto least_of = [](const haptic::QueryPtr &query) {
    guint least = 0;
    EXPECT_EQ(gst_query_get_n_allocation_pools(query.get()), 1U);
    gst_query_parse_nth_allocation_pool(query.get(), 0, nullptr, nullptr, &least, nullptr);
    return least;
  };
  EXPECT_GE(least_of(ask()), 2U) << "one in work and the one before";

  gst_pad_set_query_function(
      harness.get()->sinkpad, [](GstPad *pad, GstObject *parent, GstQuery *query) -> gboolean {
        if (GST_QUERY_TYPE(query) != GST_QUERY_ALLOCATION)
          return gst_pad_query_default(pad, parent, query);
        gst_query_add_allocation_pool(query, nullptr, kWidth * kHeight, 3, 5);
        gst_query_add_allocation_meta(query, GST_VIDEO_META_API_TYPE, nullptr);
        gst_query_add_allocation_meta(query, GST_VIDEO_CROP_META_API_TYPE, nullptr);
        return TRUE;
      });
  const haptic::QueryPtr query = ask();
  EXPECT_EQ(least_of(query), 4U);
  EXPECT_TRUE(gst_query_find_allocation_meta(query.get(), GST_VIDEO_META_API_TYPE, nullptr));
  EXPECT_FALSE(gst_query_find_allocation_meta(query.get(), GST_VIDEO_CROP_META_API_TYPE, nullptr))
      << "the tracker reads whole buffers";
}

// Formats and sizes

class RoiTrackerFormats : public RoiTracker, public ::testing::WithParamInterface<const char *> {};

TEST_P(RoiTrackerFormats, AgreeAtOddWidths) {
  const GstVideoFormat format = gst_video_format_from_string(GetParam());
  for (const int width : {321, 322, 323}) {
    harness.set_format(format, width, 101);
    harness.pass(texture.frame(width, 101, {}), 0);
    expect_motion(harness.pass(texture.frame(width, 101, {3.25, -1.5}), kFrame), {3.25, -1.5});
  }
}

INSTANTIATE_TEST_SUITE_P(All, RoiTrackerFormats,
                         ::testing::Values("GRAY8", "I420", "YV12", "NV12", "NV21", "Y42B", "Y444",
                                           "YUY2", "UYVY", "RGB", "BGR", "RGBx", "BGRx", "xRGB",
                                           "xBGR", "RGBA", "BGRA", "ARGB", "ABGR", "NV16",
                                           "P010_10LE", "I420_10LE", "I422_10LE", "Y210", "v210",
                                           "GRAY16_LE", "GRAY16_BE"),
                         [](const auto &format) { return std::string(format.param); });

// Near and far moves of the pointer, regions of any size, too small ones, repeated frames and
// time stamps: what is kept of a converted frame must always be that of the frame.
TEST_F(RoiTracker, WhatIsConvertedIsMeasuredAsWhatIsNot) {
  std::vector<Frame> movie;
  for (int i = 0; i < 8; ++i)
    movie.push_back(moving(i));
  for (const char *format : {"YUY2", "UYVY", "BGR", "xRGB", "BGRA", "I420_10LE"}) {
    VideoHarness harnesses[] = {VideoHarness("roitracker"), VideoHarness("roitracker")};
    harnesses[0].set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
    harnesses[1].set_format(gst_video_format_from_string(format), kWidth, kHeight);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    double x = 0.5;
    GstClockTime time = 0;
    std::size_t shown = 0;
    guint patches = 0;
    for (int i = 0; i < 300; ++i) {
      x = random() % 8 == 0 ? unit(random) : std::clamp(x + 0.05 * (unit(random) - 0.5), 0.0, 1.0);
      const double y = random() % 8 == 0 ? unit(random) : 0.5;
      const guint size = random() % 4 == 0 ? 8 + static_cast<guint>(random() % 60) : 30;
      shown += random() % 4 > 0;
      time += random() % 16 > 0 ? kFrame : 0;
      BufferPtr found[2];
      for (int k = 0; k < 2; ++k) {
        g_object_set(harnesses[k].element("roitracker").get(), "pointer-x", x, "pointer-y", y,
                     "roi-size", size, nullptr);
        found[k] = harnesses[k].pass(movie[shown % movie.size()], time);
      }
      const GstHapticMotionMeta &plane = motion_of(found[0]);
      const GstHapticMotionMeta &converted = motion_of(found[1]);
      ASSERT_EQ(converted.flags, plane.flags) << format << ", frame " << i;
      ASSERT_EQ(converted.n_candidates, plane.n_candidates) << format << ", frame " << i;
      ASSERT_EQ(converted.n_patches, plane.n_patches) << format << ", frame " << i;
      ASSERT_EQ(
          std::memcmp(converted.patches, plane.patches, plane.n_patches * sizeof(plane.patches[0])),
          0)
          << format << ", frame " << i;
      patches += plane.n_patches;
    }
    EXPECT_GT(patches, 100U) << "something was compared";
  }
}

TEST_F(RoiTracker, RowsMayBeFurtherApartThanTheFrameIsWide) {
  constexpr gsize kStride = 400;
  constexpr gsize kOffset = 48;
  const auto strided = [&](const Frame &frame, GstClockTime pts) {
    BufferPtr buffer(gst_buffer_new_allocate(nullptr, kOffset + kStride * kHeight, nullptr));
    gst_buffer_memset(buffer.get(), 0, 255, kOffset + kStride * kHeight);
    for (int y = 0; y < kHeight; ++y)
      gst_buffer_fill(buffer.get(), kOffset + static_cast<gsize>(y) * kStride,
                      &frame.pixels[static_cast<std::size_t>(y) * kWidth], kWidth);
    gsize offset[GST_VIDEO_MAX_PLANES] = {kOffset};
    gint stride[GST_VIDEO_MAX_PLANES] = {static_cast<gint>(kStride)};
    gst_buffer_add_video_meta_full(buffer.get(), GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8,
                                   kWidth, kHeight, 1, offset, stride);
    GST_BUFFER_PTS(buffer.get()) = pts;
    return buffer;
  };
  harness.push(strided(moving(0), 0));
  harness.pull();
  harness.push(strided(moving(1), kFrame));
  expect_motion(harness.pull(), {2, -1});
}

TEST_F(RoiTracker, WorksAtAnySizeAndMeasuresNothingWhereThereIsTooLittle) {
  for (const char *format : {"GRAY8", "I420", "YUY2", "RGB"})
    for (int size = 1; size <= 40; ++size) {
      harness.set_format(gst_video_format_from_string(format), size, size);
      harness.pass(texture.frame(size, size, {}), 0);
      const BufferPtr frame = harness.pass(texture.frame(size, size, {0.5, 0.5}), kFrame);
      ASSERT_NE(frame, nullptr) << format << size;
      if (size < 12) {
        EXPECT_EQ(motion_of(frame).n_patches, 0U) << format << size;
      }
    }
}

TEST_F(RoiTracker, NearTheBorderTheRegionIsClippedAndStillRight) {
  harness.pass(moving(0), 0);
  int i = 1;
  for (const auto &[x, y] :
       {std::pair{0.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}, {1.0, 1.0}, {0.5, 0.03}}) {
    g_object_set(tracker.get(), "pointer-x", x, "pointer-y", y, nullptr);
    const BufferPtr frame = pass_moving(i++);
    EXPECT_LT(motion_of(frame).region_width * motion_of(frame).region_height, 30 * 30);
    const auto found = test::displacement(frame.get());
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->x, 2, 0.2);
    EXPECT_NEAR(found->y, -1, 0.2);
  }
}

TEST_F(RoiTracker, BelowTwelvePixelsOfRegionNothingIsMeasured) {
  g_object_set(tracker.get(), "roi-size", 20, "pointer-x", 0.0, nullptr);
  pass_moving(0);
  const BufferPtr frame = pass_moving(1);
  EXPECT_EQ(motion_of(frame).n_patches, 0U);
  EXPECT_EQ(motion_of(frame).flags, 0U);
  EXPECT_EQ(motion_of(frame).region_width, 10);
}

TEST_F(RoiTracker, AFrameShorterThanItsFormatIsAnErrorThatSaysSo) {
  pass_moving(0);
  BufferPtr stub(gst_buffer_new_allocate(nullptr, 100, nullptr));
  GST_BUFFER_PTS(stub.get()) = kFrame;
  EXPECT_EQ(harness.push(std::move(stub)), GST_FLOW_ERROR);
  const test::MessagePtr message = harness.message(GST_MESSAGE_ERROR);
  ASSERT_NE(message, nullptr);
  GError *error = nullptr;
  gst_message_parse_error(message.get(), &error, nullptr);
  EXPECT_NE(std::string(error->message).find("cannot be read"), std::string::npos);
  g_error_free(error);
}

TEST_F(RoiTracker, AFrameThatContradictsItsFormatIsAnError) {
  pass_moving(0);
  BufferPtr liar = test::to_buffer(Frame(20, 20), test::video_info(GST_VIDEO_FORMAT_GRAY8, 20, 20));
  gst_buffer_add_video_meta(liar.get(), GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_GRAY8, 20, 20);
  GST_BUFFER_PTS(liar.get()) = kFrame;
  EXPECT_EQ(harness.push(std::move(liar)), GST_FLOW_ERROR);
  EXPECT_NE(harness.message(GST_MESSAGE_ERROR), nullptr);
}

// The pixels of the frame that was too small to be measured are the earlier ones, not those before.
TEST_F(RoiTracker, AfterAFrameThatIsNotMeasuredTheMotionIsSinceThatFrame) {
  g_object_set(tracker.get(), "roi-size", 20, nullptr);
  for (int i = 0; i < 12; ++i) {
    const bool is_measured = i % 3 != 2;
    g_object_set(tracker.get(), "pointer-x", is_measured ? 0.5 : 0.0, nullptr);
    const BufferPtr frame = pass_moving(i);
    if (i > 0 && is_measured)
      expect_motion(frame, {2, -1});
    else
      EXPECT_EQ(motion_of(frame).n_patches, 0U);
  }
}

// Time

TEST_F(RoiTracker, TheIntervalComesFromTimeStampsAndNotFromTheFrameRate) {
  GstClockTime time = 0;
  harness.pass(moving(0), time);
  int i = 1;
  for (const GstClockTime interval : {5U, 100U, 330U, 730U, 17U}) {
    const BufferPtr frame = harness.pass(moving(i++), time += interval * GST_MSECOND);
    EXPECT_EQ(motion_of(frame).interval, interval * GST_MSECOND);
    expect_motion(frame, {2, -1});
  }
}

TEST_F(RoiTracker, ADiscontinuityIsNoMotion) {
  const auto starts_anew = [&](const BufferPtr &frame) {
    return motion_of(frame).flags == GST_HAPTIC_MOTION_DISCONTINUITY &&
           motion_of(frame).n_patches == 0 && motion_of(frame).interval == 0;
  };
  pass_moving(0);
  pass_moving(1);
  EXPECT_TRUE(starts_anew(harness.pass(moving(2), 2 * kFrame, GST_BUFFER_FLAG_DISCONT)));
  expect_motion(pass_moving(3), {2, -1});

  gst_harness_push_event(harness.get(), gst_event_new_flush_start());
  gst_harness_push_event(harness.get(), gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(harness.get(), gst_event_new_segment(&segment));
  EXPECT_TRUE(starts_anew(pass_moving(4)));
  expect_motion(pass_moving(5), {2, -1});

  gst_harness_push_event(harness.get(), gst_event_new_segment(&segment));
  EXPECT_TRUE(starts_anew(pass_moving(6)));

  EXPECT_TRUE(starts_anew(harness.pass(moving(7), GST_CLOCK_TIME_NONE)));
  EXPECT_TRUE(starts_anew(pass_moving(8)));
  expect_motion(pass_moving(9), {2, -1});

  EXPECT_TRUE(starts_anew(harness.pass(moving(10), 3 * kFrame))) << "backwards";
  expect_motion(harness.pass(moving(11), 4 * kFrame), {2, -1});

  EXPECT_TRUE(starts_anew(harness.pass(moving(12), 4 * kFrame + 3 * GST_SECOND))) << "a pause";
  EXPECT_EQ(statistic(tracker.get(), "discontinuities"), 8U);

  segment.rate = -1;
  segment.stop = 10 * GST_SECOND;
  gst_harness_push_event(harness.get(), gst_event_new_segment(&segment));
  const auto pass_back = [&](int n) {
    return harness.pass(moving(n), n * kFrame, GST_BUFFER_FLAG_DISCONT);
  };
  EXPECT_TRUE(starts_anew(pass_back(9)));
  expect_motion(pass_back(8), {-2, 1}); // what is decoded for itself is no cut
}

TEST_F(RoiTracker, EqualTimeStampsMeasureNothing) {
  pass_moving(0);
  const BufferPtr same = harness.pass(moving(1), 0);
  EXPECT_EQ(motion_of(same).n_patches, 0U);
  EXPECT_EQ(motion_of(same).interval, 0U);
  expect_motion(harness.pass(moving(2), kFrame), {4, -2});
}

TEST_F(RoiTracker, PlayedBackwardsMotionIsAsSeen) {
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.rate = -1;
  segment.stop = GST_SECOND;
  gst_harness_push_event(harness.get(), gst_event_new_segment(&segment));
  harness.pass(moving(5), 5 * kFrame);
  const BufferPtr frame = harness.pass(moving(4), 4 * kFrame);
  EXPECT_EQ(motion_of(frame).interval, kFrame);
  expect_motion(frame, {-2, 1});
}

TEST_F(RoiTracker, NewCapsInMidStreamStartAnew) {
  pass_moving(0);
  pass_moving(1);
  harness.set_format(GST_VIDEO_FORMAT_RGB, 321, 243);
  const BufferPtr first = harness.pass(texture.frame(321, 243, {}), 2 * kFrame);
  EXPECT_EQ(motion_of(first).flags, static_cast<guint>(GST_HAPTIC_MOTION_DISCONTINUITY));
  EXPECT_EQ(motion_of(first).frame_width, 321U);
  expect_motion(harness.pass(texture.frame(321, 243, {1, 1}), 3 * kFrame), {1, 1});
}

// The third dimension of the hand

TEST_F(RoiTracker, AHandPulledTowardsTheUserFeelsMoreOfTheFrame) {
  // The last would be 120 px, but half of the frame is enough.
  const std::pair<double, float> kSides[] = {{0.2, 40.0F}, {0.5, 60.0F}, {-0.4, 18.0F}, {1, 72.0F}};
  point_with("haptic");
  int i = 0;
  for (const auto &[z, side] : kSides) {
    point_haptic(0.5, 0.5, z);
    const BufferPtr frame = pass_moving(i++);
    EXPECT_EQ(motion_of(frame).region_width, side) << z;
    if (i > 1)
      expect_motion(frame, {2, -1}); // the size does not change the motion
  }
}

TEST_F(RoiTracker, AChangeOfTheSizeAloneIsExactlyNothing) {
  point_with("haptic");
  const Frame still = moving(0);
  for (int i = 0; i < 40; ++i) {
    point_haptic(0.5, 0.5, i % 2 ? 0.8 : -0.3);
    const BufferPtr frame = harness.pass(still, static_cast<GstClockTime>(i) * kFrame);
    EXPECT_EQ(motion_of(frame).n_patches, 0U);
    if (i > 2) {
      EXPECT_EQ(motion_of(frame).flags, static_cast<guint>(GST_HAPTIC_MOTION_STILL));
    }
  }
}

// Frames that do not change

TEST_F(RoiTracker, OverAStillVideoAMovingPointerFindsExactlyNothing) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  const Frame still = moving(0);
  double x = 0.5;
  harness.pass(still, 0);
  for (int i = 1; i < 3; ++i)
    EXPECT_EQ(motion_of(harness.pass(still, static_cast<GstClockTime>(i) * kFrame)).flags,
              static_cast<guint>(GST_HAPTIC_MOTION_DUPLICATE))
        << "as yet it might move";
  for (int i = 3; i < 200; ++i) {
    if (i % 7 == 0)
      x = unit(random); // a jump
    else
      x = std::clamp(x + 0.1 * (unit(random) - 0.5), 0.2, 0.8);
    g_object_set(tracker.get(), "pointer-x", x, "pointer-y", 0.2 + 0.6 * unit(random), "roi-size",
                 12 + static_cast<guint>(random() % 60), nullptr);
    const BufferPtr frame = harness.pass(still, static_cast<GstClockTime>(i) * kFrame);
    ASSERT_EQ(motion_of(frame).flags, static_cast<guint>(GST_HAPTIC_MOTION_STILL)) << i;
    ASSERT_EQ(motion_of(frame).n_patches, 0U) << i;
  }
  EXPECT_EQ(statistic(tracker.get(), "still"), 197U);
}

TEST_F(RoiTracker, ARepeatedFrameIsADuplicateAndTheNextIntervalSpansBoth) {
  pass_moving(0);
  pass_moving(1);
  const BufferPtr again = harness.pass(moving(1), 2 * kFrame);
  EXPECT_EQ(motion_of(again).flags, static_cast<guint>(GST_HAPTIC_MOTION_DUPLICATE));
  EXPECT_EQ(motion_of(again).n_patches, 0U);
  const BufferPtr next = harness.pass(moving(3), 3 * kFrame);
  EXPECT_EQ(motion_of(next).interval, 2 * kFrame);
  expect_motion(next, {4, -2});
  EXPECT_EQ(statistic(tracker.get(), "duplicates"), 1U);
}

// A wave that moves by more than a quarter of its period is followed only from the motion before.
TEST_F(RoiTracker, ARepeatedFrameDoesNotInterruptWhatIsFollowed) {
  constexpr double kPeriod = 8; // px
  const auto wave = [](double shift) {
    Frame frame(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        frame.at(x, y) = static_cast<std::uint8_t>(
            std::lround(128 + 60 * std::sin(2 * std::numbers::pi * (x - shift) / kPeriod)));
    return frame;
  };
  for (const int times : {1, 2, 3}) {
    GstClockTime time = 0;
    double shift = 0;
    harness.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
    const auto show = [&] {
      const BufferPtr first = harness.pass(wave(shift), time += kFrame);
      for (int i = 1; i < times; ++i)
        EXPECT_EQ(motion_of(harness.pass(wave(shift), time += kFrame)).flags,
                  static_cast<guint>(GST_HAPTIC_MOTION_DUPLICATE));
      return test::displacement(first.get());
    };
    show();
    for (int speed = 1; speed <= 5; ++speed)
      for (int i = 0; i < 3; ++i) {
        shift += speed;
        const auto found = show();
        ASSERT_TRUE(found.has_value()) << times << " times, " << speed << " px";
        EXPECT_NEAR(found->x, speed, 0.05) << times << " times";
      }
  }
}

TEST_F(RoiTracker, WhatRepeatsThriceStandsStillAndMovesOnFromThere) {
  pass_moving(0);
  pass_moving(1);
  harness.pass(moving(1), 2 * kFrame);
  harness.pass(moving(1), 3 * kFrame);
  EXPECT_EQ(motion_of(harness.pass(moving(1), 4 * kFrame)).flags,
            static_cast<guint>(GST_HAPTIC_MOTION_STILL));
  const BufferPtr next = harness.pass(moving(2), 5 * kFrame);
  EXPECT_EQ(motion_of(next).interval, kFrame);
  expect_motion(next, {2, -1});
}

TEST_F(RoiTracker, ThePointerThatLeavesAMovingObjectFindsStillnessAtOnce) {
  const Texture ground(20);
  const auto scene = [&](int i) {
    Frame frame(400, kHeight);
    texture.paint(frame, {2.0 * i, 0}, 0, 200);
    ground.paint(frame, {}, 200, 400);
    return frame;
  };
  harness.set_format(GST_VIDEO_FORMAT_GRAY8, 400, kHeight);
  g_object_set(tracker.get(), "pointer-x", 0.25, nullptr);
  harness.pass(scene(0), 0);
  expect_motion(harness.pass(scene(1), kFrame), {2, 0});
  g_object_set(tracker.get(), "pointer-x", 0.75, nullptr);
  EXPECT_EQ(motion_of(harness.pass(scene(2), 2 * kFrame)).flags,
            static_cast<guint>(GST_HAPTIC_MOTION_STILL));
}

TEST_F(RoiTracker, FollowsTheObjectUnderThePointerAndNotTheOther) {
  const Texture other(20);
  const auto scene = [&](int i) {
    Frame frame(400, kHeight);
    texture.paint(frame, {-3.0 * i, 0}, 0, 200);
    other.paint(frame, {3.0 * i, 0}, 200, 400);
    return frame;
  };
  harness.set_format(GST_VIDEO_FORMAT_GRAY8, 400, kHeight);
  int i = 0;
  harness.pass(scene(i), 0);
  for (const auto &[x, dx] : {std::pair{0.25, -3.0}, {0.75, 3.0}, {0.25, -3.0}}) {
    g_object_set(tracker.get(), "pointer-x", x, nullptr);
    ++i;
    expect_motion(harness.pass(scene(i), static_cast<GstClockTime>(i) * kFrame), {dx, 0});
  }
}

TEST_F(RoiTracker, TheSpeedOfThePointerDoesNotAddToTheMotion) {
  pass_moving(0);
  for (int i = 1; i < 30; ++i) {
    g_object_set(tracker.get(), "pointer-x", i % 2 ? 0.3 : 0.7, nullptr);
    expect_motion(pass_moving(i), {2, -1});
  }
}

// The pointer

TEST_F(RoiTracker, APointerEventMovesTheRegionAndGoesNoFurther) {
  point_with("haptic");
  pass_moving(0);
  point_haptic(0.75, 0.25);
  EXPECT_EQ(harness.upstream_event(GST_EVENT_CUSTOM_UPSTREAM), nullptr);
  const BufferPtr frame = pass_moving(1);
  EXPECT_EQ(motion_of(frame).pointer_x, 0.75F * kWidth);
  EXPECT_EQ(motion_of(frame).pointer_y, 0.25F * kHeight);
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.75);
  EXPECT_EQ(get_double(tracker.get(), "pointer-y"), 0.25);
}

TEST_F(RoiTracker, EventsOfOthersTravelOn) {
  gst_harness_push_upstream_event(
      harness.get(),
      gst_event_new_custom(GST_EVENT_CUSTOM_UPSTREAM, gst_structure_new_empty("something-else")));
  EXPECT_NE(harness.upstream_event(GST_EVENT_CUSTOM_UPSTREAM), nullptr);
}

TEST_F(RoiTracker, TheMouseMovesTheRegionAndTravelsOn) {
  pass_moving(0);
  move_mouse(44, 108);
  EXPECT_NE(harness.upstream_event(GST_EVENT_NAVIGATION), nullptr);
  const BufferPtr frame = pass_moving(1);
  EXPECT_EQ(motion_of(frame).pointer_x, 44);
  EXPECT_EQ(motion_of(frame).pointer_y, 108);
  move_mouse(-20, 1000);
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0);
  EXPECT_EQ(get_double(tracker.get(), "pointer-y"), 1);
}

TEST_F(RoiTracker, ButtonsAndTouchesPointToo) {
  pass_moving(0);
  gst_harness_push_upstream_event(harness.get(), gst_navigation_event_new_mouse_button_press(
                                                     1, 88, 36, GST_NAVIGATION_MODIFIER_NONE));
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.5);
  EXPECT_EQ(get_double(tracker.get(), "pointer-y"), 0.25);
  gst_harness_push_upstream_event(harness.get(), gst_navigation_event_new_touch_down(
                                                     0, 44, 72, 1, GST_NAVIGATION_MODIFIER_NONE));
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.25);
  gst_harness_push_upstream_event(harness.get(), gst_navigation_event_new_touch_motion(
                                                     0, 132, 72, 1, GST_NAVIGATION_MODIFIER_NONE));
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.75);
  gst_harness_push_upstream_event(
      harness.get(), gst_navigation_event_new_key_press("a", GST_NAVIGATION_MODIFIER_NONE));
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.75);
}

TEST_F(RoiTracker, TheHandComesBeforeTheMouseAndBothBeforeTheProperties) {
  pass_moving(0);
  g_object_set(tracker.get(), "pointer-x", 0.1, nullptr);
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.1);
  move_mouse(88, 72);
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.5);
  double in_use = 0;
  test::within_a_second([&] {
    point_haptic(0.9, 0.9);
    in_use = get_double(tracker.get(), "pointer-x");
  });
  EXPECT_EQ(in_use, 0.9);
  point_with("navigation");
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.5);
  point_with("property");
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.1);
  point_with("haptic");
  EXPECT_EQ(get_double(tracker.get(), "pointer-x"), 0.9);
}

TEST_F(RoiTracker, AControllerMovesThePointerAlongTheStream) {
  GstControlSource *source = gst_interpolation_control_source_new();
  g_object_set(source, "mode", GST_INTERPOLATION_MODE_LINEAR, nullptr);
  auto *timed = GST_TIMED_VALUE_CONTROL_SOURCE(source);
  gst_timed_value_control_source_set(timed, 0, 0.2);
  gst_timed_value_control_source_set(timed, 10 * kFrame, 0.7);
  gst_object_add_control_binding(
      GST_OBJECT(tracker.get()),
      gst_direct_control_binding_new_absolute(GST_OBJECT(tracker.get()), "pointer-x", source));
  gst_object_unref(source);
  for (int i = 0; i <= 10; ++i)
    EXPECT_NEAR(motion_of(pass_moving(i)).pointer_x, (0.2 + 0.05 * i) * kWidth, 1e-3);
}

TEST_F(RoiTracker, TheApplicationHearsOfAMovedPointerOncePerFrame) {
  point_with("haptic");
  int calls = 0;
  g_signal_connect(tracker.get(), "notify::pointer-x",
                   G_CALLBACK(+[](GObject *object, GParamSpec *, int *count) {
                     ++*count;
                     // Would hang if a lock were held.
                     get_double(GST_ELEMENT(object), "pointer-x");
                   }),
                   &calls);
  pass_moving(0);
  EXPECT_EQ(calls, 0);
  for (int i = 0; i < 5; ++i)
    point_haptic(0.1 * i, 0.5);
  EXPECT_EQ(calls, 0);
  pass_moving(1);
  EXPECT_EQ(calls, 1);
  pass_moving(2);
  EXPECT_EQ(calls, 1);
}

// Statistics, life cycle

TEST_F(RoiTracker, AtTheEndItPostsItsStatistics) {
  for (int i = 0; i < 4; ++i)
    pass_moving(i);
  gst_harness_push_event(harness.get(), gst_event_new_eos());
  const test::MessagePtr message = harness.message(GST_MESSAGE_ELEMENT);
  ASSERT_NE(message, nullptr);
  GstStructure *stats = nullptr;
  g_object_get(tracker.get(), "stats", &stats, nullptr);
  EXPECT_TRUE(gst_structure_is_equal(stats, gst_message_get_structure(message.get())));
  EXPECT_TRUE(gst_structure_has_name(stats, "roitracker-stats"));
  gst_structure_free(stats);
  EXPECT_EQ(statistic(tracker.get(), "frames"), 4U);
  EXPECT_EQ(statistic(tracker.get(), "measured"), 3U);
  EXPECT_EQ(statistic(tracker.get(), "discontinuities"), 1U);
  EXPECT_EQ(statistic(tracker.get(), "still"), 0U);
  gdouble points = 0;
  gdouble time = 0;
  gst_structure_get(gst_message_get_structure(message.get()), "points", G_TYPE_DOUBLE, &points,
                    "time-mean-us", G_TYPE_DOUBLE, &time, nullptr);
  EXPECT_EQ(points, 1) << "one translation explains it";
  EXPECT_GT(time, 0);
}

TEST_F(RoiTracker, TheEndMayComeBeforeTheFirstFrame) {
  EXPECT_TRUE(gst_harness_push_event(harness.get(), gst_event_new_eos()));
  EXPECT_NE(harness.message(GST_MESSAGE_ELEMENT), nullptr);
  EXPECT_EQ(harness.message(GST_MESSAGE_ERROR), nullptr);
}

TEST_F(RoiTracker, ALateDisplayDoesNotMakeItSkipFrames) {
  pass_moving(0);
  for (int i = 1; i < 10; ++i) {
    gst_harness_push_upstream_event(harness.get(),
                                    gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 0.1, 5 * GST_SECOND,
                                                      static_cast<GstClockTime>(i) * kFrame));
    expect_motion(pass_moving(i), {2, -1});
  }
}

TEST_F(RoiTracker, ALateDisplayDoesNotMakeTheDecoderSkipFrames) {
  pass_moving(0);
  gst_harness_push_upstream_event(
      harness.get(), gst_event_new_qos(GST_QOS_TYPE_UNDERFLOW, 0.1, 5 * GST_SECOND, 0));
  EXPECT_EQ(harness.upstream_event(GST_EVENT_QOS), nullptr);
}

TEST_F(RoiTracker, EveryPropertyMayBeSetWhileRunning) {
  const ElementPtr pipeline(gst_parse_launch(
      "videotestsrc num-buffers=200 horizontal-speed=2 ! video/x-raw,width=320,height=240 "
      "! roitracker name=tracker ! fakesink",
      nullptr));
  const ElementPtr running(gst_bin_get_by_name(GST_BIN(pipeline.get()), "tracker"));
  EXPECT_EQ(
      test::run_to_end(pipeline.get(), [&] { test::flip_every_property(running.get(), 200); }),
      std::nullopt);
  EXPECT_EQ(statistic(running.get(), "frames"), 200U);
}

TEST_F(RoiTracker, StartsAndStopsTwoHundredTimes) {
  const ElementPtr pipeline(gst_parse_launch(
      "videotestsrc horizontal-speed=2 ! video/x-raw,width=64,height=48 ! roitracker ! fakesink",
      nullptr));
  test::start_and_stop(pipeline.get(), 200);
}

// The force

TEST_F(RoiTracker, TheForceThatTheDeviceReportsIsInTheMetadata) {
  const BufferPtr before = pass_moving(0);
  EXPECT_TRUE(std::isnan(motion_of(before).force_x)) << "no device has reported";
  int frame = 0;
  BufferPtr known;
  test::within_a_second([&] {
    haptic::PointerPosition position;
    position.force = {0.25, -0.5, 0.125};
    gst_harness_push_upstream_event(harness.get(), haptic::make_pointer_event(position).release());
    known = pass_moving(++frame);
  });
  EXPECT_EQ(motion_of(known).force_x, 0.25F);
  EXPECT_EQ(motion_of(known).force_y, -0.5F);
  EXPECT_EQ(motion_of(known).force_z, 0.125F);
  point_haptic(0.5, 0.5);
  const BufferPtr unknown = pass_moving(++frame);
  EXPECT_TRUE(std::isnan(motion_of(unknown).force_x));
  EXPECT_TRUE(std::isnan(motion_of(unknown).force_y));
}

TEST_F(RoiTracker, TheProxyThatTheDeviceReportsIsInTheMetadata) {
  EXPECT_TRUE(std::isnan(motion_of(pass_moving(0)).depth)) << "no device has reported";
  int frame = 0;
  BufferPtr known;
  test::within_a_second([&] {
    haptic::PointerPosition position;
    position.proxy = {0.25, 0.75, 0.5};
    gst_harness_push_upstream_event(harness.get(), haptic::make_pointer_event(position).release());
    known = pass_moving(++frame);
  });
  const auto &motion = motion_of(known);
  EXPECT_EQ(motion.proxy_x, 0.25F * static_cast<gfloat>(motion.frame_width));
  EXPECT_EQ(motion.proxy_y, 0.75F * static_cast<gfloat>(motion.frame_height));
  EXPECT_EQ(motion.depth, 0.5F);
  point_haptic(0.5, 0.5);
  EXPECT_TRUE(std::isnan(motion_of(pass_moving(++frame)).depth));
}

} // namespace roitracker_test
