// SPDX-License-Identifier: LGPL-2.1-or-later
// What a press does to roitracker. How well a thing is followed is tested in unit-vision-hold.
#include "glue/pointer-event.hpp"
#include "video-harness.hpp"

#include <algorithm>
#include <cmath>
#include <gst/video/navigation.h>
#include <gtest/gtest.h>
#include <random>

namespace roitracker_hold_test {

using haptic::BufferPtr;
using test::ElementPtr;
using test::Frame;
using test::motion_of;
using test::Texture;
using test::VideoHarness;

constexpr GstClockTime kFrame = 40 * GST_MSECOND;
constexpr int kWidth = 176;
constexpr int kHeight = 144;

class Hold : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  void SetUp() override { harness.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight); }

  // Frame number i of a texture that moves 2 px to the right and 1 up in each.
  BufferPtr pass(int i) { return pass(texture.frame(kWidth, kHeight, {2.0 * i, -1.0 * i}), i); }
  BufferPtr pass(const Frame &frame, int i) {
    return harness.pass(frame, static_cast<GstClockTime>(i) * kFrame);
  }

  void press(bool pressed) { g_object_set(tracker.get(), "pressed", pressed, nullptr); }
  bool is_pressed() {
    gboolean pressed = FALSE;
    g_object_get(tracker.get(), "pressed", &pressed, nullptr);
    return pressed;
  }
  void send(GstEvent *event) { gst_harness_push_upstream_event(harness.get(), event); }
  void send_haptic(bool pressed) {
    haptic::PointerPosition position;
    position.pressed = pressed;
    send(haptic::make_pointer_event(position).release());
  }

  void seek() {
    gst_harness_push_event(harness.get(), gst_event_new_flush_start());
    gst_harness_push_event(harness.get(), gst_event_new_flush_stop(TRUE));
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    gst_harness_push_event(harness.get(), gst_event_new_segment(&segment));
  }

  // What the frames until then make of the press at frame 1.
  BufferPtr held_until(int last) {
    pass(0);
    press(true);
    for (int i = 1; i < last; ++i)
      pass(i);
    return pass(last);
  }

  Texture texture{1};
  VideoHarness harness{"roitracker roi-size=30"};
  ElementPtr tracker = harness.element("roitracker");
};

TEST_F(Hold, WithoutAPressNothingIsHeld) {
  for (int i = 0; i < 3; ++i) {
    const BufferPtr frame = pass(i);
    EXPECT_EQ(motion_of(frame).hold, static_cast<guint>(GST_HAPTIC_HOLD_NONE));
    EXPECT_EQ(motion_of(frame).region_x, 73);
  }
}

TEST_F(Hold, ThePlaceGoesWithTheThingFromThePressOn) {
  pass(0);
  press(true);
  for (int i = 1; i <= 12; ++i) {
    const BufferPtr frame = pass(i);
    const GstHapticMotionMeta &motion = motion_of(frame);
    EXPECT_EQ(motion.hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD)) << i;
    EXPECT_NEAR(motion.held_x, kWidth / 2.0 + 2 * (i - 1), 0.1) << i;
    EXPECT_NEAR(motion.held_y, kHeight / 2.0 - (i - 1), 0.1) << i;
    EXPECT_GT(motion.held_radius, 5) << i;
    EXPECT_EQ(motion.held_time, static_cast<GstClockTime>(i - 1) * kFrame) << i;
    EXPECT_EQ(motion.pointer_x, kWidth / 2.0F) << i; // the hand stays the user's
  }
}

TEST_F(Hold, TheTimeSinceThePressIsThatOfTheVideoWhereFramesAreRepeated) {
  for (int i = 0; i <= 20; ++i) {
    const int shown = i / 3 * 3; // each frame three times
    const BufferPtr frame = pass(texture.frame(kWidth, kHeight, {2.0 * shown, -1.0 * shown}), i);
    if (i > 2) {
      EXPECT_EQ(motion_of(frame).held_time, static_cast<GstClockTime>(i - 3) * kFrame) << i;
    }
    if (i == 2)
      press(true);
  }
}

TEST_F(Hold, TheTimeSinceThePressBeginsAtTheFirstFrameWhoseTimeIsKnown) {
  pass(0);
  press(true);
  harness.pass(texture.frame(kWidth, kHeight, {2, -1}), GST_CLOCK_TIME_NONE);
  for (int i = 2; i < 6; ++i)
    pass(i);
  EXPECT_EQ(motion_of(pass(6)).held_time, 4 * kFrame);
}

