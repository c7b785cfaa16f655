// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/sample-intake.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <vector>

namespace sample_intake_test {

using haptic::kAtOnce;
using haptic::LatencyMode;
using haptic::MotionField;
using haptic::MotionSample;
using haptic::Presentation;
using haptic::SampleIntake;

constexpr std::int64_t kMs = 1'000'000; // ns
constexpr std::uint64_t kFrame = 40 * kMs;

MotionSample sample(float vx, std::uint64_t interval = kFrame) {
  MotionSample s;
  s.velocity_x = vx;
  s.spin = 1;
  s.confidence = 1;
  s.interval = interval;
  s.frame_width = 352;
  s.frame_height = 288;
  return s;
}

MotionField field(float vx, std::uint64_t interval = kFrame) {
  MotionField f;
  f.interval = interval;
  f.frame_width = 352;
  f.frame_height = 288;
  f.columns = 2;
  f.rows = 1;
  f.cells = {{vx, 0, 1}, {}};
  return f;
}

std::vector<std::uint8_t> bytes_of(const MotionSample &s) {
  const auto bytes = haptic::pack_motion_sample(s);
  return {bytes.begin(), bytes.end()};
}
std::vector<std::uint8_t> bytes_of(const MotionField &f) {
  std::vector<std::uint8_t> bytes(haptic::packed_size(f));
  haptic::pack_motion_field(f, bytes);
  return bytes;
}

// Every test with samples and with fields: what holds for the one holds for the other.
class Intake : public ::testing::TestWithParam<bool> {
protected:
  void SetUp() override { intake_.set_layout(fields()); }
  bool fields() const { return GetParam(); }

  SampleIntake::Result accept(float vx, std::uint64_t interval, std::uint16_t flags,
                              const Presentation &presentation) {
    if (fields()) {
      MotionField f = field(vx, interval);
      f.flags = flags;
      return intake_.accept(bytes_of(f), false, presentation);
    }
    MotionSample s = sample(vx, interval);
    s.flags = flags;
    return intake_.accept(bytes_of(s), false, presentation);
  }
  SampleIntake::Result accept(float vx, const Presentation &presentation = {}) {
    return accept(vx, kFrame, 0, presentation);
  }
  static float velocity(const SampleIntake::Result &result) {
    return result.motion->field ? result.motion->field->cells[0].velocity_x
                                : result.motion->sample.velocity_x;
  }

