// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-sample.hpp"
#include "video-harness.hpp"

#include <cmath>
#include <gst/video/gstvideometa.h>
#include <gtest/gtest.h>
#include <limits>
#include <utility>

namespace velocityavg_test {

using haptic::BufferPtr;
using haptic::HeldPlace;
using haptic::HoldState;
using haptic::MotionModel;
using haptic::MotionSample;
using test::ElementPtr;
using test::Frame;
using test::Shift;
using test::Texture;
using test::VideoHarness;

constexpr GstClockTime kFrame = GST_SECOND / 30;
constexpr int kWidth = 240;
constexpr int kHeight = 180;

MotionSample sample_of(const BufferPtr &buffer) {
  GstMapInfo map;
  gst_buffer_map(buffer.get(), &map, GST_MAP_READ);
  const auto sample = haptic::unpack_motion_sample({map.data, map.size});
  gst_buffer_unmap(buffer.get(), &map);
  EXPECT_TRUE(sample.has_value());
  return sample.value_or(MotionSample{});
}

bool is_gap(const BufferPtr &buffer) {
  return GST_BUFFER_FLAG_IS_SET(buffer.get(), GST_BUFFER_FLAG_GAP);
}

class VelocityAvg : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  void SetUp() override { harness.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight); }

  // The frame that a scene of uniform motion (px/s) shows at a time.
  Frame at(GstClockTime time, Shift velocity) const {
    const double seconds = static_cast<double>(time) / GST_SECOND;
    return texture.frame(kWidth, kHeight, {velocity.x * seconds, velocity.y * seconds});
  }

  BufferPtr pass(GstClockTime time, Shift velocity) {
    return harness.pass(at(time, velocity), time);
  }

  static void expect_velocity(const BufferPtr &buffer, Shift velocity, double fraction) {
    ASSERT_FALSE(is_gap(buffer));
    const MotionSample sample = sample_of(buffer);
    const double tolerance = fraction * std::hypot(velocity.x, velocity.y);
    EXPECT_NEAR(sample.velocity_x, velocity.x, tolerance);
    EXPECT_NEAR(sample.velocity_y, velocity.y, tolerance);
  }

  Texture texture{1};
  VideoHarness harness{"roitracker roi-size=30 ! velocityavg"};
  ElementPtr velocityavg = harness.element("velocityavg");
  ElementPtr tracker = harness.element("roitracker");
};

TEST_F(VelocityAvg, SaysTheVelocityInPixelsPerSecond) {
  for (const double speed : {20.0, 100.0, 400.0})
    for (const Shift direction : {Shift{1, 0}, {0, 1}, {-0.6, 0.8}}) {
      const Shift velocity{speed * direction.x, speed * direction.y};
      harness.pass(at(0, velocity), 0, GST_BUFFER_FLAG_DISCONT);
      for (GstClockTime i = 1; i < 10; ++i) {
        const BufferPtr buffer = pass(i * kFrame, velocity);
        expect_velocity(buffer, velocity, 0.02);
        const MotionSample sample = sample_of(buffer);
        EXPECT_EQ(sample.confidence, 1) << speed;
        EXPECT_EQ(sample.model, MotionModel::translation);
        EXPECT_GE(sample.points, 1);
        EXPECT_EQ(sample.interval, kFrame);
        EXPECT_EQ(sample.flags, 0);
      }
    }
}

TEST_F(VelocityAvg, IrregularTimeStampsDoNotChangeIt) {
  const Shift velocity{60, -45};
  GstClockTime time = 0;
  pass(time, velocity);
  for (const GstClockTime ms : {5U, 100U, 20U, 33U, 7U, 90U, 50U})
    expect_velocity(pass(time += ms * GST_MSECOND, velocity), velocity, 0.02);
}

TEST_F(VelocityAvg, FramesRepeatedInPlaceOfMissedOnesLeaveTheVelocityConstant) {
  const Shift velocity{70, 30};
  // Of five frames three are new, as in 3:2 pulldown.
  constexpr GstClockTime kShown[] = {0, 0, 2, 3, 3};
  for (GstClockTime i = 0; i < 40; ++i) {
    const GstClockTime taken = i / 5 * 5 + kShown[i % 5];
    const BufferPtr buffer = harness.pass(at(taken * kFrame, velocity), i * kFrame);
    if (i < 2)
      continue;
    expect_velocity(buffer, velocity, 0.02);
    EXPECT_EQ((sample_of(buffer).flags & haptic::kMotionDuplicate) != 0, taken != i) << i;
  }
}