TEST_F(Hold, WhatIsFeltIsTheMotionOfTheThing) {
  const BufferPtr frame = held_until(6);
  const auto found = test::displacement(frame.get());
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->x, 2, 0.05);
  EXPECT_NEAR(found->y, -1, 0.05);
  EXPECT_EQ(motion_of(frame).n_patches, 1U);
}

// A disc goes right by 1 px a frame before a ground that rests.
TEST_F(Hold, AThingIsNoTileOfItsRegion) {
  constexpr int kRadius = 18; // px
  const Texture ground{8};
  const auto is_tiled = [&](int i) {
    Frame frame = ground.frame(kWidth, kHeight, {});
    Frame disc = texture.frame(kWidth, kHeight, {1.0 * i, 0});
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (std::hypot(x - kWidth / 2 + 10 - i, y - kHeight / 2) < kRadius)
          frame.at(x, y) = disc.at(x, y);
    return (motion_of(pass(frame, i)).flags & GST_HAPTIC_MOTION_TILED) != 0;
  };
  for (int i = 0; i < 15; ++i)
    is_tiled(i);
  ASSERT_TRUE(is_tiled(15)) << "two layers";
  press(true);
  is_tiled(16);
  EXPECT_FALSE(is_tiled(17));
}

TEST_F(Hold, TheRegionGoesWithTheThing) {
  EXPECT_NEAR(motion_of(held_until(11)).region_x, 73 + 18, 1); // where it was in the frame before
}

TEST_F(Hold, LetGoThePlaceIsUnderThePointerAgain) {
  held_until(8);
  press(false);
  const BufferPtr frame = pass(9);
  EXPECT_EQ(motion_of(frame).hold, static_cast<guint>(GST_HAPTIC_HOLD_NONE));
  EXPECT_EQ(motion_of(pass(10)).region_x, 73);
}

TEST_F(Hold, CanBeSwitchedOff) {
  gst_util_set_object_arg(G_OBJECT(tracker.get()), "hold", "off");
  EXPECT_EQ(motion_of(held_until(4)).hold, static_cast<guint>(GST_HAPTIC_HOLD_NONE));
}

TEST_F(Hold, LatchedItNeedsNoPressAndNoneLetsGo) {
  const auto set_hold = [&](const char *value) {
    gst_util_set_object_arg(G_OBJECT(tracker.get()), "hold", value);
  };
  pass(0);
  set_hold("latched");
  for (int i = 1; i <= 6; ++i) {
    press(i == 3);
    EXPECT_NEAR(motion_of(pass(i)).held_x, kWidth / 2.0 + 2 * (i - 1), 0.1) << i;
  }
  set_hold("pressed");
  EXPECT_EQ(motion_of(pass(7)).hold, static_cast<guint>(GST_HAPTIC_HOLD_NONE));
  set_hold("latched");
  EXPECT_NEAR(motion_of(pass(8)).held_x, kWidth / 2.0, 0.1) << "taken anew";
}

TEST_F(Hold, LetGoAndPressedAgainBetweenTwoFramesItTakesAnew) {
  held_until(6);
  press(false);
  g_object_set(tracker.get(), "pointer-x", 0.25, nullptr);
  press(true);
  const BufferPtr frame = pass(7);
  EXPECT_NEAR(motion_of(frame).held_x, kWidth / 4.0, 0.1);
  EXPECT_EQ(motion_of(frame).held_time, 0U);
}

TEST_F(Hold, LatchedAgainBetweenTwoFramesItTakesAnew) {
  pass(0);
  gst_util_set_object_arg(G_OBJECT(tracker.get()), "hold", "latched");
  for (int i = 1; i <= 6; ++i)
    pass(i);
  gst_util_set_object_arg(G_OBJECT(tracker.get()), "hold", "pressed");
  gst_util_set_object_arg(G_OBJECT(tracker.get()), "hold", "latched");
  EXPECT_NEAR(motion_of(pass(7)).held_x, kWidth / 2.0, 0.1);
}

