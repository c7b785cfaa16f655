// SPDX-License-Identifier: LGPL-2.1-or-later
#include "frames/luma-crop.hpp"
#include "glue/pointer-event.hpp"
#include "samples/relief-field.hpp"
#include "video-harness.hpp"

#include <cmath>
#include <gst/video/gstvideometa.h>
#include <gst/video/video-overlay-composition.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <utility>

namespace hapticoverlay_test {

using haptic::BufferPtr;
using test::ElementPtr;
using test::Frame;
using test::Shift;
using test::Texture;
using test::VideoHarness;

constexpr GstClockTime kFrame = GST_SECOND / 30;
constexpr int kWidth = 320;
constexpr int kHeight = 240;

std::vector<std::uint8_t> bytes_of(const BufferPtr &buffer) {
  GstMapInfo map;
  gst_buffer_map(buffer.get(), &map, GST_MAP_READ);
  std::vector<std::uint8_t> bytes(map.data, map.data + map.size);
  gst_buffer_unmap(buffer.get(), &map);
  return bytes;
}

struct Color {
  int r, g, b;
};
bool is_orange(Color c) {
  return c.r > c.g + 40 && c.g > c.b + 40;
}
bool is_blue(Color c) {
  return c.b > c.g + 30 && c.g > c.r + 30;
}
bool is_green(Color c) {
  return c.g > c.r + 60 && c.g > c.b + 20;
}
bool is_dark(Color c) {
  return c.r < 60 && c.g < 60 && c.b < 60;
}
bool is_white(Color c) {
  return c.r > 250 && c.g > 250 && c.b > 250;
}

// Where the pixels of a colour lie, px from the middle of the frame.
struct Spot {
  int count = 0;
  Shift centre;
  double reach = 0; // of the farthest
  double direction() const { return std::atan2(centre.y, centre.x); }
};

template <typename Wanted>
Spot spot(const BufferPtr &rgb, Wanted &&wanted, int width = kWidth, int height = kHeight) {
  const auto bytes = bytes_of(rgb);
  const auto stride = static_cast<std::size_t>((3 * width + 3) / 4 * 4);
  Spot spot;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint8_t *p =
          &bytes[static_cast<std::size_t>(y) * stride + 3 * static_cast<std::size_t>(x)];
      if (!wanted(Color{p[0], p[1], p[2]}))
        continue;
      ++spot.count;
      const Shift place{x + 0.5 - width / 2.0, y + 0.5 - height / 2.0};
      spot.centre.x += place.x;
      spot.centre.y += place.y;
      spot.reach = std::max(spot.reach, std::hypot(place.x, place.y));
    }
  if (spot.count > 0)
    spot.centre = {spot.centre.x / spot.count, spot.centre.y / spot.count};
  return spot;
}

double angle_between(double a, double b) {
  return std::abs(std::remainder(a - b, 2 * std::numbers::pi));
}

class HapticOverlay : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  void SetUp() override {
    harness.set_format(GST_VIDEO_FORMAT_RGB, kWidth, kHeight);
    gst_util_set_object_arg(G_OBJECT(overlay.get()), "style", "arrows");
  }

  // Of a scene that moves uniformly, px per frame.
  BufferPtr pass(int i, Shift step) {
    const Frame frame = texture.frame(kWidth, kHeight, {step.x * i, step.y * i});
    return harness.pass(frame, static_cast<GstClockTime>(i) * kFrame);
  }

  void push_force(double x, double y) {
    haptic::PointerPosition position;
    position.force = {x, y, 0.0};
    gst_harness_push_upstream_event(harness.get(), haptic::make_pointer_event(position).release());
  }

  // The second frame or a later one, with a force that the device reported just before.
  BufferPtr pass_with_force(Shift step, double x, double y) {
    pass(0, step);
    int i = 0;
    BufferPtr out;
    test::within_a_second([&] {
      push_force(x, y);
      out = pass(++i, step);
    });
    return out;
  }

  // A later frame of a still scene while the device reports this proxy.
  BufferPtr pass_touching(std::optional<haptic::ProxyPosition> proxy) {
    BufferPtr out;
    test::within_a_second([&] {
      haptic::PointerPosition position;
      position.proxy = proxy;
      gst_harness_push_upstream_event(harness.get(),
                                      haptic::make_pointer_event(position).release());
      out = pass(++frames, {});
    });
    return out;
  }

  std::vector<std::uint8_t> untouched() {
    return bytes_of(test::to_buffer(texture.frame(kWidth, kHeight, {}), harness.info));
  }

  int frames = 0;
  Texture texture{1, 5, 15};
  VideoHarness harness{"roitracker roi-size=40 ! hapticoverlay"};
  ElementPtr overlay = harness.element("hapticoverlay");
};

