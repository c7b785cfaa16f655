// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/field-hold.hpp"
#include "motion/motion-interpolator.hpp"

#include "samples/field-sampler.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>

namespace field_hold_test {

using haptic::FieldHold;
using haptic::FieldThing;
using haptic::HoldState;
using haptic::MotionField;
using haptic::MotionSample;
using haptic::PointerPosition;

constexpr std::uint64_t kInterval = 40'000'000; // ns
constexpr float kWidth = 1920;
constexpr float kHeight = 1080;

// Everything moves 50 px/s to the right.
MotionField field(std::vector<FieldThing> things = {}) {
  MotionField made;
  made.interval = kInterval;
  made.frame_width = static_cast<std::uint32_t>(kWidth);
  made.frame_height = static_cast<std::uint32_t>(kHeight);
  made.columns = 16;
  made.rows = 9;
  made.cells.assign(144, {50, 0, 0.75F});
  made.things = std::move(things);
  return made;
}

FieldThing thing(std::uint16_t id, float x, float y, HoldState state = HoldState::held) {
  return {id, state, x / kWidth, y / kHeight, 20 / kWidth};
}

PointerPosition at(float x, float y) {
  return {.x = static_cast<double>(x / kWidth), .y = static_cast<double>(y / kHeight)};
}

TEST(FieldHold, APressTakesTheNearestThingThatIsSeen) {
  const MotionField things = field({thing(1, 500, 500, HoldState::hidden), thing(2, 515, 500),
                                    thing(3, 510, 500), thing(4, 900, 500)});
  FieldHold hold;
  hold.press(at(505, 500), things);
  EXPECT_EQ(hold.sample().held.state, HoldState::held);
  EXPECT_FLOAT_EQ(hold.sample().held.x, 510 / kWidth);
  EXPECT_FLOAT_EQ(hold.sample().held.radius, 20 / kWidth);
  EXPECT_FLOAT_EQ(hold.sample().velocity_x, 50) << "of the field, until the thing has moved";
}

TEST(FieldHold, AThingIsTakenWithin24PixelsOf1920OrItsRadius) {
  for (const float radius : {20.F, 60.F}) {
    FieldThing only = thing(1, 500, 500);
    only.radius = radius / kWidth;
    for (const float offset : {-1.F, 1.F}) {
      FieldHold hold;
      hold.press(at(500, 500 + std::max(radius, 24.F) + offset), field({only}));
      EXPECT_EQ(hold.sample().held.state, offset < 0 ? HoldState::held : HoldState::about);
    }
  }
}

TEST(FieldHold, WhatIsFeltIsTheThingAndNotTheFieldAboutIt) {
  FieldHold hold;
  hold.press(at(500, 500), field({thing(1, 500, 500), thing(2, 300, 300)}));
  hold.step(field({thing(2, 300, 300), thing(1, 496, 502)}));
  const MotionSample &sample = hold.sample();
  EXPECT_NEAR(sample.velocity_x, -100, 0.01);
  EXPECT_NEAR(sample.velocity_y, 50, 0.01);
  EXPECT_EQ(sample.confidence, 1);
  EXPECT_EQ(sample.held.state, HoldState::held);
  EXPECT_FLOAT_EQ(sample.held.x, 496 / kWidth);
  EXPECT_FLOAT_EQ(sample.held.y, 502 / kHeight);
  EXPECT_EQ(sample.held.time, kInterval);
  EXPECT_EQ(sample.pointer_x, sample.held.x) << "the region follows the thing";
}

TEST(FieldHold, AThingThatIsHiddenIsNotFeltAndComesBackWithoutAJump) {
  FieldHold hold;
  hold.press(at(500, 500), field({thing(1, 500, 500)}));
  hold.step(field({thing(1, 600, 500, HoldState::hidden)}));
  EXPECT_EQ(hold.sample().held.state, HoldState::hidden);
  EXPECT_EQ(hold.sample().confidence, 0);
  hold.step(field({thing(1, 700, 500)}));
  EXPECT_EQ(hold.sample().held.state, HoldState::held);
  EXPECT_EQ(hold.sample().confidence, 0) << "where it was before is a guess";
  hold.step(field({thing(1, 702, 500)}));
  EXPECT_NEAR(hold.sample().velocity_x, 50, 0.01);
  EXPECT_EQ(hold.sample().confidence, 1);
}

TEST(FieldHold, WhereTheThingCannotBeToldTheFieldIsFeltAtItsPlace) {
  FieldHold hold;
  hold.press(at(500, 500), field({thing(1, 500, 500)}));
  hold.step(field({thing(1, 490, 500, HoldState::about)}));
  EXPECT_EQ(hold.sample().held.state, HoldState::about);
  EXPECT_FLOAT_EQ(hold.sample().held.x, 490 / kWidth);
  EXPECT_FLOAT_EQ(hold.sample().velocity_x, 50);
  EXPECT_FLOAT_EQ(hold.sample().confidence, 0.75F);
}

TEST(FieldHold, AThingThatEndsIsLostUntilTheNextPress) {
  const MotionField with = field({thing(1, 500, 500)});
  MotionField cut = with;
  cut.flags = haptic::kMotionCut;
  for (const MotionField &end : {field(), cut}) {
    FieldHold hold;
    hold.press(at(500, 500), with);
    hold.step(end);
    hold.step(with);
    EXPECT_EQ(hold.sample().held.state, HoldState::lost);
    EXPECT_EQ(hold.sample().confidence, 0);
    hold.release();
    EXPECT_FALSE(hold.is_pressed());
    hold.press(at(500, 500), with);
    EXPECT_EQ(hold.sample().held.state, HoldState::held);
  }
}

TEST(FieldHold, WhereThereIsNoThingTheMotionAboutThePlaceCarriesThePlace) {
  FieldHold hold;
  hold.press(at(500, 500), field());
  EXPECT_EQ(hold.sample().held.state, HoldState::about);
  for (int i = 0; i < 25; ++i)
    hold.step(field());
  EXPECT_NEAR(hold.sample().held.x * kWidth, 550, 0.01);
  EXPECT_FLOAT_EQ(hold.sample().velocity_x, 50);
  EXPECT_FLOAT_EQ(hold.sample().confidence, 0.75F);
  EXPECT_NEAR(hold.sample().held.radius * kWidth, 82, 1) << "half the region";
  for (int i = 0; i < 2500; ++i)
    hold.step(field());
  EXPECT_EQ(hold.sample().held.x, 1) << "not beyond the frame";
}

TEST(FieldHold, VelocitiesFollowThePaceAndPlacesDoNot) {
  // Half the pace: the interval is twice as long, and what is filmed fast is seen slow.
  MotionField slow = field({thing(1, 504, 500)});
  slow.interval *= 2;
  for (haptic::FieldCell &cell : slow.cells)
    cell.velocity_x /= 2;
  FieldHold of_thing;
  of_thing.press(at(500, 500), field({thing(1, 500, 500)}));
  of_thing.step(slow, 0, 1);
  EXPECT_NEAR(of_thing.sample().velocity_x, 50, 0.01);
  // As filmed: the velocity stays, though the interval is twice as long.
  FieldHold as_filmed;
  as_filmed.press(at(500, 500), field({thing(1, 500, 500)}));
  as_filmed.step(slow, 0, 2);
  EXPECT_NEAR(as_filmed.sample().velocity_x, 100, 0.01);
  MotionField filmed = field();
  filmed.interval *= 2;
  FieldHold about;
  about.press(at(500, 500), field());
  about.step(filmed, 0, 2);
  EXPECT_NEAR(about.sample().held.x * kWidth, 502, 0.01);
}

// ---- in the loop --------------------------------------------------------------------------------

class HeldFields : public ::testing::Test {
protected:
  static constexpr std::int64_t kFrame = kInterval;