TEST_F(Hold, LatchedOnceMoreItTakesWhatIsUnderThePointerThen) {
  pass(0);
  gst_util_set_object_arg(G_OBJECT(tracker.get()), "hold", "latched");
  for (int i = 1; i <= 6; ++i)
    pass(i);
  g_object_set(tracker.get(), "pointer-x", 0.25, nullptr);
  EXPECT_NEAR(motion_of(pass(7)).held_x, kWidth / 2.0 + 2 * 6, 0.2);
  gst_util_set_object_arg(G_OBJECT(tracker.get()), "hold", "latched");
  EXPECT_NEAR(motion_of(pass(8)).held_x, kWidth / 4.0, 0.1);
}

TEST_F(Hold, APressOnAPlainWallIsRefusedAndFeltAsNothing) {
  const Frame wall(kWidth, kHeight, 120);
  pass(wall, 0);
  press(true);
  EXPECT_EQ(motion_of(pass(wall, 1)).hold, static_cast<guint>(GST_HAPTIC_HOLD_REFUSED));
  const BufferPtr frame = pass(2); // whatever comes there
  EXPECT_EQ(motion_of(frame).hold, static_cast<guint>(GST_HAPTIC_HOLD_REFUSED));
  EXPECT_EQ(motion_of(frame).n_patches, 0U);
}

// Who presses

TEST_F(Hold, TheFirstButtonOfTheMousePressesAndLetsGo) {
  pass(0);
  send(gst_navigation_event_new_mouse_button_press(3, 80, 60, GST_NAVIGATION_MODIFIER_NONE));
  EXPECT_FALSE(is_pressed());
  send(gst_navigation_event_new_mouse_button_press(1, 80, 60, GST_NAVIGATION_MODIFIER_NONE));
  EXPECT_TRUE(is_pressed());
  EXPECT_NEAR(motion_of(pass(1)).held_x, 80, 0.1);
  send(gst_navigation_event_new_mouse_move(90, 60, GST_NAVIGATION_MODIFIER_NONE));
  EXPECT_NEAR(motion_of(pass(2)).held_x, 82, 0.1); // the mouse does not drag the thing along
  send(gst_navigation_event_new_mouse_button_release(1, 90, 60, GST_NAVIGATION_MODIFIER_NONE));
  EXPECT_FALSE(is_pressed());
  EXPECT_EQ(motion_of(pass(3)).hold, static_cast<guint>(GST_HAPTIC_HOLD_NONE));
}

TEST_F(Hold, OfTwoFingersTheFirstOneHolds) {
  constexpr auto kNone = GST_NAVIGATION_MODIFIER_NONE;
  pass(0);
  send(gst_navigation_event_new_touch_down(7, 80, 60, 1, kNone));
  pass(1);
  send(gst_navigation_event_new_touch_down(8, 20, 20, 1, kNone));
  EXPECT_NEAR(motion_of(pass(2)).held_x, 82, 0.1);
  send(gst_navigation_event_new_touch_up(8, 20, 20, kNone));
  EXPECT_TRUE(is_pressed());
  send(gst_navigation_event_new_touch_up(7, 80, 60, kNone));
  EXPECT_FALSE(is_pressed());
}

TEST_F(Hold, AFingerThatOnlyTremblesDoesNotPoint) {
  constexpr auto kNone = GST_NAVIGATION_MODIFIER_NONE;
  pass(0);
  send(gst_navigation_event_new_touch_down(7, 80, 60, 1, kNone));
  send(gst_navigation_event_new_touch_down(8, 20, 20, 1, kNone));
  send(gst_navigation_event_new_touch_up(7, 80, 60, kNone));
  send(gst_navigation_event_new_touch_motion(8, 21, 20, 1, kNone));
  EXPECT_EQ(motion_of(pass(1)).pointer_x, 80);
  send(gst_navigation_event_new_touch_down(7, 60, 50, 1, kNone));
  EXPECT_TRUE(is_pressed());
  EXPECT_NEAR(motion_of(pass(2)).held_x, 60, 0.1);
}

TEST_F(Hold, ATouchThatIsCancelledLetsGoAndTheNextFingerHolds) {
  constexpr auto kNone = GST_NAVIGATION_MODIFIER_NONE;
  pass(0);
  send(gst_navigation_event_new_touch_down(7, 80, 60, 1, kNone));
  EXPECT_TRUE(is_pressed());
  send(gst_navigation_event_new_touch_cancel(kNone));
  EXPECT_FALSE(is_pressed());
  send(gst_navigation_event_new_touch_down(8, 60, 50, 1, kNone));
  EXPECT_TRUE(is_pressed());
  EXPECT_NEAR(motion_of(pass(1)).held_x, 60, 0.1);
}