TEST_F(HapticOverlay, NothingIsDrawnWhereNothingWasMeasured) {
  const Frame wall(kWidth, kHeight, 120);
  const BufferPtr first = pass(0, {}); // nothing to compare it with
  EXPECT_EQ(bytes_of(first),
            bytes_of(test::to_buffer(texture.frame(kWidth, kHeight, {}), harness.info)));
  std::mt19937 random(1);
  for (int i = 1; i < 5; ++i) {
    Frame noise = wall;
    add_noise(noise, 1.5, random);
    BufferPtr buffer = test::to_buffer(noise, harness.info);
    GST_BUFFER_PTS(buffer.get()) = static_cast<GstClockTime>(i) * kFrame;
    const GstMemory *pixels = gst_buffer_peek_memory(buffer.get(), 0);
    harness.push(std::move(buffer));
    const BufferPtr out = harness.pull();
    EXPECT_EQ(gst_buffer_peek_memory(out.get(), 0), pixels) << "not even copied";
    EXPECT_EQ(bytes_of(out), bytes_of(test::to_buffer(noise, harness.info)));
  }
}

TEST_F(HapticOverlay, FramesWithoutMetadataAreLeftAlone) {
  VideoHarness alone("hapticoverlay");
  alone.set_format(GST_VIDEO_FORMAT_RGB, kWidth, kHeight);
  const Frame frame = texture.frame(kWidth, kHeight, {});
  EXPECT_EQ(bytes_of(alone.pass(frame, 0)), bytes_of(test::to_buffer(frame, alone.info)));
}

TEST_F(HapticOverlay, TheArrowPointsWhereTheFrameMoves) {
  int i = 0;
  for (const double degrees : {0.0, 37.0, 90.0, 160.0, 270.0}) {
    const double angle = degrees * std::numbers::pi / 180;
    const Shift step{2 * std::cos(angle), 2 * std::sin(angle)};
    harness.pass(texture.frame(kWidth, kHeight, {step.x * i, step.y * i}),
                 static_cast<GstClockTime>(i) * kFrame, GST_BUFFER_FLAG_DISCONT);
    const BufferPtr out = pass(i + 1, step);
    const Spot arrow = spot(out, is_orange);
    EXPECT_GT(arrow.count, 30) << degrees;
    EXPECT_LT(angle_between(arrow.direction(), angle), 0.15) << degrees;
    EXPECT_NEAR(arrow.reach, 30, 2) << degrees << ": half a second of 60 px/s";
    EXPECT_EQ(spot(out, is_blue).count, 0) << "no force is known";
    i += 2;
  }
}

TEST_F(HapticOverlay, ScaleIsTheSecondsThatAnArrowIsLong) {
  g_object_set(overlay.get(), "scale", 1.0, nullptr);
  pass(0, {1, 0});
  EXPECT_NEAR(spot(pass(1, {1, 0}), is_orange).reach, 30, 2);
  g_object_set(overlay.get(), "scale", 10.0, nullptr);
  EXPECT_NEAR(spot(pass(2, {1, 0}), is_orange).reach, kHeight / 2.0, 2)
      << "no longer than half of the height";
}

// velocityavg stands on another branch.
TEST_F(HapticOverlay, TheArrowIsThatOfAVelocityavgWithTheSameProperties) {
  pass(0, {2, 0});
  gst_util_set_object_arg(G_OBJECT(overlay.get()), "motion-model", "static");
  EXPECT_EQ(spot(pass(1, {2, 0}), is_orange).count, 0);
  gst_util_set_object_arg(G_OBJECT(overlay.get()), "average", "mean");
  EXPECT_NEAR(spot(pass(2, {2, 0}), is_orange).reach, 30, 2);
}

TEST_F(HapticOverlay, AStillVideoHasARegionAndNoArrow) {
  BufferPtr out;
  for (int i = 0; i < 6; ++i)
    out = pass(i, {});
  EXPECT_EQ(spot(out, is_orange).count, 0);
  const Spot region = spot(out, is_white);
  EXPECT_GT(region.count, 4 * 38 - 8);
  EXPECT_NEAR(region.centre.x, 0, 0.5);
  EXPECT_NEAR(region.centre.y, 0, 0.5);
}

