// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-field.hpp"
#include "video-harness.hpp"

#include <cmath>
#include <gst/video/gstvideometa.h>
#include <gtest/gtest.h>

namespace motionfield_test {

using haptic::BufferPtr;
using haptic::MotionField;
using test::Frame;
using test::Shift;
using test::Texture;
using test::VideoHarness;

constexpr GstClockTime kFrame = GST_SECOND / 30;
constexpr int kWidth = 320;
constexpr int kHeight = 180;

MotionField field_of(const BufferPtr &buffer) {
  MotionField field;
  EXPECT_TRUE(buffer);
  if (!buffer)
    return field;
  GstMapInfo map;
  gst_buffer_map(buffer.get(), &map, GST_MAP_READ);
  EXPECT_TRUE(haptic::unpack_motion_field({map.data, map.size}, field));
  EXPECT_EQ(map.size, haptic::packed_size(field));
  gst_buffer_unmap(buffer.get(), &map);
  return field;
}

bool is_gap(const BufferPtr &buffer) {
  return GST_BUFFER_FLAG_IS_SET(buffer.get(), GST_BUFFER_FLAG_GAP);
}

bool is_silent(const MotionField &field) {
  return std::ranges::all_of(field.cells,
                             [](const auto &cell) { return cell == haptic::FieldCell{}; });
}

class MotionFieldElement : public ::testing::Test {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  void SetUp() override { harness.set_format(GST_VIDEO_FORMAT_GRAY8, kWidth, kHeight); }

  // The frame that a scene of uniform motion (px/s) shows at a time.
  Frame at(GstClockTime time, Shift velocity, int width = kWidth, int height = kHeight) const {
    const double seconds = static_cast<double>(time) / GST_SECOND;
    return texture.frame(width, height, {velocity.x * seconds, velocity.y * seconds});
  }

  BufferPtr pass(GstClockTime time, Shift velocity, guint flags = 0) {
    return harness.pass(at(time, velocity), time, flags);
  }

  // Of the cells whose frame stays inside, 19 of 20 say it within a tenth of a pixel.
  static void expect_velocity(const BufferPtr &buffer, Shift velocity) {
    const MotionField field = field_of(buffer);
    EXPECT_FALSE(is_gap(buffer));
    const double interval = static_cast<double>(field.interval) / GST_SECOND;
    const double tolerance = 0.1 / interval;
    const auto stays = [&](int index, int count, std::uint32_t length, double speed) {
      const double moved = speed * interval * count / length;
      return index + moved >= 0 && index + 1 + moved <= count;
    };
    int inside = 0;
    int right = 0;
    for (int row = 0; row < field.rows; ++row)
      for (int column = 0; column < field.columns; ++column) {
        if (!stays(column, field.columns, field.frame_width, velocity.x) ||
            !stays(row, field.rows, field.frame_height, velocity.y))
          continue;
        ++inside;
        const haptic::FieldCell &cell =
            field.cells[static_cast<std::size_t>(row * field.columns + column)];
        right += cell.confidence >= 0.5F &&
                 std::hypot(cell.velocity_x - velocity.x, cell.velocity_y - velocity.y) < tolerance;
      }
    EXPECT_GT(inside, field.columns * field.rows / 2);
    EXPECT_GE(right, 0.95 * inside);
  }