  void add(int number, MotionField made) {
    haptic::TimedMotion motion;
    motion.field = pool_->acquire();
    *motion.field = std::move(made);
    motion.sample = haptic::frame_of(*motion.field);
    motion.measured = true;
    motion.time = number * kFrame;
    interpolator_->add(std::move(motion), (number - 2) * kFrame);
  }
  // A thing that swings by 40 px with 1 Hz.
  static float swing(int number) {
    return 500 + 40 * std::sin(2 * 3.14159265F * static_cast<float>(number * kFrame) / 1e9F);
  }
  const MotionSample &at_frame(int number, bool is_pressed) {
    PointerPosition place = at(500, 500);
    place.pressed = is_pressed;
    return interpolator_->at(number * kFrame, place).sample;
  }

  std::unique_ptr<haptic::FieldPool> pool_ = std::make_unique<haptic::FieldPool>();
  std::unique_ptr<haptic::MotionInterpolator> interpolator_ =
      std::make_unique<haptic::MotionInterpolator>();
};

TEST_F(HeldFields, WhileThePlaceIsPressedTheThingIsFeltWhereverItSwings) {
  for (int i = 0; i < 30; ++i)
    add(i, field({thing(1, swing(i), 500)}));
  EXPECT_FLOAT_EQ(at_frame(0, false).velocity_x, 50);
  at_frame(0, true);
  for (int i = 1; i < 20; ++i) {
    const MotionSample &sample = at_frame(i, true);
    EXPECT_EQ(sample.held.state, HoldState::held);
    EXPECT_NEAR(sample.held.x * kWidth, swing(i), 0.01);
    EXPECT_NEAR(sample.velocity_x, (swing(i) - swing(i - 1)) / 0.04F, 0.1) << i;
  }
  const MotionSample &released = at_frame(20, false);
  EXPECT_EQ(released.held.state, HoldState::none);
  EXPECT_FLOAT_EQ(released.velocity_x, 50);
}

TEST_F(HeldFields, BetweenFramesTheVelocityIsALine) {
  for (int i = 0; i < 4; ++i)
    add(i, field({thing(1, 500 + static_cast<float>(i * i), 500)}));
  at_frame(0, true);
  at_frame(1, true);
  PointerPosition place = at(500, 500);
  place.pressed = true;
  EXPECT_NEAR(interpolator_->at(kFrame * 3 / 2, place).sample.velocity_x, 2 / 0.04, 0.01);
}

TEST_F(HeldFields, AfterASeekTheThingIsLost) {
  for (int i = 0; i < 4; ++i)
    add(i, field({thing(1, 500, 500)}));
  at_frame(1, true);
  interpolator_->clear();
  add(2, field({thing(1, 500, 500)}));
  EXPECT_EQ(at_frame(2, true).held.state, HoldState::lost);
  EXPECT_EQ(at_frame(2, true).confidence, 0);
  EXPECT_EQ(at_frame(2, false).held.state, HoldState::none);
  EXPECT_EQ(at_frame(2, true).held.state, HoldState::held);
}

} // namespace field_hold_test