TEST_F(HapticOverlay, TheForceArrowPointsWhereTheForceDoes) {
  const BufferPtr out = pass_with_force({2, 0}, 0.0, 0.4); // up
  const Spot force = spot(out, is_blue);
  EXPECT_GT(force.count, 20);
  // A newton is a quarter of the height.
  EXPECT_NEAR(force.centre.y, -0.4 * kHeight / 4 / 2, 4);
  EXPECT_NEAR(force.centre.x, 0, 6);
  EXPECT_GT(spot(out, is_orange).centre.x, 10);
}

TEST_F(HapticOverlay, OnPixelsThatAreNotSquareDirectionsAreThoseOnTheScreen) {
  gst_harness_set_src_caps_str(harness.get(),
                               "video/x-raw,format=RGB,width=320,height=240,framerate=30/1,"
                               "pixel-aspect-ratio=2/1,interlace-mode=progressive");
  const Spot force = spot(pass_with_force({0, 2}, 0.5, 0.5), is_blue);
  EXPECT_GT(force.count, 20);
  // Half as many of the wide pixels to the right as up; the arrow is drawn a little aside.
  EXPECT_NEAR(force.centre.x, 0.5 * kHeight / 4 / 2 / 2, 3);
  EXPECT_NEAR(force.centre.y, -0.5 * kHeight / 4 / 2, 4);
}

TEST_F(HapticOverlay, ColoursAreThoseThatWereSet) {
  g_object_set(overlay.get(), "velocity-color", 0xff00ff00U, "force-color", 0xffff00ffU, nullptr);
  const BufferPtr out = pass_with_force({2, 0}, 0.4, 0.4);
  EXPECT_GT(spot(out, [](Color c) { return c.g > 200 && c.r < 60 && c.b < 60; }).count, 15);
  EXPECT_GT(spot(out, [](Color c) { return c.g < 60 && c.r > 200 && c.b > 200; }).count, 15);
}

TEST_F(HapticOverlay, StyleFullAddsALabelAndThePatches) {
  const Texture other(2, 5, 15);
  const auto two_motions = [&](int i) {
    Frame frame(kWidth, kHeight);
    texture.paint(frame, {2.0 * i, 0}, 0, kWidth / 2);
    other.paint(frame, {-2.0 * i, 0}, kWidth / 2, kWidth);
    return harness.pass(frame, static_cast<GstClockTime>(i) * kFrame);
  };
  two_motions(0);
  const BufferPtr arrows = two_motions(1);
  gst_util_set_object_arg(G_OBJECT(overlay.get()), "style", "full");
  const BufferPtr full = two_motions(2);
  EXPECT_GT(spot(full, is_orange).count, spot(arrows, is_orange).count + 60);
  const auto is_dark = [](Color c) { return c.r < 80 && c.g < 80 && c.b < 80; };
  EXPECT_GT(spot(full, is_dark).count, spot(arrows, is_dark).count + 500);
  EXPECT_GT(spot(full, is_dark).centre.y, 20) << "the label is below the region";
}

TEST_F(HapticOverlay, StyleNoneDrawsNothing) {
  gst_util_set_object_arg(G_OBJECT(overlay.get()), "style", "none");
  pass(0, {2, 0});
  EXPECT_EQ(bytes_of(pass(1, {2, 0})),
            bytes_of(test::to_buffer(texture.frame(kWidth, kHeight, {2, 0}), harness.info)));
}

TEST_F(HapticOverlay, DrawsNeverIntoTheFrameThatIsTracked) {
  pass(0, {2, 0});
  const Frame frame = texture.frame(kWidth, kHeight, {2, 0});
  const BufferPtr before = test::to_buffer(frame, harness.info);
  GST_BUFFER_PTS(before.get()) = kFrame;
  harness.push(BufferPtr(gst_buffer_ref(before.get())));
  EXPECT_NE(bytes_of(harness.pull()), bytes_of(before));
  EXPECT_EQ(bytes_of(before), bytes_of(test::to_buffer(frame, harness.info)));
}

TEST_F(HapticOverlay, TimeFlagsAndMetadataArePassedOn) {
  pass(0, {2, 0});
  const BufferPtr out = pass(1, {2, 0});
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), kFrame);
  ASSERT_NE(gst_buffer_get_haptic_motion_meta(out.get()), nullptr);
  EXPECT_EQ(gst_buffer_get_haptic_motion_meta(out.get())->n_patches, 1U);
}