  Texture texture{1};
  VideoHarness harness{"motionfield"};
  test::ElementPtr element = harness.element("motionfield");
};

TEST_F(MotionFieldElement, SaysTheVelocityOfEveryCellInPixelsPerSecond) {
  for (const Shift velocity : {Shift{30, 0}, {0, 100}, {-240, 180}}) {
    pass(0, velocity, GST_BUFFER_FLAG_DISCONT);
    for (GstClockTime i = 1; i < 4; ++i) {
      const BufferPtr buffer = pass(i * kFrame, velocity);
      expect_velocity(buffer, velocity);
      const MotionField field = field_of(buffer);
      EXPECT_EQ(field.interval, kFrame);
      EXPECT_EQ(field.flags, 0);
      EXPECT_EQ(GST_BUFFER_PTS(buffer.get()), i * kFrame);
    }
  }
}

TEST_F(MotionFieldElement, TheFieldDescribesTheFrame) {
  const MotionField field = field_of(pass(0, {}));
  EXPECT_EQ(field.frame_width, kWidth);
  EXPECT_EQ(field.frame_height, kHeight);
  EXPECT_EQ(field.pixel_aspect_n, 1U);
  EXPECT_EQ(field.columns, 32);
  EXPECT_EQ(field.rows, 18);
  const haptic::CapsPtr caps(gst_pad_get_current_caps(harness.get()->sinkpad));
  const GstStructure *structure = gst_caps_get_structure(caps.get(), 0);
  EXPECT_STREQ(gst_structure_get_string(structure, "layout"), "field");
  gint width = 0;
  EXPECT_TRUE(gst_structure_get_int(structure, "width", &width));
  EXPECT_EQ(width, kWidth);
}

TEST_F(MotionFieldElement, MoreColumnsWhileRunningStartAnew) {
  pass(0, {60, 0});
  g_object_set(element.get(), "field-columns", 16, nullptr);
  const BufferPtr changed = pass(kFrame, {60, 0});
  EXPECT_TRUE(is_gap(changed));
  const MotionField field = field_of(changed);
  EXPECT_EQ(field.columns, 16);
  EXPECT_EQ(field.rows, 9);
  EXPECT_EQ(field.flags, haptic::kMotionDiscontinuity);
  expect_velocity(pass(2 * kFrame, {60, 0}), {60, 0});
}

TEST_F(MotionFieldElement, IrregularTimeStampsDoNotChangeTheVelocity) {
  const Shift velocity{60, -45};
  GstClockTime time = 0;
  pass(time, velocity);
  for (const GstClockTime ms : {50U, 100U, 20U, 33U, 70U, 90U})
    expect_velocity(pass(time += ms * GST_MSECOND, velocity), velocity);
}

TEST_F(MotionFieldElement, ARepeatedFrameIsADuplicateAndTheNextIntervalSpansBoth) {
  const Shift velocity{70, 30};
  pass(0, velocity);
  const MotionField before = field_of(pass(kFrame, velocity));
  const BufferPtr again = harness.pass(at(kFrame, velocity), 2 * kFrame);
  MotionField repeated = field_of(again);
  EXPECT_EQ(repeated.flags, haptic::kMotionDuplicate);
  EXPECT_EQ(repeated.cells, before.cells);
  EXPECT_FALSE(is_gap(again));
  const BufferPtr next = pass(3 * kFrame, velocity);
  EXPECT_EQ(field_of(next).interval, 2 * kFrame);
  expect_velocity(next, velocity);
}

// Faster and faster, so that each field needs the one before.
TEST_F(MotionFieldElement, RepeatedFramesDoNotChangeTheFieldsOfTheOthers) {
  const auto fields = [&](bool repeats) {
    std::vector<MotionField> found;
    harness.pass(texture.frame(kWidth, kHeight, {}), 0, GST_BUFFER_FLAG_DISCONT);
    for (int i = 1; i < 8; ++i) {
      const auto time = static_cast<GstClockTime>(i) * kFrame;
      const Frame frame = texture.frame(kWidth, kHeight, {2.0 * i * i, 0});
      found.push_back(field_of(harness.pass(frame, time)));
      if (repeats) {
        EXPECT_EQ(field_of(harness.pass(frame, time + kFrame / 2)).flags, haptic::kMotionDuplicate);
      }
    }
    return found;
  };
  const std::vector<MotionField> once = fields(false);
  const std::vector<MotionField> twice = fields(true);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(twice[i].interval, once[i].interval);
    EXPECT_EQ(twice[i].flags, once[i].flags);
    EXPECT_EQ(twice[i].cells, once[i].cells) << "frame " << i;
  }
}

TEST_F(MotionFieldElement, WhatRepeatsThriceStandsStillExactly) {
  harness.pass(at(0, {}), 0);
  for (GstClockTime i = 1; i < 6; ++i) {
    const MotionField field = field_of(harness.pass(at(0, {}), i * kFrame));
    if (i < 3)
      continue;
    EXPECT_EQ(field.flags, haptic::kMotionStill);
    for (const haptic::FieldCell &cell : field.cells)
      ASSERT_EQ(cell, haptic::FieldCell{.confidence = 1});
  }
  expect_velocity(pass(6 * kFrame, {10, 0}), {10 * 6, 0});
}

