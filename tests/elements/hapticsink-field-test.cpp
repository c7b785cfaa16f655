// SPDX-License-Identifier: LGPL-2.1-or-later
// hapticsink plays motion fields; what the hand felt is read from its log.
#include "virtual-sink.hpp"

#include "samples/motion-field.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

namespace hapticsink_field_test {

using namespace test;

constexpr const char *kFieldCaps = HAPTIC_FIELD_CAPS ", width=352, height=288, framerate=30/1";

// The left half moves to the left and the right half to the right, with 100 px/s.
haptic::MotionField apart(float speed = 100) {
  haptic::MotionField field;
  field.interval = kFrame;
  field.frame_width = 352;
  field.frame_height = 288;
  field.columns = 32;
  field.rows = 24;
  for (int cell = 0; cell < 32 * 24; ++cell)
    field.cells.push_back({cell % 32 < 16 ? -speed : speed, 0, 1});
  return field;
}

GstBuffer *packed(const haptic::MotionField &field, GstClockTime pts) {
  std::vector<std::uint8_t> bytes(haptic::packed_size(field));
  haptic::pack_motion_field(field, bytes);
  return test::packed(bytes, pts);
}

class HapticSinkField : public VirtualSink {
protected:
  void build_for_fields(const std::string &properties) {
    build_logging(properties);
    set_caps(kFieldCaps);
  }
  void set_caps(const char *text) {
    const haptic::CapsPtr caps(gst_caps_from_string(text));
    gst_app_src_set_caps(GST_APP_SRC(source_.get()), caps.get());
  }
  void push_fields(const haptic::MotionField &field, double seconds) {
    for (int n = static_cast<int>(seconds * 30); n > 0; --n, pts_ += kFrame)
      push(packed(field, pts_));
  }
};

TEST_F(HapticSinkField, AHandOverEitherHalfFeelsThatHalf) {
  for (const auto &[hand, sign] : {std::pair{"hold:-0.5,0,0", -1}, {"hold:0.5,0,0", 1}}) {
    build_for_fields("sim-hand=" + std::string(hand));
    pts_ = 0;
    push_fields(apart(), 0.5);
    const Row row = row_at(play_and_read_log(), 0.4);
    EXPECT_NEAR(row.vx, 100 * sign, 1e-3);
    EXPECT_NEAR(row.fx, equation5(100) * sign, 1e-6);
    EXPECT_EQ(row.fy, 0);
    EXPECT_EQ(row.spin, 0);
    EXPECT_NEAR(row.confidence, 1, 1e-6);
  }
}

TEST_F(HapticSinkField, AMovingHandFeelsWhatItComesOver) {
  build_for_fields("sim-hand=circle:0.8,1");
  push_fields(apart(), 2);
  const auto rows = play_and_read_log();
  double right = 0;
  double left = 0;
  for (const Row &row : rows) {
    if (row.time < 0.3 || row.time > 1.9)
      continue;
    // Where the grip is well within a half for longer than the slew takes, the force is of that
    // half.
    if (row.x > 0.015) {
      EXPECT_GE(row.fx, 0) << row.time;
      right = std::max(right, row.fx);
    }
    if (row.x < -0.015) {
      EXPECT_LE(row.fx, 0) << row.time;
      left = std::min(left, row.fx);
    }
  }
  EXPECT_GT(right, 0.4);
  EXPECT_LT(left, -0.4);
}

TEST_F(HapticSinkField, AMovingHandOverAStillFieldFeelsExactlyNothing) {
  build_for_fields("sim-hand=circle:0.8,0.5");
  push_fields(apart(0), 1);
  for (const Row &row : play_and_read_log()) {
    ASSERT_EQ(row.vx, 0);
    ASSERT_EQ(row.force(), 0);
  }
}

TEST_F(HapticSinkField, AHandThatPressesAThingFeelsTheThingUntilItLetsGo) {
  const auto hand = directory_ / "hand.csv";
  std::ofstream(hand) << "0,0.5,0,0,0\n0.5,0.5,0,0,1\n1.5,0.5,0,0,0\n";
  build_for_fields("sim-hand=file:" + hand.string());
  // It swings by 18 px, once a second, about the place where the hand is.
  const auto swing = [](double time) { return 18 * std::sin(2 * G_PI * time); };
  haptic::MotionField field = apart();
  for (int n = 0; n < 60; ++n, pts_ += kFrame) {
    const double time = static_cast<double>(pts_) / GST_SECOND;
    field.things = {
        {7, haptic::HoldState::held, static_cast<float>(0.75 + swing(time) / 352), 0.5F, 0.06F}};
    push(packed(field, pts_));
  }
  const auto rows = play_and_read_log();
  EXPECT_NEAR(row_at(rows, 0.4).vx, 100, 1e-3);
  for (double time = 0.6; time < 1.45; time += 0.05)
    EXPECT_NEAR(row_at(rows, time).vx, 2 * G_PI * 18 * std::cos(2 * G_PI * time), 6) << time;
  EXPECT_NEAR(row_at(rows, 1.6).vx, 100, 1e-3);
}

TEST_F(HapticSinkField, TheButtonOfADeadManSwitchHoldsNothing) {
  const auto hand = directory_ / "hand.csv";
  std::ofstream(hand) << "0,0.5,0,0,1\n";
  build_for_fields("dead-man=button sim-hand=file:" + hand.string());
  haptic::MotionField field = apart();
  field.things = {{7, haptic::HoldState::held, 0.75F, 0.5F, 0.06F}};
  push_fields(field, 1);
  EXPECT_NEAR(row_at(play_and_read_log(), 0.8).vx, 100, 1e-3) << "the thing stands still";
}

TEST_F(HapticSinkField, AHandThatPressesWhereThereIsNoThingFeelsWhatMovesThere) {
  const auto hand = directory_ / "hand.csv";
  std::ofstream(hand) << "0,0.5,0,0,1\n";
  build_for_fields("sim-hand=file:" + hand.string());
  push_fields(apart(), 1);
  EXPECT_NEAR(row_at(play_and_read_log(), 0.8).vx, 100, 1e-3);
}

TEST_F(HapticSinkField, AThingThatEndsIsLostAndTheForceGoesUntilTheNextPress) {
  const auto hand = directory_ / "hand.csv";
  std::ofstream(hand) << "0,0.5,0,0,0\n0.2,0.5,0,0,1\n1.5,0.5,0,0,0\n";
  build_for_fields("sim-hand=file:" + hand.string());
  haptic::MotionField field = apart();
  field.things = {{7, haptic::HoldState::held, 0.75F, 0.5F, 0.06F}};
  push_fields(field, 1);
  field.things.clear();
  push_fields(field, 1);
  const auto rows = play_and_read_log();
  EXPECT_NEAR(row_at(rows, 0.8).vx, 0, 0.01) << "the thing stands still";
  EXPECT_EQ(row_at(rows, 1.3).force(), 0);
  EXPECT_NEAR(row_at(rows, 1.9).vx, 100, 1e-3);
}

TEST_F(HapticSinkField, FieldsMayFollowOnSamplesAndSamplesOnFieldsWithoutInterruption) {
  build_logging("sim-hand=hold:0.5,0,0");
  push_motion(100, 0, 0.4);
  set_caps(kFieldCaps);
  push_fields(apart(), 0.4);
  set_caps(kCaps);
  push_motion(100, 0, 0.4);
  const auto rows = undisturbed(play_and_read_log());
  EXPECT_FALSE(rows.empty());
  for (const Row &row : rows)
    ASSERT_NEAR(row.fx, 0.5, 1e-6) << row.time;
}

TEST_F(HapticSinkField, ASilentFieldAGapAndADuplicateAreFeltAsTheyAreWithSamples) {
  build_for_fields("sim-hand=hold:0.5,0,0");
  push_fields(apart(), 0.3);
  haptic::MotionField duplicate = apart(-100);
  duplicate.flags = haptic::kMotionDuplicate;
  push(packed(duplicate, pts_));
  pts_ += kFrame;
  push_fields(apart(), 0.2);
  GstBuffer *gap = packed(apart(), pts_);
  GST_BUFFER_FLAG_SET(gap, GST_BUFFER_FLAG_GAP);
  push(gap);
  pts_ += kFrame;
  haptic::MotionField silent = apart();
  silent.cells.assign(silent.cells.size(), {});
  push_fields(silent, 0.3);
  play_to_end();
  EXPECT_EQ(count("gaps"), 10U);
  const auto rows = stop_and_read_log();
  for (const Row &row : undisturbed(rows))
    ASSERT_NEAR(row.fx, 0.5, 1e-6) << row.time; // the duplicate is no motion of its own
  for (const Row &row : rows) {
    if (row.time > 0.55 + 0.12) {
      ASSERT_EQ(row.force(), 0) << row.time;
    }
  }
}

TEST_F(HapticSinkField, WhereTheHandIsTheFieldMayBeSilentAndItFadesAndComesBack) {
  build_for_fields("sim-hand=hold:0.5,0,0");
  haptic::MotionField half = apart();
  for (std::size_t cell = 0; cell < half.cells.size(); ++cell)
    if (cell % 32 >= 16)
      half.cells[cell] = {};
  push_fields(apart(), 0.4);
  push_fields(half, 0.4);
  push_fields(apart(), 0.4);
  const auto rows = play_and_read_log();
  EXPECT_NEAR(row_at(rows, 0.3).fx, 0.5, 1e-6);
  EXPECT_EQ(row_at(rows, 0.7).force(), 0);
  EXPECT_NEAR(row_at(rows, 1.1).fx, 0.5, 1e-6);
}

TEST_F(HapticSinkField, DamagedFieldsAreNeverAForceAndAreWarnedOfOnce) {
  build_for_fields("sim-hand=hold:0.5,0,0");
  haptic::MotionField nan = apart();
  nan.cells[700].velocity_x = std::numeric_limits<float>::quiet_NaN();
  const haptic::MotionField huge = apart(1e30F);
  for (int i = 0; i < 10; ++i, pts_ += kFrame)
    push(packed(i % 2 ? nan : huge, pts_));
  GstBuffer *cut = packed(apart(), pts_);
  gst_buffer_set_size(cut, static_cast<gssize>(gst_buffer_get_size(cut)) - 1);
  push(cut);
  push(test::packed(moving(100, 0), pts_ + kFrame)); // a sample is no field
  push_end();
  set(GST_STATE_PLAYING);
  EXPECT_TRUE(message(GST_MESSAGE_WARNING));
  wait_for_end();
  EXPECT_FALSE(message(GST_MESSAGE_WARNING, false));
  EXPECT_EQ(count("bad-samples"), 12U);
  for (const Row &row : stop_and_read_log())
    ASSERT_EQ(row.force(), 0);
}

TEST_F(HapticSinkField, AFlushIsSilentAndThenItGoesOn) {
  build_for_fields("sim-hand=hold:0.5,0,0");
  push_fields(apart(), 3);
  set(GST_STATE_PLAYING);
  ASSERT_TRUE(advance_until([&] { return count("samples") >= 15; }));
  flush();
  const auto rows = stop_and_read_log();
  EXPECT_EQ(rows.back().force(), 0);
  EXPECT_GT(std::ranges::max_element(rows, {}, &Row::fx)->fx, 0.45);
}

} // namespace hapticsink_field_test