TEST_F(HapticOverlay, EveryFormatIsDrawnOnAboutTheRegionAlone) {
  gst_util_set_object_arg(G_OBJECT(overlay.get()), "style", "full");
  const haptic::CapsPtr caps(gst_caps_from_string(GST_VIDEO_CAPS_MAKE(HAPTIC_DRAWN_FORMATS)));
  const GValue *formats = gst_structure_get_value(gst_caps_get_structure(caps.get(), 0), "format");
  ASSERT_GE(gst_value_list_get_size(formats), 19U);
  for (guint n = 0; n < gst_value_list_get_size(formats); ++n) {
    const char *name = g_value_get_string(gst_value_list_get_value(formats, n));
    for (const int width : {kWidth, kWidth + 1}) {
      harness.set_format(gst_video_format_from_string(name), width, kHeight - 1);
      harness.pass(texture.frame(width, kHeight - 1, {}), 0, GST_BUFFER_FLAG_DISCONT);
      const Frame frame = texture.frame(width, kHeight - 1, {2, 1});
      const BufferPtr out = harness.pass(frame, kFrame);
      ASSERT_NE(out, nullptr) << name;
      const BufferPtr in = test::to_buffer(frame, harness.info);
      GstVideoFrame drawn;
      GstVideoFrame plain;
      gst_video_frame_map(&drawn, &harness.info, out.get(), GST_MAP_READ);
      gst_video_frame_map(&plain, &harness.info, in.get(), GST_MAP_READ);
      int changed = 0;
      int astray = 0;
      for (guint c = 0; c < GST_VIDEO_FRAME_N_COMPONENTS(&plain); ++c)
        for (int y = 0; y < GST_VIDEO_FRAME_COMP_HEIGHT(&plain, c); ++y)
          for (int x = 0; x < GST_VIDEO_FRAME_COMP_WIDTH(&plain, c); ++x) {
            const auto sample = [&](GstVideoFrame &video) {
              return static_cast<std::uint8_t *>(GST_VIDEO_FRAME_COMP_DATA(
                  &video, c))[y * GST_VIDEO_FRAME_COMP_STRIDE(&video, c) +
                              x * GST_VIDEO_FRAME_COMP_PSTRIDE(&video, c)];
            };
            if (sample(drawn) == sample(plain))
              continue;
            ++changed;
            const double fx = (x + 0.5) / GST_VIDEO_FRAME_COMP_WIDTH(&plain, c);
            const double fy = (y + 0.5) / GST_VIDEO_FRAME_COMP_HEIGHT(&plain, c);
            astray += std::abs(fx - 0.5) > 0.25 || std::abs(fy - 0.5) > 0.25;
          }
      gst_video_frame_unmap(&plain);
      gst_video_frame_unmap(&drawn);
      EXPECT_GT(changed, 200) << name << ' ' << width;
      EXPECT_EQ(astray, 0) << name << ' ' << width;
    }
  }
}

TEST_F(HapticOverlay, FramesMayBeTiny) {
  gst_util_set_object_arg(G_OBJECT(overlay.get()), "style", "full");
  for (const auto format : {GST_VIDEO_FORMAT_I420, GST_VIDEO_FORMAT_YUY2, GST_VIDEO_FORMAT_BGRx})
    for (const auto &[width, height] : {std::pair(16, 16), {17, 13}, {1, 1}, {400, 12}}) {
      harness.set_format(format, width, height);
      for (int i = 0; i < 3; ++i) {
        push_force(-1, 1);
        EXPECT_NE(harness.pass(texture.frame(width, height, {1.0 * i, 0}),
                               static_cast<GstClockTime>(i) * kFrame),
                  nullptr);
      }
    }
}

TEST_F(HapticOverlay, NumbersWithoutSenseDoNoHarm) {
  VideoHarness alone("hapticoverlay");
  alone.set_format(GST_VIDEO_FORMAT_RGB, kWidth, kHeight);
  const Frame frame = texture.frame(kWidth, kHeight, {});
  for (const float number : {std::numeric_limits<float>::quiet_NaN(),
                             std::numeric_limits<float>::infinity(), 1e30F, -1e30F}) {
    BufferPtr buffer = test::to_buffer(frame, alone.info);
    auto *motion = &test::add_motion(buffer);
    motion->flags = GST_HAPTIC_MOTION_STILL;
    motion->hold = GST_HAPTIC_HOLD_ABOUT;
    motion->held_x = motion->held_radius = number;
    motion->region_x = motion->region_width = motion->pointer_x = motion->force_x = number;
    motion->force_y = 1;
    motion->n_patches = 1000;
    motion->patches[0].x = motion->patches[1].dx = number;
    EXPECT_EQ(alone.push(std::move(buffer)), GST_FLOW_OK);
    EXPECT_NE(alone.pull(), nullptr);
  }
}