TEST_F(VelocityAvg, EveryFrameShownTwiceHasAConstantVelocity) {
  const Shift velocity{70, 30};
  for (GstClockTime i = 0; i < 40; ++i) {
    const BufferPtr buffer = harness.pass(at(i / 2 * 2 * kFrame, velocity), i * kFrame);
    if (i >= 2)
      expect_velocity(buffer, velocity, 0.02);
    if (i >= 3) {
      EXPECT_EQ((sample_of(buffer).flags & haptic::kMotionDuplicate) != 0, i % 2 == 1);
    }
  }
}

TEST_F(VelocityAvg, FramesShownManyTimesNeverMoveFasterThanTheFilm) {
  const Shift velocity{70, 30};
  for (const GstClockTime shown : {4U, 5U, 6U, 8U}) {
    harness.pass(at(0, velocity), 0, GST_BUFFER_FLAG_DISCONT);
    for (GstClockTime i = 1; i < 6 * shown; ++i) {
      const BufferPtr buffer = harness.pass(at(i / shown * shown * kFrame, velocity), i * kFrame);
      if (i >= 2 * shown) // the first of them is not known to be shown again
        expect_velocity(buffer, velocity, 0.02);
    }
  }
}

TEST_F(VelocityAvg, NothingMeasuredIsAGap) {
  const BufferPtr first = pass(0, {60, 0});
  EXPECT_TRUE(is_gap(first));
  const MotionSample sample = sample_of(first);
  EXPECT_EQ(sample.confidence, 0);
  EXPECT_EQ(sample.flags, haptic::kMotionDiscontinuity);
  EXPECT_EQ(sample.model, MotionModel::none);
  expect_velocity(pass(kFrame, {60, 0}), {60, 0}, 0.02);

  std::mt19937 random(1);
  for (GstClockTime i = 2; i < 5; ++i) {
    Frame wall(kWidth, kHeight, 120);
    add_noise(wall, 1.5, random);
    const BufferPtr blank = harness.pass(wall, i * kFrame);
    EXPECT_TRUE(is_gap(blank));
    EXPECT_EQ(sample_of(blank).velocity_x, 0);
  }
}

TEST_F(VelocityAvg, ADuplicateOfNothingIsAGap) {
  pass(0, {60, 0});
  std::mt19937 random(1);
  Frame wall(kWidth, kHeight, 120);
  add_noise(wall, 1.5, random);
  harness.pass(wall, kFrame);
  const BufferPtr again = harness.pass(wall, 2 * kFrame);
  EXPECT_TRUE(is_gap(again));
  EXPECT_EQ(sample_of(again).flags, haptic::kMotionDuplicate);
}

TEST_F(VelocityAvg, StandstillIsExactlyZeroWithFullConfidence) {
  const Frame still = at(0, {});
  harness.pass(still, 0);
  for (GstClockTime i = 1; i < 3; ++i)
    EXPECT_TRUE(is_gap(harness.pass(still, i * kFrame))) << "as yet it might move";
  for (GstClockTime i = 3; i < 100; ++i) {
    g_object_set(tracker.get(), "pointer-x", 0.2 + 0.006 * static_cast<double>(i), nullptr);
    const BufferPtr buffer = harness.pass(still, i * kFrame);
    EXPECT_FALSE(is_gap(buffer));
    const MotionSample sample = sample_of(buffer);
    EXPECT_EQ(sample.velocity_x, 0);
    EXPECT_EQ(sample.velocity_y, 0);
    EXPECT_EQ(sample.spin, 0);
    EXPECT_EQ(sample.divergence, 0);
    EXPECT_EQ(sample.confidence, 1);
    EXPECT_EQ(sample.model, MotionModel::still);
    EXPECT_EQ(sample.flags, haptic::kMotionStill);
  }
}