TEST_F(Hold, AFingerThatWasLiftedDuringASeekHoldsNoLonger) {
  constexpr auto kNone = GST_NAVIGATION_MODIFIER_NONE;
  pass(0);
  send(gst_navigation_event_new_touch_down(7, 80, 60, 1, kNone));
  pass(1);
  seek();
  EXPECT_FALSE(is_pressed());
  pass(2);
  send(gst_navigation_event_new_touch_down(9, 60, 50, 1, kNone));
  EXPECT_TRUE(is_pressed());
  EXPECT_NEAR(motion_of(pass(3)).held_x, 60, 0.1);
}

TEST_F(Hold, AMouseButtonThatWasLetGoDuringASeekHoldsNoLonger) {
  constexpr auto kNone = GST_NAVIGATION_MODIFIER_NONE;
  pass(0);
  send(gst_navigation_event_new_mouse_button_press(1, 80, 60, kNone));
  pass(1);
  seek();
  EXPECT_FALSE(is_pressed());
  pass(2);
  send(gst_navigation_event_new_mouse_button_press(1, 60, 50, kNone));
  EXPECT_TRUE(is_pressed());
  EXPECT_NEAR(motion_of(pass(3)).held_x, 60, 0.1);
}

TEST_F(Hold, AButtonOfTheGripPresses) {
  pass(0);
  // The device counts as long as it reports: a test that is late sends again.
  guint hold = GST_HAPTIC_HOLD_NONE;
  int i = 1;
  test::within_a_second([&] {
    send_haptic(true);
    hold = motion_of(pass(i++)).hold;
  });
  EXPECT_EQ(hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD));
  send_haptic(false);
  EXPECT_EQ(motion_of(pass(i)).hold, static_cast<guint>(GST_HAPTIC_HOLD_NONE));
}

// What may happen while it is held

TEST_F(Hold, ASceneThatEndsLosesTheThingUntilTheNextPress) {
  held_until(4);
  const Texture other(77);
  const BufferPtr cut = pass(other.frame(kWidth, kHeight, {}), 5);
  EXPECT_EQ(motion_of(cut).hold, static_cast<guint>(GST_HAPTIC_HOLD_LOST));
  EXPECT_EQ(motion_of(cut).n_patches, 0U);
  EXPECT_EQ(motion_of(pass(other.frame(kWidth, kHeight, {1, 0}), 6)).hold,
            static_cast<guint>(GST_HAPTIC_HOLD_LOST));
  press(false);
  pass(other.frame(kWidth, kHeight, {2, 0}), 7);
  press(true);
  EXPECT_EQ(motion_of(pass(other.frame(kWidth, kHeight, {3, 0}), 8)).hold,
            static_cast<guint>(GST_HAPTIC_HOLD_HELD));
}

TEST_F(Hold, ASeekLosesTheThingUntilTheNextPress) {
  held_until(4);
  seek();
  EXPECT_EQ(motion_of(pass(40)).hold, static_cast<guint>(GST_HAPTIC_HOLD_LOST));
  EXPECT_EQ(motion_of(pass(41)).hold, static_cast<guint>(GST_HAPTIC_HOLD_LOST));
}

// A queue that leaks marks the frame after those that it dropped.
TEST_F(Hold, OutlivesFramesThatWereDropped) {
  held_until(6);
  const Frame later = texture.frame(kWidth, kHeight, {2.0 * 8, -1.0 * 8});
  const BufferPtr frame = harness.pass(later, 8 * kFrame, GST_BUFFER_FLAG_DISCONT);
  EXPECT_EQ(motion_of(frame).hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD));
  EXPECT_NEAR(motion_of(frame).held_x, kWidth / 2.0 + 2 * 7, 0.1);
  EXPECT_NEAR(motion_of(pass(9)).held_x, kWidth / 2.0 + 2 * 8, 0.1);
}

TEST_F(Hold, EndsWhereMoreThanASecondWasDropped) {
  held_until(6);
  const Frame later = texture.frame(kWidth, kHeight, {2.0 * 6, -1.0 * 6});
  const BufferPtr frame = harness.pass(later, 32 * kFrame, GST_BUFFER_FLAG_DISCONT);
  EXPECT_EQ(motion_of(frame).hold, static_cast<guint>(GST_HAPTIC_HOLD_LOST));
}