// Grey frames with metadata of the test's own: a thing was taken.
class HeldThingInPicture : public ::testing::Test {
protected:
  static constexpr float kRadius = 30; // px

  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }
  void SetUp() override { harness.set_format(GST_VIDEO_FORMAT_RGB, kWidth, kHeight); }

  // The thing is this far from the middle of the frame, px.
  BufferPtr pass(GstHapticHold hold, Shift away = {}) {
    BufferPtr frame = test::to_buffer(Frame(kWidth, kHeight, 128), harness.info);
    auto *meta = &test::add_motion(frame);
    meta->frame_width = kWidth;
    meta->frame_height = kHeight;
    meta->hold = hold;
    meta->held_x = static_cast<gfloat>(kWidth / 2.0 + away.x);
    meta->held_y = static_cast<gfloat>(kHeight / 2.0 + away.y);
    meta->held_radius = kRadius;
    meta->held_time = kFrame * static_cast<GstClockTime>(frames_++);
    meta->interval = kFrame;
    meta->n_candidates = meta->n_patches = moves_ > 0 ? 4 : 0;
    for (guint i = 0; i < meta->n_patches; ++i)
      meta->patches[i].dx = moves_;
    EXPECT_EQ(harness.push(std::move(frame)), GST_FLOW_OK);
    return harness.pull();
  }

  // After this path, the last frame shows no more of it than the ring about the thing.
  void expect_no_trail(const BufferPtr &frame, Shift thing) {
    const Spot left = spot(frame, is_green);
    EXPECT_GT(left.centre.x, thing.x - 3);
  }

  VideoHarness harness{"hapticoverlay style=arrows"};
  int frames_ = 0;
  gfloat moves_ = 0; // px per frame; 0: nothing was measured
};

TEST_F(HeldThingInPicture, HasTheArrowOfItsMotion) {
  moves_ = 2;
  for (const GstHapticHold hold : {GST_HAPTIC_HOLD_HELD, GST_HAPTIC_HOLD_ABOUT}) {
    const Spot arrow = spot(pass(hold, {20, -10}), is_orange);
    EXPECT_NEAR(arrow.centre.x, 20 + 15, 8) << "in half a second it moves by 30 px";
    EXPECT_NEAR(arrow.centre.y, -10, 2);
  }
}

TEST_F(HeldThingInPicture, ThatIsSeenHasASolidRing) {
  const Spot ring = spot(pass(GST_HAPTIC_HOLD_HELD), is_green);
  EXPECT_NEAR(ring.centre.x, 0, 0.5);
  EXPECT_NEAR(ring.centre.y, 0, 0.5);
  EXPECT_NEAR(ring.reach, kRadius, 2);
  EXPECT_GT(ring.count, 2 * std::numbers::pi * 0.9 * static_cast<double>(kRadius));
}

TEST_F(HeldThingInPicture, WhosePlaceIsNotExactHasADashedRing) {
  const int solid = spot(pass(GST_HAPTIC_HOLD_HELD), is_green).count;
  for (const GstHapticHold hold : {GST_HAPTIC_HOLD_ABOUT, GST_HAPTIC_HOLD_HIDDEN}) {
    const Spot ring = spot(pass(hold), is_green);
    EXPECT_LT(ring.count, 0.7 * solid);
    EXPECT_NEAR(ring.reach, kRadius, 2);
  }
}

TEST_F(HeldThingInPicture, WhosePlaceIsNotKnownHasNoRing) {
  for (const GstHapticHold hold : {GST_HAPTIC_HOLD_LOST, GST_HAPTIC_HOLD_REFUSED})
    EXPECT_EQ(spot(pass(hold), is_green).count, 0);
}

TEST_F(HeldThingInPicture, HasAWordUnlessItIsSeen) {
  const auto words = [&](GstHapticHold hold) { return spot(pass(hold), is_dark); };
  EXPECT_EQ(words(GST_HAPTIC_HOLD_NONE).count, 0);
  EXPECT_EQ(words(GST_HAPTIC_HOLD_HELD).count, 0);
  for (const GstHapticHold hold : {GST_HAPTIC_HOLD_ABOUT, GST_HAPTIC_HOLD_HIDDEN,
                                   GST_HAPTIC_HOLD_LOST, GST_HAPTIC_HOLD_REFUSED}) {
    EXPECT_GT(words(hold).count, 200) << hold;
    EXPECT_LT(words(hold).centre.y, 0) << "above it";
  }
}

TEST_F(HeldThingInPicture, AWordHasRoomAtTheTopOfTheFrame) {
  const Spot word = spot(pass(GST_HAPTIC_HOLD_ABOUT, {0, -kHeight / 2.0}), is_dark);
  EXPECT_GT(word.count, 200);
  EXPECT_GT(word.centre.y, -kHeight / 2.0 + static_cast<double>(kRadius));
}