TEST_F(MotionFieldElement, NothingMeasuredIsAGap) {
  const BufferPtr first = pass(0, {60, 0});
  EXPECT_TRUE(is_gap(first));
  EXPECT_TRUE(is_silent(field_of(first)));
  EXPECT_EQ(field_of(first).flags, haptic::kMotionDiscontinuity);
  EXPECT_EQ(field_of(first).interval, 0U);
  std::mt19937 random(1);
  for (GstClockTime i = 1; i < 4; ++i) {
    Frame wall(kWidth, kHeight, 120);
    add_noise(wall, 1.5, random);
    const BufferPtr blank = harness.pass(wall, i * kFrame);
    EXPECT_EQ(is_gap(blank), is_silent(field_of(blank)));
    if (i > 1) {
      EXPECT_TRUE(is_gap(blank)) << i;
    }
  }
}

TEST_F(MotionFieldElement, AnotherSceneIsACutAndNoMotion) {
  pass(0, {60, 0});
  pass(kFrame, {60, 0});
  const BufferPtr cut = harness.pass(Texture(77).frame(kWidth, kHeight, {}), 2 * kFrame);
  EXPECT_TRUE(is_gap(cut));
  EXPECT_EQ(field_of(cut).flags, haptic::kMotionCut);
  EXPECT_TRUE(is_silent(field_of(cut)));
}

TEST_F(MotionFieldElement, ADiscontinuityIsNoMotion) {
  const Shift velocity{60, 20};
  pass(0, velocity);
  for (const char *what : {"flag", "segment", "flush", "pause", "no time"}) {
    GstClockTime time = kFrame;
    guint flags = 0;
    const std::string_view name = what;
    if (name == "flag")
      flags = GST_BUFFER_FLAG_DISCONT;
    if (name == "segment" || name == "flush") {
      GstSegment segment;
      gst_segment_init(&segment, GST_FORMAT_TIME);
      if (name == "flush") {
        gst_harness_push_event(harness.get(), gst_event_new_flush_start());
        gst_harness_push_event(harness.get(), gst_event_new_flush_stop(TRUE));
      }
      gst_harness_push_event(harness.get(), gst_event_new_segment(&segment));
    }
    if (name == "pause")
      time = 60 * GST_SECOND;
    if (name == "no time")
      time = GST_CLOCK_TIME_NONE;
    const BufferPtr buffer = harness.pass(at(kFrame, velocity), time, flags);
    EXPECT_TRUE(is_gap(buffer)) << what;
    EXPECT_EQ(field_of(buffer).flags, haptic::kMotionDiscontinuity) << what;
    harness.pass(at(0, velocity), 0, GST_BUFFER_FLAG_DISCONT);
  }
  expect_velocity(pass(kFrame, velocity), velocity);
}

TEST_F(MotionFieldElement, EqualTimeStampsMeasureNothing) {
  pass(0, {60, 0});
  pass(kFrame, {60, 0});
  const BufferPtr buffer = harness.pass(at(2 * kFrame, {60, 0}), kFrame);
  EXPECT_TRUE(is_gap(buffer));
  EXPECT_EQ(field_of(buffer).interval, 0U);
  expect_velocity(pass(2 * kFrame, {60, 0}), {60, 0});
}

TEST_F(MotionFieldElement, PlayedBackwardsMotionIsAsSeen) {
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.rate = -1;
  segment.stop = 10 * GST_SECOND;
  gst_harness_push_event(harness.get(), gst_event_new_segment(&segment));
  const Shift velocity{60, 0};
  for (GstClockTime i = 10; i > 5; --i) {
    const BufferPtr buffer = pass(i * kFrame, velocity);
    if (i < 10)
      expect_velocity(buffer, {-velocity.x, -velocity.y});
  }
}

TEST_F(MotionFieldElement, NewCapsInMidStreamStartAnew) {
  pass(0, {60, 0});
  pass(kFrame, {60, 0});
  harness.set_format(GST_VIDEO_FORMAT_I420, 240, 180);
  const auto pass_new = [&](GstClockTime time) {
    return harness.pass(at(time, {60, 0}, 240, 180), time);
  };
  const BufferPtr first = pass_new(2 * kFrame);
  EXPECT_TRUE(is_gap(first));
  EXPECT_EQ(field_of(first).frame_width, 240U);
  EXPECT_EQ(field_of(first).columns, 30);
  expect_velocity(pass_new(3 * kFrame), {60, 0});
}

// Things to hold

TEST_F(MotionFieldElement, HasNoThingsUnlessTheyAreAskedFor) {
  pass(0, {60, 0});
  EXPECT_TRUE(field_of(pass(kFrame, {60, 0})).things.empty());
}