// The pointer stays where it was pressed, and there the ground rests.
TEST_F(Hold, WhatWasHiddenIsFoundAgainBeforeAGroundThatRests) {
  constexpr int kRadius = 30; // px
  const Texture ground{8};
  // A disc that goes right by 4 px a frame.
  const auto seen = [&](int i, bool is_hidden) {
    Frame frame = ground.frame(kWidth, kHeight, {});
    const Frame disc = texture.frame(kWidth, kHeight, {4.0 * i, 0});
    for (int y = 0; y < kHeight && !is_hidden; ++y)
      for (int x = 0; x < kWidth; ++x)
        if (std::hypot(x - 50 - 4 * i, y - kHeight / 2) < kRadius)
          frame.at(x, y) = disc.pixels[static_cast<std::size_t>(y) * kWidth + x];
    return frame;
  };
  g_object_set(tracker.get(), "pointer-x", 50.0 / kWidth, nullptr);
  pass(seen(0, false), 0);
  press(true);
  for (int i = 1; i <= 10; ++i)
    ASSERT_EQ(motion_of(pass(seen(i, false), i)).hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD));
  for (int i = 11; i <= 15; ++i)
    EXPECT_EQ(motion_of(pass(seen(i, true), i)).hold, static_cast<guint>(GST_HAPTIC_HOLD_HIDDEN));
  BufferPtr frame;
  for (int i = 16; i <= 20; ++i)
    frame = pass(seen(i, false), i);
  EXPECT_EQ(motion_of(frame).hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD));
  EXPECT_NEAR(motion_of(frame).held_x, 50 + 4 * 19, 1); // pressed in frame 1
}

TEST_F(Hold, ARepeatedFrameMovesNothing) {
  const float place = motion_of(held_until(4)).held_x;
  const Frame again = texture.frame(kWidth, kHeight, {8.0, -4.0}); // frame 4
  const BufferPtr repeated = pass(again, 5);
  EXPECT_EQ(motion_of(repeated).held_x, place);
  EXPECT_EQ(motion_of(repeated).hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD));
  const BufferPtr next = pass(texture.frame(kWidth, kHeight, {10.0, -5.0}), 6);
  EXPECT_NEAR(motion_of(next).held_x, place + 2, 0.1);
}

TEST_F(Hold, OverAStillSceneTheThingStaysForEver) {
  held_until(4);
  const Frame still = texture.frame(kWidth, kHeight, {8.0, -4.0});
  pass(still, 5);
  const float place = motion_of(pass(still, 6)).held_x;
  BufferPtr frame;
  for (int i = 7; i < 7 + 25 * 60; ++i) // a minute
    frame = pass(still, i);
  EXPECT_EQ(motion_of(frame).held_x, place);
  EXPECT_EQ(motion_of(frame).hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD));
}

TEST_F(Hold, NoiseOfACameraDoesNotMoveAThingThatRests) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1.5); // grey levels
  const auto noisy = [&] {
    Frame frame = texture.frame(kWidth, kHeight, {});
    for (std::uint8_t &pixel : frame.pixels)
      pixel = static_cast<std::uint8_t>(std::clamp(std::round(pixel + noise(random)), 0.0, 255.0));
    return frame;
  };
  pass(noisy(), 0);
  press(true);
  BufferPtr frame;
  for (int i = 1; i <= 100; ++i) {
    frame = pass(noisy(), i);
    ASSERT_EQ(motion_of(frame).hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD)) << i;
  }
  EXPECT_EQ(motion_of(frame).held_x, kWidth / 2.0F);
  EXPECT_EQ(motion_of(frame).held_y, kHeight / 2.0F);
}

TEST_F(Hold, APressBeforeTheFirstFrameHoldsFromThere) {
  press(true);
  EXPECT_EQ(motion_of(pass(0)).hold, static_cast<guint>(GST_HAPTIC_HOLD_HELD));
  EXPECT_NEAR(motion_of(pass(1)).held_x, kWidth / 2.0 + 2, 0.1);
}

TEST_F(Hold, OtherCapsInMidStreamLoseTheThing) {
  held_until(4);
  harness.set_format(GST_VIDEO_FORMAT_GRAY8, 2 * kWidth, kHeight);
  const Frame frame = texture.frame(2 * kWidth, kHeight, {});
  EXPECT_EQ(motion_of(pass(frame, 5)).hold, static_cast<guint>(GST_HAPTIC_HOLD_LOST));
}

} // namespace roitracker_hold_test