TEST_F(HeldThingInPicture, LeavesATrail) {
  for (int i = 0; i < 20; ++i)
    pass(GST_HAPTIC_HOLD_HELD, {-100 + 10.0 * i, 0});
  const Spot drawn = spot(pass(GST_HAPTIC_HOLD_HELD, {100, 0}), is_green);
  EXPECT_NEAR(drawn.reach, 100 + static_cast<double>(kRadius), 3);
  EXPECT_LT(drawn.centre.x, 75) << "the ring is at 100 px, the trail to the left of it";
}

TEST_F(HeldThingInPicture, ItsTrailEndsWhereItIsLetGoAndAtASeek) {
  const auto walk = [&] {
    for (int i = 0; i < 20; ++i)
      pass(GST_HAPTIC_HOLD_HELD, {-100 + 10.0 * i, 0});
  };
  const Shift end{100, 0};
  walk();
  EXPECT_EQ(spot(pass(GST_HAPTIC_HOLD_NONE), is_green).count, 0);
  expect_no_trail(pass(GST_HAPTIC_HOLD_HELD, end), end);
  walk();
  gst_harness_push_event(harness.get(), gst_event_new_flush_start());
  gst_harness_push_event(harness.get(), gst_event_new_flush_stop(TRUE));
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  gst_harness_push_event(harness.get(), gst_event_new_segment(&segment));
  expect_no_trail(pass(GST_HAPTIC_HOLD_HELD, end), end);
  walk();
  gst_harness_push_event(harness.get(), gst_event_new_segment(&segment));
  expect_no_trail(pass(GST_HAPTIC_HOLD_HELD, end), end);
  walk();
  GST_VIDEO_INFO_PAR_N(&harness.info) = 2;
  gst_harness_set_src_caps(harness.get(), gst_video_info_to_caps(&harness.info));
  expect_no_trail(pass(GST_HAPTIC_HOLD_HELD, end), end);
}

TEST_F(HeldThingInPicture, HasTheColourThatWasSet) {
  g_object_set(harness.element("hapticoverlay").get(), "hold-color", 0xff0072b2U, nullptr);
  const BufferPtr frame = pass(GST_HAPTIC_HOLD_HELD);
  EXPECT_EQ(spot(frame, is_green).count, 0);
  EXPECT_GT(spot(frame, is_blue).count, 100);
}

TEST_F(HeldThingInPicture, IsNotDrawnWithStyleNone) {
  gst_util_set_object_arg(G_OBJECT(harness.element("hapticoverlay").get()), "style", "none");
  for (const GstHapticHold hold : {GST_HAPTIC_HOLD_HELD, GST_HAPTIC_HOLD_REFUSED})
    EXPECT_EQ(spot(pass(hold), [](Color c) { return c.r != 128 || c.g != 128; }).count, 0);
}

TEST_F(HapticOverlay, WhereDownstreamDrawsNothingIsCopied) {
  gst_harness_set_sink_caps_str(harness.get(),
                                "video/x-raw(memory:SystemMemory,meta:GstVideoOverlayComposition)");
  gst_harness_add_propose_allocation_meta(harness.get(),
                                          GST_VIDEO_OVERLAY_COMPOSITION_META_API_TYPE, nullptr);
  harness.set_format(GST_VIDEO_FORMAT_RGB, kWidth, kHeight);
  pass(0, {2, 0});
  const Frame frame = texture.frame(kWidth, kHeight, {2, 0});
  const BufferPtr in = test::to_buffer(frame, harness.info);
  GST_BUFFER_PTS(in.get()) = kFrame;
  harness.push(BufferPtr(gst_buffer_ref(in.get())));
  const BufferPtr out = harness.pull();
  EXPECT_EQ(gst_buffer_peek_memory(out.get(), 0), gst_buffer_peek_memory(in.get(), 0));
  const auto *meta = gst_buffer_get_video_overlay_composition_meta(out.get());
  ASSERT_NE(meta, nullptr);
  EXPECT_EQ(gst_video_overlay_composition_n_rectangles(meta->overlay), 1U);
  EXPECT_EQ(gst_buffer_get_video_overlay_composition_meta(in.get()), nullptr);
}

// Touch

using haptic::ProxyPosition;

TEST_F(HapticOverlay, WithoutDeformATouchMovesNoPixel) {
  gst_util_set_object_arg(G_OBJECT(overlay.get()), "style", "none");
  pass(0, {});
  EXPECT_EQ(bytes_of(pass_touching(ProxyPosition{0.5, 0.5, 0.004})), untouched());
}