TEST_F(VelocityAvg, TheSampleSaysWhereItWasMeasured) {
  g_object_set(tracker.get(), "pointer-x", 0.25, "pointer-y", 0.75, nullptr);
  const MotionSample sample = sample_of(pass(0, {}));
  EXPECT_EQ(sample.pointer_x, 0.25F);
  EXPECT_EQ(sample.pointer_y, 0.75F);
  EXPECT_FLOAT_EQ(sample.region_width, 30.0F / kWidth);
  EXPECT_FLOAT_EQ(sample.region_height, 30.0F / kHeight);
  EXPECT_EQ(sample.frame_width, static_cast<std::uint32_t>(kWidth));
  EXPECT_EQ(sample.frame_height, static_cast<std::uint32_t>(kHeight));
}

TEST_F(VelocityAvg, FollowsTheObjectUnderThePointer) {
  const Texture other(2);
  const auto scene = [&](GstClockTime i) {
    Frame frame(kWidth, kHeight);
    const double moved = 90.0 / 30 * static_cast<double>(i);
    texture.paint(frame, {-moved, 0}, 0, kWidth / 2);
    other.paint(frame, {moved, 0}, kWidth / 2, kWidth);
    return frame;
  };
  harness.pass(scene(0), 0);
  for (GstClockTime i = 1; i < 12; ++i) {
    const bool right = i / 4 % 2 == 1;
    g_object_set(tracker.get(), "pointer-x", right ? 0.7 : 0.3, nullptr);
    expect_velocity(harness.pass(scene(i), i * kFrame), {right ? 90.0 : -90.0, 0}, 0.02);
  }
}

TEST_F(VelocityAvg, EachAverageAndEachModelGivesTheVelocityOfUniformMotion) {
  const Shift velocity{80, -60};
  GstClockTime i = 0;
  pass(i++, velocity);
  for (const char *average : {"pointed", "model", "mean", "median"})
    for (const char *model : {"auto", "translation", "similarity", "affine"}) {
      gst_util_set_object_arg(G_OBJECT(velocityavg.get()), "average", average);
      gst_util_set_object_arg(G_OBJECT(velocityavg.get()), "motion-model", model);
      expect_velocity(pass(i++ * kFrame, velocity), velocity, 0.02);
    }
  gst_util_set_object_arg(G_OBJECT(velocityavg.get()), "average", "model");
  gst_util_set_object_arg(G_OBJECT(velocityavg.get()), "motion-model", "static");
  const MotionSample sample = sample_of(pass(i++ * kFrame, velocity));
  EXPECT_EQ(sample.velocity_x, 0);
  EXPECT_EQ(sample.model, MotionModel::still);
}

TEST_F(VelocityAvg, TimeStampDurationAndDiscontinuityAreTheFrames) {
  BufferPtr frame = test::to_buffer(at(0, {}), harness.info);
  GST_BUFFER_PTS(frame.get()) = 7 * GST_SECOND;
  GST_BUFFER_DURATION(frame.get()) = 12345;
  GST_BUFFER_FLAG_SET(frame.get(), GST_BUFFER_FLAG_DISCONT);
  harness.push(std::move(frame));
  const BufferPtr sample = harness.pull();
  EXPECT_EQ(GST_BUFFER_PTS(sample.get()), 7 * GST_SECOND);
  EXPECT_EQ(GST_BUFFER_DURATION(sample.get()), 12345U);
  EXPECT_TRUE(GST_BUFFER_IS_DISCONT(sample.get()));
  EXPECT_EQ(gst_buffer_get_size(sample.get()), haptic::kMotionSampleSize);
  EXPECT_FALSE(GST_BUFFER_IS_DISCONT(pass(8 * GST_SECOND, {}).get()));
}

TEST_F(VelocityAvg, TheCapsDescribeTheFrame) {
  gst_harness_set_src_caps_str(harness.get(),
                               "video/x-raw,format=I420,width=352,height=288,framerate=25/1,"
                               "pixel-aspect-ratio=12/11,interlace-mode=progressive");
  harness.info = test::video_info(GST_VIDEO_FORMAT_I420, 352, 288);
  const BufferPtr buffer = harness.pass(texture.frame(352, 288, {}), 0);
  const haptic::CapsPtr caps(gst_pad_get_current_caps(harness.get()->sinkpad));
  const haptic::CapsPtr expected(gst_caps_from_string(
      HAPTIC_MOTION_CAPS ",width=352,height=288,framerate=25/1,pixel-aspect-ratio=12/11"));
  EXPECT_TRUE(gst_caps_is_equal(caps.get(), expected.get()));
  EXPECT_EQ(sample_of(buffer).pixel_aspect_n, 12U);
  EXPECT_EQ(sample_of(buffer).pixel_aspect_d, 11U);
}