  std::unique_ptr<haptic::FieldPool> pool_ = std::make_unique<haptic::FieldPool>();
  SampleIntake intake_{*pool_};
};

TEST_P(Intake, AMotionIsThatOfTheMiddleOfItsInterval) {
  const auto result = accept(100, {.time = 1000 * kMs});
  ASSERT_TRUE(result.motion);
  EXPECT_FALSE(result.damaged);
  EXPECT_TRUE(result.motion->measured);
  EXPECT_EQ(result.motion->time, 980 * kMs);
  EXPECT_EQ(velocity(result), 100);
  EXPECT_EQ(result.motion->sample.frame_width, 352U);
  EXPECT_EQ(intake_.samples(), 1U);
}

TEST_P(Intake, WithoutAPresentationTimeItIsFeltAtOnce) {
  EXPECT_EQ(accept(100).motion->time, kAtOnce);
}

TEST_P(Intake, AtHalfSpeedAMotionIsHalfAsFastAndLastsTwiceAsLong) {
  const auto result = accept(100, {.time = 1000 * kMs, .playback = {.rate = 0.5}});
  EXPECT_EQ(velocity(result), 50);
  EXPECT_EQ(result.motion->sample.interval, 2 * kFrame);
  EXPECT_EQ(result.motion->time, 960 * kMs);
}

TEST_P(Intake, BeyondTwiceTheSpeedAFrameIsAGap) {
  const auto result = accept(100, {.time = 1000 * kMs, .playback = {.rate = 3}});
  ASSERT_TRUE(result.motion);
  EXPECT_FALSE(result.motion->measured);
  EXPECT_EQ(intake_.gaps(), 1U);
}

TEST_P(Intake, ARepeatedFrameIsNoMotionAndNoGap) {
  const auto result = accept(100, kFrame, haptic::kMotionDuplicate, {});
  EXPECT_FALSE(result.motion);
  EXPECT_FALSE(result.damaged);
  EXPECT_EQ(intake_.gaps(), 0U);
}

// 24 frames a second carried in 30: the velocities of an even motion are corrected to be even.
TEST_P(Intake, FilmInVideoIsCorrected) {
  for (int i = 0; i < 40; ++i) {
    if (i % 5 == 4) {
      accept(0, kFrame, haptic::kMotionDuplicate, {});
      continue;
    }
    const bool late = i % 5 == 0;
    const auto result = accept(late ? 50 : 100, late ? 2 * kFrame : kFrame, 0, {});
    if (i > 20) {
      EXPECT_NEAR(velocity(result), 80, 0.01) << i;
    }
  }
}

TEST_P(Intake, DamagedBytesAreNeverAMotion) {
  for (const float speed : {1e30F, std::numeric_limits<float>::quiet_NaN()}) {
    const auto result = accept(speed);
    EXPECT_TRUE(result.damaged);
    ASSERT_TRUE(result.motion);
    EXPECT_FALSE(result.motion->measured);
  }
  EXPECT_TRUE(intake_.accept(std::vector<std::uint8_t>(7, 0x55), false, {}).damaged);
  EXPECT_TRUE(intake_.accept({}, false, {}).damaged);
  EXPECT_EQ(intake_.bad_samples(), 4U);
  EXPECT_EQ(intake_.samples(), 0U);
}

TEST_P(Intake, ABufferWithTheGapFlagIsAGapWhateverItHolds) {
  EXPECT_FALSE(intake_.accept({}, true, {}).damaged);
  const auto bytes = fields() ? bytes_of(field(100)) : bytes_of(sample(100));
  const auto result = intake_.accept(bytes, true, {.time = 1000 * kMs});
  EXPECT_FALSE(result.motion->measured);
  EXPECT_EQ(result.motion->time, 980 * kMs);
  EXPECT_EQ(intake_.gaps(), 2U);
}

TEST_P(Intake, TheLookAheadGrowsToOneAndAHalfOfTheUsualIntervals) {
  intake_.set_frame_duration(kFrame);
  EXPECT_EQ(intake_.look_ahead(), 60U * kMs);
  accept(100, 10 * kFrame, 0, {}); // a single late frame
  EXPECT_EQ(intake_.look_ahead(), 60U * kMs);
  accept(100, 10 * kFrame, 0, {});
  EXPECT_EQ(intake_.look_ahead(), 600U * kMs);
  accept(100, 100 * kFrame, 0, {});
  accept(100, 100 * kFrame, 0, {});
  EXPECT_EQ(intake_.look_ahead(), 750U * kMs);
  accept(100, kFrame, 0, {});
  accept(100, kFrame, 0, {});
  EXPECT_EQ(intake_.look_ahead(), 750U * kMs);
}

INSTANTIATE_TEST_SUITE_P(Layouts, Intake, ::testing::Bool(),
                         [](const auto &layout) { return layout.param ? "Field" : "Sample"; });

TEST(SampleIntakeTest, ASampleBringsTheThingThatIsHeld) {
  const auto pool = std::make_unique<haptic::FieldPool>();
  SampleIntake intake(*pool);
  MotionSample s = sample(100);
  s.held = {haptic::HoldState::held, 0.25F, 0.75F, 0.1F, 2 * kFrame};
  const auto result = intake.accept(bytes_of(s), false, {});
  EXPECT_FALSE(result.damaged);
  EXPECT_EQ(result.motion->sample.held, s.held);
  EXPECT_EQ(result.motion->sample.velocity_x, 100);
}

TEST(SampleIntakeTest, ADuplicateBringsAnotherThingThatIsHeld) {
  const auto pool = std::make_unique<haptic::FieldPool>();
  SampleIntake intake(*pool);
  MotionSample s = sample(100);
  const auto accept = [&](std::uint64_t time) {
    s.held = {haptic::HoldState::held, 0.25F, 0.75F, 0.1F, time};
    return intake.accept(bytes_of(s), false, {});
  };
  accept(5 * kFrame);
  s.flags = haptic::kMotionDuplicate;
  EXPECT_FALSE(accept(6 * kFrame).motion) << "the same";
  ASSERT_TRUE(accept(0).motion) << "let go and pressed again within a frame";
}

TEST(FieldIntake, AFieldWithoutAnyConfidenceIsAGap) {
  const auto pool = std::make_unique<haptic::FieldPool>();
  SampleIntake intake(*pool);
  intake.set_layout(true);
  MotionField silent = field(100);
  silent.cells.assign(2, {});
  EXPECT_FALSE(intake.accept(bytes_of(silent), false, {}).motion->measured);
  EXPECT_EQ(intake.gaps(), 1U);
}

TEST(FieldIntake, AFieldWithThingsIsNone) {
  const auto pool = std::make_unique<haptic::FieldPool>();
  SampleIntake intake(*pool);
  intake.set_layout(true);
  MotionField silent = field(100);
  silent.cells.assign(2, {});
  silent.things = {{.id = 1, .x = 0.5F, .y = 0.5F, .radius = 0.1F}};
  const auto result = intake.accept(bytes_of(silent), false, {});
  ASSERT_TRUE(result.motion->field);
  EXPECT_EQ(result.motion->field->things.size(), 1U);
  EXPECT_EQ(intake.gaps(), 0U);
}

TEST(FieldIntake, WhileAllFieldsAreInUseTheNewestIsLost) {
  const auto pool = std::make_unique<haptic::FieldPool>();
  SampleIntake intake(*pool);
  intake.set_layout(true);
  std::vector<haptic::TimedMotion> kept;
  for (std::size_t i = 0; i < haptic::FieldPool::kSlots; ++i)
    kept.push_back(*intake.accept(bytes_of(field(100)), false, {}).motion);
  EXPECT_FALSE(intake.accept(bytes_of(field(100)), false, {}).motion);
  kept.pop_back();
  EXPECT_TRUE(intake.accept(bytes_of(field(100)), false, {}).motion);
}

TEST(LatencyModeTest, AutomaticFollowsTheSourceAndIsAskedOnlyThen) {
  const auto yes = [] { return true; };
  const auto no = [] { return false; };
  const auto never = [] {
    ADD_FAILURE() << "asked";
    return true;
  };
  EXPECT_TRUE(haptic::is_immediate(LatencyMode::automatic, true, yes));
  EXPECT_FALSE(haptic::is_immediate(LatencyMode::automatic, true, no));
  EXPECT_TRUE(haptic::is_immediate(LatencyMode::immediate, true, never));
  EXPECT_FALSE(haptic::is_immediate(LatencyMode::synchronized, true, never));
  EXPECT_TRUE(haptic::is_immediate(LatencyMode::synchronized, false, never)); // sync=false
}

} // namespace sample_intake_test