TEST_F(HapticOverlay, DeformPullsThePictureWhileAndWhereTheHandTouches) {
  g_object_set(overlay.get(), "deform", 2.0, "style", 0, nullptr);
  pass(0, {});
  EXPECT_EQ(bytes_of(pass_touching(ProxyPosition{0.25, 0.75, 0})), untouched()) << "above it";
  const auto touched = bytes_of(pass_touching(ProxyPosition{0.25, 0.75, 0.004}));
  const auto plain = untouched();
  int changed = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const auto at = static_cast<std::size_t>(3 * (y * kWidth + x));
      if (touched[at] == plain[at])
        continue;
      ++changed;
      ASSERT_LT(std::hypot(x + 0.5 - 80, y + 0.5 - 180), 40) << x << ' ' << y;
    }
  EXPECT_GT(changed, 1500);
  EXPECT_EQ(bytes_of(pass_touching(ProxyPosition{0.25, 0.75, 0})), plain) << "it has ended";
  pass_touching(ProxyPosition{0.25, 0.75, 0.004});
  EXPECT_EQ(bytes_of(pass_touching(std::nullopt)), plain) << "touch is off";
}

TEST_F(HapticOverlay, DeformNeverPullsTheFrameThatIsTracked) {
  g_object_set(overlay.get(), "deform", 2.0, "style", 0, nullptr);
  pass(0, {});
  pass_touching(ProxyPosition{0.5, 0.5, 0.004});
  const BufferPtr before = test::to_buffer(texture.frame(kWidth, kHeight, {}), harness.info);
  GST_BUFFER_PTS(before.get()) = static_cast<GstClockTime>(++frames) * kFrame;
  harness.push(BufferPtr(gst_buffer_ref(before.get())));
  EXPECT_NE(bytes_of(harness.pull()), bytes_of(before));
  EXPECT_EQ(bytes_of(before), untouched());
}

TEST_F(HapticOverlay, ARingShowsTheProxyAndADotInItTheContact) {
  const auto at_proxy = [](const BufferPtr &out, auto wanted) {
    Spot found = spot(out, wanted);
    found.centre.x += kWidth / 2.0 - 80;
    found.centre.y += kHeight / 2.0 - 180;
    return found;
  };
  g_object_set(harness.element("roitracker").get(), "pointer-source", 3, nullptr);
  for (int i = 0; i < 3; ++i)
    pass(i, {});
  frames = 3;
  const Spot without = spot(pass_touching(std::nullopt), is_white);
  const BufferPtr free = pass_touching(ProxyPosition{0.25, 0.75, 0});
  EXPECT_EQ(spot(free, is_green).count, 0);
  EXPECT_GT(spot(free, is_white).count, without.count + 10) << "the ring";
  const BufferPtr touching = pass_touching(ProxyPosition{0.25, 0.75, 0.002});
  const Spot dot = at_proxy(touching, is_green);
  EXPECT_GT(dot.count, 8);
  EXPECT_NEAR(dot.centre.x, 0, 0.6);
  EXPECT_NEAR(dot.centre.y, 0, 0.6);
}

// A relief whose right half is this high, m.
void push_relief(GstPad *pad, GstClockTime time, float height) {
  haptic::ReliefField relief;
  relief.frame_width = kWidth;
  relief.frame_height = kHeight;
  relief.columns = 32;
  relief.rows = 24;
  for (int i = 0; i < 32 * 24; ++i)
    relief.cells.push_back({i % 32 < 16 ? 0 : height, 100, 0, 1});
  std::vector<std::uint8_t> bytes(haptic::packed_size(relief));
  haptic::pack_relief_field(relief, bytes);
  GstBuffer *buffer = gst_buffer_new_memdup(bytes.data(), bytes.size());
  GST_BUFFER_PTS(buffer) = time;
  EXPECT_EQ(gst_pad_chain(pad, buffer), GST_FLOW_OK);
}

class ShownReliefs : public HapticOverlay {
protected:
  void SetUp() override {
    HapticOverlay::SetUp();
    gst_util_set_object_arg(G_OBJECT(overlay.get()), "style", "none");
    pad = gst_element_request_pad_simple(overlay.get(), "relief");
    gst_pad_send_event(pad, gst_event_new_stream_start("reliefs"));
    gst_pad_send_event(
        pad, gst_event_new_caps(haptic::CapsPtr(gst_caps_from_string(HAPTIC_RELIEF_CAPS)).get()));
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_pad_send_event(pad, gst_event_new_segment(&segment));
  }
  void TearDown() override {
    if (pad)
      gst_element_release_request_pad(overlay.get(), pad);
    g_clear_pointer(&pad, gst_object_unref);
  }
  GstPad *pad = nullptr;
};