TEST_F(VelocityAvg, FramesMayChangeInMidStream) {
  pass(0, {30, 0});
  pass(kFrame, {30, 0});
  harness.set_format(GST_VIDEO_FORMAT_RGB, 321, 243);
  const BufferPtr first = harness.pass(texture.frame(321, 243, {}), 2 * kFrame);
  EXPECT_TRUE(is_gap(first));
  EXPECT_EQ(sample_of(first).frame_width, 321U);
  expect_velocity(harness.pass(texture.frame(321, 243, {1, 0}), 3 * kFrame), {30, 0}, 0.02);
}

TEST_F(VelocityAvg, NeverLooksAtThePixels) {
  VideoHarness alone("velocityavg");
  alone.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  BufferPtr empty(gst_buffer_new());
  auto *motion = &test::add_motion(empty);
  motion->interval = kFrame;
  motion->frame_width = kWidth;
  motion->frame_height = kHeight;
  motion->n_candidates = motion->n_patches = 4;
  for (guint i = 0; i < 4; ++i)
    motion->patches[i].dx = 2;
  EXPECT_EQ(alone.push(std::move(empty)), GST_FLOW_OK);
  expect_velocity(alone.pull(), {60, 0}, 1e-4);

  const haptic::CapsPtr caps(gst_video_info_to_caps(&alone.info));
  const haptic::QueryPtr query(gst_query_new_allocation(caps.get(), FALSE));
  EXPECT_TRUE(gst_pad_peer_query(alone.get()->srcpad, query.get()));
  EXPECT_TRUE(gst_query_find_allocation_meta(query.get(), GST_VIDEO_META_API_TYPE, nullptr));
}

// Frames whose metadata the test writes: a thing was taken.
class HeldThing : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  static GstHapticMotionMeta moving(guint hold) {
    GstHapticMotionMeta motion{};
    motion.interval = kFrame;
    motion.frame_width = kWidth;
    motion.frame_height = kHeight;
    motion.n_candidates = motion.n_patches = 4;
    for (guint i = 0; i < 4; ++i)
      motion.patches[i].dx = 2;
    motion.hold = hold;
    motion.held_x = 60;
    motion.held_y = 135;
    motion.held_radius = 24;
    motion.held_time = GST_SECOND;
    return motion;
  }

  static constexpr HeldPlace place(HoldState state) {
    return {state, 60.0F / kWidth, 135.0F / kHeight, 24.0F / kWidth, GST_SECOND};
  }

  static BufferPtr push(VideoHarness &harness, const GstHapticMotionMeta &motion) {
    BufferPtr frame = test::to_buffer(Frame(kWidth, kHeight), harness.info);
    GstHapticMotionMeta &meta = test::add_motion(frame);
    const GstMeta header = meta.meta;
    meta = motion;
    meta.meta = header;
    EXPECT_EQ(harness.push(std::move(frame)), GST_FLOW_OK);
    return harness.pull();
  }
  BufferPtr pass(const GstHapticMotionMeta &motion) { return push(harness, motion); }

  void SetUp() override { harness.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight); }

  VideoHarness harness{"velocityavg"};
};

TEST_F(HeldThing, IsInTheSampleWithItsMotionWhileItIsSeen) {
  for (const HoldState state : {HoldState::held, HoldState::about}) {
    const BufferPtr buffer = pass(moving(static_cast<guint>(state)));
    EXPECT_EQ(sample_of(buffer).held, place(state));
    EXPECT_NEAR(sample_of(buffer).velocity_x, 60, 0.01);
    EXPECT_FALSE(is_gap(buffer));
  }
}

TEST_F(HeldThing, IsNotFeltWhileItIsNotSeen) {
  for (const HoldState state : {HoldState::hidden, HoldState::lost, HoldState::refused})
    for (const guint flags : {0U, static_cast<guint>(GST_HAPTIC_MOTION_STILL),
                              static_cast<guint>(GST_HAPTIC_MOTION_DUPLICATE)}) {
      pass(moving(GST_HAPTIC_HOLD_HELD));
      GstHapticMotionMeta motion = moving(static_cast<guint>(state));
      motion.flags = flags;
      const BufferPtr buffer = pass(motion);
      EXPECT_EQ(sample_of(buffer).held, place(state));
      EXPECT_EQ(sample_of(buffer).confidence, 0);
      EXPECT_TRUE(is_gap(buffer));
    }
}