TEST_F(MotionFieldElement, AThingIsTakenWhereAndWhenAPointSaysAndFollowed) {
  g_object_set(element.get(), "points",
               "0.5,0.5 0.25,0.75@0.1 2,3 nonsense 0.2, 0.3,0.3@ 0.4,0.4@nan", nullptr);
  const MotionField first = field_of(pass(0, {60, -30}));
  ASSERT_EQ(first.things.size(), 1U);
  EXPECT_NEAR(first.things[0].x, 0.5, 1e-4);
  for (GstClockTime i = 1; i < 15; ++i) {
    const BufferPtr buffer = pass(i * kFrame, {60, -30});
    const MotionField field = field_of(buffer);
    EXPECT_FALSE(is_gap(buffer));
    ASSERT_EQ(field.things.size(), i < 3 ? 1U : 2U) << i;
    EXPECT_EQ(field.things[0].id, first.things[0].id);
    EXPECT_NEAR(field.things[0].x * kWidth, 160 + 2.0 * static_cast<double>(i), 0.3);
    EXPECT_NEAR(field.things[0].y * kHeight, 90 - 1.0 * static_cast<double>(i), 0.3);
    if (i >= 3) {
      EXPECT_NEAR(field.things[1].x * kWidth, 80 + 2.0 * static_cast<double>(i - 3), 0.3);
    }
  }
}

TEST_F(MotionFieldElement, ChoosesThingsOnceTheFrameHasMovedAndAnewAfterACut) {
  g_object_set(element.get(), "things", 4U, nullptr);
  EXPECT_TRUE(field_of(pass(0, {60, 0})).things.empty());
  const MotionField chosen = field_of(pass(kFrame, {60, 0}));
  EXPECT_EQ(chosen.things.size(), 4U);
  const MotionField later = field_of(pass(2 * kFrame, {60, 0}));
  ASSERT_EQ(later.things.size(), 4U);
  EXPECT_NEAR((later.things[0].x - chosen.things[0].x) * kWidth, 2, 0.2);
  const Texture other(77);
  const BufferPtr cut = harness.pass(other.frame(kWidth, kHeight, {}), 3 * kFrame);
  EXPECT_TRUE(field_of(cut).things.empty());
  EXPECT_TRUE(is_gap(cut));
  const MotionField again =
      field_of(harness.pass(other.frame(kWidth, kHeight, {2, 0}), 4 * kFrame));
  EXPECT_EQ(again.things.size(), 4U);
  for (const auto &thing : again.things)
    for (const auto &before : chosen.things)
      EXPECT_NE(thing.id, before.id);
}

TEST_F(MotionFieldElement, ThingsRestWithTheFrameAndEndWithTheirProperties) {
  g_object_set(element.get(), "points", "0.5,0.5", nullptr);
  for (GstClockTime i = 0; i < 6; ++i)
    EXPECT_EQ(field_of(harness.pass(at(0, {}), i * kFrame)).things.size(), 1U) << i;
  g_object_set(element.get(), "points", nullptr, nullptr);
  EXPECT_TRUE(field_of(pass(6 * kFrame, {10, 0})).things.empty());
}

// They are numbered from 1 again: whoever holds one must not take another for it.
TEST_F(MotionFieldElement, OtherPointsComeAfterADiscontinuity) {
  g_object_set(element.get(), "points", "0.5,0.5", nullptr);
  pass(0, {60, 0});
  EXPECT_FALSE(is_gap(pass(kFrame, {60, 0})));
  g_object_set(element.get(), "points", "0.2,0.2", nullptr);
  const MotionField field = field_of(pass(2 * kFrame, {60, 0}));
  EXPECT_TRUE(field.flags & haptic::kMotionDiscontinuity);
  ASSERT_EQ(field.things.size(), 1U);
  EXPECT_NEAR(field.things[0].x, 0.2, 1e-4);
}

TEST_F(MotionFieldElement, ADiscontinuityEndsThings) {
  g_object_set(element.get(), "points", "0.5,0.5", nullptr);
  pass(0, {60, 0});
  EXPECT_EQ(field_of(pass(kFrame, {60, 0})).things.size(), 1U);
  EXPECT_TRUE(field_of(pass(2 * kFrame, {60, 0}, GST_BUFFER_FLAG_DISCONT)).things.empty());
}

// Without the luma of the whole frame in one piece, too.
class MotionFieldFormats : public ::testing::TestWithParam<GstVideoFormat> {
protected:
  static void SetUpTestSuite() { gst_init(nullptr, nullptr); }

