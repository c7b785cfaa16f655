// SPDX-License-Identifier: LGPL-2.1-or-later
// The way of a held thing between the frames that show it.
#include "motion/motion-interpolator.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

namespace held_path_test {

using haptic::HeldAt;
using haptic::HoldState;
using haptic::MotionInterpolator;
using haptic::TimedMotion;

constexpr std::int64_t kMs = 1'000'000; // ns
constexpr std::int64_t kFrame = 40 * kMs;

// A frame that is seen at so many ms and comes 1.5 intervals early, as of a file.
class Film {
public:
  void show(int ms, double x, HoldState state = HoldState::held) {
    TimedMotion frame{.measured = state != HoldState::hidden, .time = ms * kMs - kFrame / 2};
    frame.sample.confidence = frame.measured ? 1 : 0;
    frame.sample.interval = kFrame;
    frame.sample.held = {.state = state,
                         .x = static_cast<float>(x),
                         .y = 0.5F,
                         .time = static_cast<std::uint64_t>(ms - taken) * kMs};
    motion.add(std::move(frame), ms * kMs - 3 * kFrame / 2);
  }
  HeldAt at(int ms) { return motion.at(ms * kMs).held; }

  MotionInterpolator motion;
  int taken = 0; // ms
};

double sway(int ms) {
  return 0.5 + 0.1 * std::sin(2 * std::numbers::pi * ms / 1000.0);
}

TEST(HeldPath, AThingIsWhereTheFrameShowsItWithoutAStepOfPlaceOrSpeed) {
  constexpr double kFastest = 0.1 * 2 * std::numbers::pi / 1000;             // 1/ms
  constexpr double kSharpest = kFastest * 2 * std::numbers::pi / 1000 * 1.1; // 1/ms²
  Film film;
  double before = 0;
  double way = 0;
  for (int ms = 0; ms < 3000; ++ms) {
    if (ms % 40 == 0)
      film.show(ms + 60, sway(ms + 60));
    const HeldAt now = film.at(ms);
    if (ms < 60)
      continue;
    ASSERT_EQ(now.state, HoldState::held);
    ASSERT_NEAR(now.place.x, sway(ms), 0.001) << ms;
    if (ms > 62) {
      ASSERT_NEAR(now.moved.x, now.place.x - before, 1e-12);
      ASSERT_LE(std::abs(now.moved.x - way), kSharpest) << ms;
    }
    before = now.place.x;
    way = now.moved.x;
  }
}

TEST(HeldPath, WithoutNewFramesItComesToRestAtTheLastKnownPlace) {
  Film film;
  for (int ms = 40; ms <= 400; ms += 40) {
    film.show(ms, ms / 1000.0);
    for (int t = 0; t < 40; ++t)
      film.at(ms - 60 + t);
  }
  double most = 0;
  for (int ms = 380; ms < 800; ++ms)
    most = std::max(most, film.at(ms).place.x);
  EXPECT_NEAR(film.at(800).place.x, 0.4, 1e-6);
  EXPECT_LE(most, 0.4 + 1e-6);
}

TEST(HeldPath, ThatItIsLetGoIsKnownAtOnceAlsoWhenItsFrameIsToCome) {
  for (const HoldState state : {HoldState::none, HoldState::about, HoldState::lost}) {
    Film film;
    film.show(40, 0.5);
    film.show(80, 0.5);
    ASSERT_EQ(film.at(70).state, HoldState::held);
    film.show(1000, 0.5, state);
    EXPECT_EQ(film.at(71).state, HoldState::none);
    film.at(990);
    EXPECT_EQ(film.at(990).state, state);
  }
}

TEST(HeldPath, ATapThatIsOverBeforeItsFrameIsSeenIsNotFelt) {
  Film film;
  film.motion.add({}, 0);
  film.show(80, 0.5);
  film.show(120, 0.5, HoldState::none);
  for (int ms = 0; ms < 200; ++ms)
    ASSERT_EQ(film.at(ms).state, HoldState::none) << ms;
}

// A frame that comes too close after the one that lets go takes its place.
TEST(HeldPath, WhatIsHeldAgainInTheNextFrameIsFollowed) {
  Film film;
  for (int ms = 40; ms <= 200; ms += 40)
    film.show(ms, 0.5);
  film.at(180);
  film.show(240, 0.5, HoldState::about);
  film.show(245, 0.5);
  film.at(230);
  EXPECT_EQ(film.at(240).state, HoldState::held);
}

TEST(HeldPath, FromOneThingToAnotherThereIsNoWay) {
  Film film;
  for (int ms = 40; ms <= 800; ms += 40) {
    if (ms == 400)
      film.taken = 400; // it is pressed anew, elsewhere
    film.show(ms, ms < 400 ? 0.2 : 0.8);
    for (int t = 0; t < 40; ++t)
      ASSERT_EQ(film.at(ms - 60 + t).moved.x, 0) << ms;
  }
  EXPECT_NEAR(film.at(800).place.x, 0.8, 1e-6);
}

TEST(HeldPath, AHiddenThingStaysAndIsFollowedAgainWhenItIsSeen) {
  Film film;
  double way = 0;
  for (int ms = 40; ms <= 800; ms += 40) {
    const bool hidden = ms > 200 && ms < 500;
    film.show(ms, hidden ? 0.9 : ms / 1000.0, hidden ? HoldState::hidden : HoldState::held);
    for (int t = 0; t < 40; ++t) {
      const HeldAt now = film.at(ms - 60 + t);
      way += now.moved.x;
      if (now.state == HoldState::hidden) {
        ASSERT_LE(now.place.x, 0.6) << "a guess leads nowhere";
      }
    }
  }
  for (int ms = 780; ms < 900; ++ms)
    way += film.at(ms).moved.x;
  EXPECT_NEAR(way, 0.78, 0.001); // from the middle before the frame in which it was taken
}

TEST(HeldPath, AFlushForgetsTheThing) {
  Film film;
  film.show(40, 0.5);
  ASSERT_EQ(film.at(30).state, HoldState::held);
  film.motion.clear();
  EXPECT_EQ(film.at(31).state, HoldState::none);
}

} // namespace held_path_test