TEST_F(HeldThing, WithoutOneTheSampleIsAsBefore) {
  const BufferPtr none = pass(moving(GST_HAPTIC_HOLD_NONE));
  EXPECT_EQ(gst_buffer_get_size(none.get()), haptic::kMotionSampleSize);
  EXPECT_EQ(sample_of(none).held, HeldPlace{});
  EXPECT_EQ(sample_of(pass(moving(GST_HAPTIC_HOLD_REFUSED + 1))).held, HeldPlace{})
      << "a state of a later version";
}

TEST_F(HeldThing, ADuplicateFrameRepeatsTheMotionAndSaysWhereTheThingIsNow) {
  pass(moving(GST_HAPTIC_HOLD_HELD));
  GstHapticMotionMeta again = moving(GST_HAPTIC_HOLD_ABOUT);
  again.flags = GST_HAPTIC_MOTION_DUPLICATE;
  again.n_patches = 0;
  const MotionSample sample = sample_of(pass(again));
  EXPECT_NEAR(sample.velocity_x, 60, 0.01);
  EXPECT_EQ(sample.held, place(HoldState::about));
}

TEST_F(HeldThing, IsScaledWithTheFrame) {
  VideoHarness scaled("videoscale ! capsfilter caps=video/x-raw,width=120,height=45 ! velocityavg");
  scaled.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  EXPECT_EQ(sample_of(push(scaled, moving(GST_HAPTIC_HOLD_HELD))).held, place(HoldState::held));
}

TEST_F(HeldThing, IsInsideTheFrameWhateverTheMetadataSay) {
  GstHapticMotionMeta motion = moving(GST_HAPTIC_HOLD_HELD);
  motion.held_x = -5;
  motion.held_y = 1e9F;
  motion.held_radius = std::numeric_limits<gfloat>::quiet_NaN();
  const HeldPlace held = sample_of(pass(motion)).held;
  EXPECT_EQ(held.x, 0);
  EXPECT_EQ(held.y, 1);
  EXPECT_EQ(held.radius, 0);
}

TEST_F(HeldThing, IsInTheMessage) {
  gst_util_set_object_arg(G_OBJECT(harness.element("velocityavg").get()), "post-messages", "true");
  pass(moving(GST_HAPTIC_HOLD_ABOUT));
  const test::MessagePtr message = harness.message(GST_MESSAGE_ELEMENT);
  ASSERT_NE(message, nullptr);
  const GstStructure *fields = gst_message_get_structure(message.get());
  gdouble x = 0;
  gdouble y = 0;
  gdouble radius = 0;
  guint64 time = 0;
  ASSERT_TRUE(gst_structure_get(fields, "hold-x", G_TYPE_DOUBLE, &x, "hold-y", G_TYPE_DOUBLE, &y,
                                "hold-radius", G_TYPE_DOUBLE, &radius, "hold-time", G_TYPE_UINT64,
                                &time, nullptr));
  EXPECT_STREQ(gst_structure_get_string(fields, "held"), "about");
  EXPECT_EQ(x, 0.25);
  EXPECT_EQ(y, 0.75);
  EXPECT_FLOAT_EQ(static_cast<float>(radius), 0.1F);
  EXPECT_EQ(time, GST_SECOND);
}

TEST_F(VelocityAvg, WithoutATrackerItWarnsOnceAndTheBranchIsStillFed) {
  VideoHarness alone("velocityavg");
  alone.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight);
  for (GstClockTime i = 0; i < 5; ++i) {
    const BufferPtr buffer = alone.pass(at(0, {}), i * kFrame);
    ASSERT_NE(buffer, nullptr);
    EXPECT_TRUE(is_gap(buffer));
    EXPECT_EQ(sample_of(buffer).confidence, 0);
    EXPECT_EQ(GST_BUFFER_PTS(buffer.get()), i * kFrame);
  }
  const test::MessagePtr message = alone.message(GST_MESSAGE_WARNING);
  ASSERT_NE(message, nullptr);
  GError *warning = nullptr;
  gst_message_parse_warning(message.get(), &warning, nullptr);
  EXPECT_NE(std::string(warning->message).find("roitracker directly before"), std::string::npos);
  g_error_free(warning);
  EXPECT_EQ(alone.message(GST_MESSAGE_WARNING), nullptr);
}