  static std::vector<haptic::FieldCell> cells(GstVideoFormat format) {
    constexpr int kOddWidth = 355;
    constexpr int kOddHeight = 203;
    VideoHarness harness("motionfield");
    harness.set_format(format, kOddWidth, kOddHeight);
    const Texture texture(5);
    harness.pass(texture.frame(kOddWidth, kOddHeight, {}), 0);
    return field_of(harness.pass(texture.frame(kOddWidth, kOddHeight, {1.7, -2.2}), kFrame)).cells;
  }
};

TEST_P(MotionFieldFormats, GiveTheSameField) {
  const auto grey = cells(GST_VIDEO_FORMAT_GRAY8);
  EXPECT_GT(std::ranges::count_if(grey, [](const auto &cell) { return cell.confidence > 0.5F; }),
            static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(grey.size())));
  EXPECT_EQ(cells(GetParam()), grey);
}

INSTANTIATE_TEST_SUITE_P(
    All, MotionFieldFormats,
    ::testing::Values(GST_VIDEO_FORMAT_I420, GST_VIDEO_FORMAT_YV12, GST_VIDEO_FORMAT_NV12,
                      GST_VIDEO_FORMAT_NV21, GST_VIDEO_FORMAT_Y42B, GST_VIDEO_FORMAT_Y444,
                      GST_VIDEO_FORMAT_YUY2, GST_VIDEO_FORMAT_UYVY, GST_VIDEO_FORMAT_RGB,
                      GST_VIDEO_FORMAT_BGR, GST_VIDEO_FORMAT_RGBx, GST_VIDEO_FORMAT_BGRx,
                      GST_VIDEO_FORMAT_xRGB, GST_VIDEO_FORMAT_xBGR, GST_VIDEO_FORMAT_RGBA,
                      GST_VIDEO_FORMAT_BGRA, GST_VIDEO_FORMAT_ARGB, GST_VIDEO_FORMAT_ABGR,
                      GST_VIDEO_FORMAT_NV16, GST_VIDEO_FORMAT_P010_10LE, GST_VIDEO_FORMAT_I420_10LE,
                      GST_VIDEO_FORMAT_I422_10LE, GST_VIDEO_FORMAT_Y210, GST_VIDEO_FORMAT_v210,
                      GST_VIDEO_FORMAT_GRAY16_LE, GST_VIDEO_FORMAT_GRAY16_BE),
    [](const auto &format) { return std::string(gst_video_format_to_string(format.param)); });

TEST_F(MotionFieldElement, WorksAtAnySizeAndMeasuresNothingWhereThereIsTooLittle) {
  for (const auto &[width, height] :
       {std::pair(1, 1), {2, 300}, {300, 2}, {15, 15}, {16, 16}, {17, 33}, {331, 77}}) {
    VideoHarness small("motionfield");
    small.set_format(GST_VIDEO_FORMAT_I420, width, height);
    for (GstClockTime i = 0; i < 3; ++i) {
      const BufferPtr buffer = small.pass(at(i * kFrame, {30, 0}, width, height), i * kFrame);
      const MotionField field = field_of(buffer);
      EXPECT_EQ(is_gap(buffer), is_silent(field)) << width << 'x' << height;
      if (i > 0 && std::min(width, height) > 64) {
        EXPECT_FALSE(is_gap(buffer)) << width << 'x' << height;
      }
    }
  }
}

TEST_F(MotionFieldElement, AFrameShorterThanItsFormatIsAnErrorThatSaysSo) {
  haptic::BufferPtr buffer(gst_buffer_new_allocate(nullptr, 100, nullptr));
  GST_BUFFER_PTS(buffer.get()) = 0;
  EXPECT_EQ(harness.push(std::move(buffer)), GST_FLOW_ERROR);
  const test::MessagePtr message = harness.message(GST_MESSAGE_ERROR);
  ASSERT_TRUE(message);
  GError *error = nullptr;
  gst_message_parse_error(message.get(), &error, nullptr);
  EXPECT_NE(std::string(error->message).find("cannot be read"), std::string::npos);
  g_error_free(error);
}

TEST_F(MotionFieldElement, EveryPropertyMayBeSetWhileRunning) {
  for (GstClockTime i = 0; i < 60; ++i) {
    test::flip_every_property(element.get(), 1);
    EXPECT_TRUE(pass(i * kFrame, {40, 0}));
  }
}