TEST_F(ShownReliefs, AStepIsShadedAndALevelReliefIsNot) {
  EXPECT_EQ(bytes_of(pass(0, {})), untouched()) << "no relief has come";
  push_relief(pad, kFrame, 0);
  EXPECT_EQ(bytes_of(pass(1, {})), untouched());
  push_relief(pad, 2 * kFrame, 0.005F);
  const auto shaded = bytes_of(pass(2, {}));
  const auto plain = untouched();
  for (const int x : {50, 140, 160, 180, 300}) {
    const auto at = static_cast<std::size_t>(3 * (100 * kWidth + x));
    if (x == 160) {
      EXPECT_GT(shaded[at], plain[at] * 1.05);
    } else {
      EXPECT_EQ(shaded[at], plain[at]) << x;
    }
  }
  g_object_set(overlay.get(), "shading", 0.0, nullptr);
  EXPECT_EQ(bytes_of(pass(3, {})), plain);
}

TEST_F(ShownReliefs, AFrameHasTheReliefOfItsTime) {
  push_relief(pad, 0, 0);
  push_relief(pad, kFrame, 0.005F);
  push_relief(pad, 2 * kFrame, 0);
  EXPECT_EQ(bytes_of(pass(0, {})), untouched());
  EXPECT_NE(bytes_of(pass(1, {})), untouched());
  EXPECT_EQ(bytes_of(pass(2, {})), untouched());
}

TEST_F(ShownReliefs, OldOrDamagedReliefsAndThoseBeforeASeekAreNotShown) {
  push_relief(pad, 0, 0.005F);
  EXPECT_NE(bytes_of(pass(30, {})), untouched());
  EXPECT_EQ(bytes_of(pass(31, {})), untouched()) << "older than a second";
  EXPECT_EQ(gst_pad_chain(pad, gst_buffer_new_allocate(nullptr, 100, nullptr)), GST_FLOW_OK);
  EXPECT_EQ(bytes_of(pass(32, {})), untouched());
  push_relief(pad, 33 * kFrame, 0.005F);
  gst_pad_send_event(pad, gst_event_new_flush_start());
  gst_pad_send_event(pad, gst_event_new_flush_stop(TRUE));
  EXPECT_EQ(bytes_of(pass(33, {})), untouched());
}

// As by another thread: while the first pad is made, and not yet the element's.
TEST_F(ShownReliefs, OneOfTwoRequestsAtOnceGetsThePad) {
  gst_element_release_request_pad(overlay.get(), pad);
  g_clear_pointer(&pad, gst_object_unref);
  GstPadTemplate *of = gst_element_get_pad_template(overlay.get(), "relief");
  struct Second {
    GstElement *overlay;
    GstPad *pad = nullptr;
    bool asked = false;
  } second{overlay.get()};
  const auto ask = +[](GstPadTemplate *from, GstPad *, Second *self) {
    if (!std::exchange(self->asked, true))
      self->pad = gst_element_request_pad(self->overlay, from, nullptr, nullptr);
  };
  const gulong handler = g_signal_connect(of, "pad-created", G_CALLBACK(ask), &second);
  pad = gst_element_request_pad(overlay.get(), of, nullptr, nullptr);
  g_signal_handler_disconnect(of, handler);
  EXPECT_TRUE(second.asked);
  EXPECT_NE(pad, nullptr);
  EXPECT_EQ(second.pad, nullptr);
}

TEST_F(HapticOverlay, ASegmentNeedNotCountInTime) {
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_BYTES);
  EXPECT_NE(pass(0, {}), nullptr);
  EXPECT_TRUE(gst_harness_push_event(harness.get(), gst_event_new_segment(&segment)));
  EXPECT_NE(pass(1, {}), nullptr);
}

TEST_F(HapticOverlay, EveryPropertyMayBeSetWhileRunning) {
  const ElementPtr pipeline(gst_parse_launch(
      "videotestsrc num-buffers=200 horizontal-speed=2 ! video/x-raw,width=320,height=240 "
      "! roitracker ! hapticoverlay name=overlay ! fakesink",
      nullptr));
  const ElementPtr running(gst_bin_get_by_name(GST_BIN(pipeline.get()), "overlay"));
  EXPECT_EQ(
      test::run_to_end(pipeline.get(), [&] { test::flip_every_property(running.get(), 200); }),
      std::nullopt);
}

} // namespace hapticoverlay_test