TEST_F(VelocityAvg, PostsEachSampleOnlyWhenAsked) {
  pass(0, {60, -30});
  pass(kFrame, {60, -30});
  EXPECT_EQ(harness.message(GST_MESSAGE_ELEMENT), nullptr);
  g_object_set(velocityavg.get(), "post-messages", TRUE, nullptr);
  const MotionSample sample = sample_of(pass(2 * kFrame, {60, -30}));
  const test::MessagePtr message = harness.message(GST_MESSAGE_ELEMENT);
  ASSERT_NE(message, nullptr);
  const GstStructure *fields = gst_message_get_structure(message.get());
  EXPECT_TRUE(gst_structure_has_name(fields, "haptic-motion"));
  guint64 pts = 0;
  guint64 interval = 0;
  gdouble vx = 0;
  gdouble vy = 0;
  gdouble spin = -1;
  gdouble divergence = -1;
  gdouble confidence = 0;
  guint points = 0;
  ASSERT_TRUE(gst_structure_get(fields, "pts", G_TYPE_UINT64, &pts, "interval", G_TYPE_UINT64,
                                &interval, "vx", G_TYPE_DOUBLE, &vx, "vy", G_TYPE_DOUBLE, &vy,
                                "spin", G_TYPE_DOUBLE, &spin, "divergence", G_TYPE_DOUBLE,
                                &divergence, "confidence", G_TYPE_DOUBLE, &confidence, "points",
                                G_TYPE_UINT, &points, nullptr));
  EXPECT_EQ(gst_structure_n_fields(fields), 9);
  EXPECT_EQ(pts, 2 * kFrame);
  EXPECT_EQ(interval, kFrame);
  EXPECT_EQ(vx, sample.velocity_x);
  EXPECT_EQ(vy, sample.velocity_y);
  EXPECT_EQ(spin, 0);
  EXPECT_EQ(divergence, 0);
  EXPECT_EQ(confidence, sample.confidence);
  EXPECT_EQ(points, sample.points);
  EXPECT_STREQ(gst_structure_get_string(fields, "model"), "translation");
  EXPECT_EQ(harness.message(GST_MESSAGE_ELEMENT), nullptr);
}

TEST_F(VelocityAvg, TheEndMayComeBeforeTheFirstFrame) {
  EXPECT_TRUE(gst_harness_push_event(harness.get(), gst_event_new_eos()));
  EXPECT_EQ(harness.message(GST_MESSAGE_ERROR), nullptr);
}

TEST_F(VelocityAvg, FramesThatItCannotReadAreRefused) {
  const ElementPtr pipeline(
      gst_parse_launch("videotestsrc num-buffers=1 ! video/x-raw,format=v216 ! "
                       "velocityavg ! fakesink",
                       nullptr));
  EXPECT_NE(test::run_to_end(pipeline.get()), std::nullopt);
}

TEST_F(VelocityAvg, EveryPropertyMayBeSetWhileRunning) {
  const ElementPtr pipeline(gst_parse_launch(
      "videotestsrc num-buffers=200 horizontal-speed=2 ! video/x-raw,width=320,height=240 "
      "! roitracker ! velocityavg name=velocity ! fakesink",
      nullptr));
  const ElementPtr running(gst_bin_get_by_name(GST_BIN(pipeline.get()), "velocity"));
  EXPECT_EQ(
      test::run_to_end(pipeline.get(), [&] { test::flip_every_property(running.get(), 200); }),
      std::nullopt);
}

TEST_F(VelocityAvg, StartsAndStopsTwoHundredTimes) {
  const ElementPtr pipeline(
      gst_parse_launch("videotestsrc horizontal-speed=2 ! video/x-raw,width=64,height=48 "
                       "! roitracker ! velocityavg ! fakesink",
                       nullptr));
  test::start_and_stop(pipeline.get(), 200);
}

} // namespace velocityavg_test