TEST_F(MotionFieldElement, StartsAndStopsTwoHundredTimes) {
  const test::ElementPtr pipeline(gst_parse_launch(
      "videotestsrc num-buffers=2 ! video/x-raw,width=64,height=48 ! motionfield ! fakesink",
      nullptr));
  for (int i = 0; i < 200; ++i)
    ASSERT_EQ(test::run_to_end(pipeline.get()), std::nullopt) << i;
}

// A thing in the middle of a moving background. It moves by itself.
class FilmedFromACar : public MotionFieldElement {
protected:
  static constexpr Shift kCamera{120, 30}; // px/s
  static constexpr Shift kThing{-60, 0};

  BufferPtr pass_frame(GstClockTime i, Shift camera) {
    Frame frame = at(i * kFrame, camera);
    const double seconds = static_cast<double>(i * kFrame) / GST_SECOND;
    Frame thing(kWidth, kHeight);
    other.paint(thing, {kThing.x * seconds, kThing.y * seconds});
    for (int y = 60; y < 120; ++y)
      for (int x = 100; x < 220; ++x)
        frame.at(x, y) = thing.at(x, y);
    return harness.pass(frame, i * kFrame, i == 0 ? GST_BUFFER_FLAG_DISCONT : 0);
  }

  static std::string camera_model(const BufferPtr &buffer) {
    auto *meta = gst_buffer_get_custom_meta(buffer.get(), "haptic-camera-motion");
    return meta ? gst_structure_get_string(gst_custom_meta_get_structure(meta), "model") : "";
  }

  // The models that the messages of a run name.
  static std::vector<std::string> announced_by(GstElement *pipeline) {
    std::vector<std::string> models;
    const haptic::BusPtr bus(gst_element_get_bus(pipeline));
    gst_bus_set_sync_handler(
        bus.get(),
        [](GstBus *, GstMessage *message, gpointer data) {
          if (gst_message_has_name(message, "haptic-camera-motion"))
            static_cast<std::vector<std::string> *>(data)->emplace_back(
                gst_structure_get_string(gst_message_get_structure(message), "model"));
          return GST_BUS_PASS;
        },
        &models, nullptr);
    EXPECT_EQ(test::run_to_end(pipeline), std::nullopt);
    gst_bus_set_sync_handler(bus.get(), nullptr, nullptr, nullptr);
    return models;
  }

  static haptic::FieldCell cell_at(const MotionField &field, int x, int y) {
    return field.cells[static_cast<std::size_t>(y * field.rows / kHeight * field.columns +
                                                x * field.columns / kWidth)];
  }

  Texture other{2};
};

TEST_F(FilmedFromACar, WithoutTheCameraTheBackgroundRestsAndTheThingMovesAgainstIt) {
  g_object_set(element.get(), "camera", 1, nullptr);
  BufferPtr buffer;
  for (GstClockTime i = 0; i < 4; ++i)
    buffer = pass_frame(i, kCamera);
  EXPECT_EQ(camera_model(buffer), "translation");
  const MotionField field = field_of(buffer);
  const haptic::FieldCell ground = cell_at(field, 60, 30);
  EXPECT_NEAR(ground.velocity_x, 0, 3);
  EXPECT_NEAR(ground.velocity_y, 0, 3);
  const haptic::FieldCell thing = cell_at(field, 160, 90);
  EXPECT_NEAR(thing.velocity_x, kThing.x - kCamera.x, 5);
  EXPECT_NEAR(thing.velocity_y, kThing.y - kCamera.y, 5);
}

TEST_F(FilmedFromACar, EachRunAnnouncesTheCameraAnew) {
  const test::ElementPtr pipeline(gst_parse_launch(
      "videotestsrc num-buffers=4 ! motionfield camera=remove ! fakesink", nullptr));
  const std::vector<std::string> first = announced_by(pipeline.get());
  EXPECT_FALSE(first.empty());
  EXPECT_EQ(announced_by(pipeline.get()), first);
}

TEST_F(FilmedFromACar, AStandingCameraLeavesEachByteAsItWas) {
  std::vector<MotionField> kept;
  for (const int camera : {0, 1}) {
    g_object_set(element.get(), "camera", camera, nullptr);
    for (GstClockTime i = 0; i < 4; ++i) {
      const BufferPtr buffer = pass_frame(i, {});
      EXPECT_EQ(camera_model(buffer), camera == 0 ? "" : i == 0 ? "none" : "static");
      if (camera == 0)
        kept.push_back(field_of(buffer));
      else
        EXPECT_EQ(field_of(buffer), kept[i]);
    }
  }
}

} // namespace motionfield_test
