// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hold/held-thing.hpp"
#include "instruction-sets.hpp"
#include "moving-texture.hpp"
#include "plane-source.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <optional>
#include <random>

namespace held_thing_test {

using haptic::HeldReport;
using haptic::HeldThing;
using haptic::HoldState;
using test::Frame;
using test::PlaneSource;
using test::Shift;
using test::Texture;

constexpr int kWidth = 320;
constexpr int kHeight = 200;
constexpr double kRate = 30; // frames a second
constexpr Shift kMiddle{kWidth / 2.0, kHeight / 2.0};

/// A disc of one texture before another one, and a bar before both.
struct Stage {
  Texture disc{3};
  Texture ground{8};
  Texture bar{21};
  double radius = 34; // px

  /// The disc in front of the still ground, its middle moved by `shift` from that of the frame.
  Frame frame(Shift shift, std::optional<double> bar_from = {}) const {
    Frame frame = ground.frame(kWidth, kHeight, {});
    const Frame thing = disc.frame(kWidth, kHeight, shift);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double away =
            std::hypot(x + 0.5 - kMiddle.x - shift.x, y + 0.5 - kMiddle.y - shift.y);
        const double part = std::clamp(radius + 0.5 - away, 0.0, 1.0);
        const double grey = part * thing.pixels[at(x, y)] + (1 - part) * frame.pixels[at(x, y)];
        frame.at(x, y) = static_cast<std::uint8_t>(std::lround(grey));
      }
    if (bar_from) {
      const auto left = static_cast<int>(*bar_from);
      const int right = std::min(left + kBarWidth, kWidth);
      if (left < kWidth && right > 0)
        bar.paint(frame, {*bar_from, 0}, std::max(left, 0), right);
    }
    return frame;
  }

  static constexpr int kBarWidth = 110; // px

private:
  static std::size_t at(int x, int y) {
    return static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x);
  }
};

Shift sway(double time, double amplitude = 20) {
  return {amplitude * std::sin(2 * std::numbers::pi * time),
          amplitude / 3 * std::sin(2 * std::numbers::pi * time / 1.6)};
}

double distance(const HeldReport &report, Shift shift) {
  return std::hypot(report.x - kMiddle.x - shift.x, report.y - kMiddle.y - shift.y);
}

class AHeldThing : public ::testing::Test {
protected:
  const HeldReport &take(const Frame &frame, Shift at = kMiddle) {
    return thing.take(PlaneSource(frame), frame.width, frame.height, static_cast<float>(at.x),
                      static_cast<float>(at.y));
  }
  const HeldReport &follow(const Frame &frame, double rate = kRate) {
    return thing.follow(PlaneSource(frame), static_cast<float>(1 / rate));
  }

  Stage stage;
  HeldThing thing;
};

// What is followed

// Pressed near its border, where half of what is near is of the ground, and without the object it
// drifts by 0.8 px.
TEST_F(AHeldThing, OfAKnownExtentIsFollowedBeforeAGroundThatIsNot) {
  stage.radius = 20;
  const Shift border{kMiddle.x + 14, kMiddle.y + 8};
  const Frame first = stage.frame({});
  const haptic::Rectangle object{kWidth / 2 - 20, kHeight / 2 - 20, 40, 40};
  ASSERT_EQ(thing
                .take(PlaneSource(first), kWidth, kHeight, static_cast<float>(border.x),
                      static_cast<float>(border.y), object)
                .state,
            HoldState::held);
  for (int i = 1; i <= 30; ++i) {
    const Shift shift = sway(i / kRate);
    const HeldReport &report = follow(stage.frame(shift));
    ASSERT_EQ(report.state, HoldState::held) << i;
    EXPECT_LT(std::hypot(report.x - border.x - shift.x, report.y - border.y - shift.y), 0.4) << i;
  }
}

TEST_F(AHeldThing, IsFollowedToAFractionOfAPixel) {
  ASSERT_EQ(take(stage.frame({})).state, HoldState::held);
  for (int i = 1; i <= 60; ++i) {
    const HeldReport &report = follow(stage.frame(sway(i / kRate)));
    ASSERT_EQ(report.state, HoldState::held) << i;
    EXPECT_LT(distance(report, sway(i / kRate)), 0.2) << i;
  }
}

TEST_F(AHeldThing, SaysHowFarItMovedSinceTheFrameBefore) {
  take(stage.frame({}));
  for (int i = 1; i <= 20; ++i) {
    const HeldReport &report = follow(stage.frame(sway(i / kRate)));
    EXPECT_NEAR(report.dx, sway(i / kRate).x - sway((i - 1) / kRate).x, 0.2) << i;
    EXPECT_NEAR(report.dy, sway(i / kRate).y - sway((i - 1) / kRate).y, 0.2) << i;
    EXPECT_GT(report.variance, 0) << i;
  }
}

TEST_F(AHeldThing, IsFollowedAtAnyFrameRate) {
  for (const double rate : {24.0, 60.0, 120.0}) {
    take(stage.frame({}));
    const int frames = static_cast<int>(rate);
    for (int i = 1; i <= frames; ++i)
      ASSERT_EQ(follow(stage.frame(sway(i / rate)), rate).state, HoldState::held)
          << rate << " " << i;
    EXPECT_LT(distance(thing.report(), sway(frames / rate)), 0.3) << rate;
  }
}

// What seems to move meanwhile is an error of the place.
TEST_F(AHeldThing, IsFollowedAfterTwoFramesOfNearlyTheSameTime) {
  constexpr double kMoment = 1e6; // frames a second
  take(stage.frame({}));
  for (int i = 1; i <= 20; ++i)
    follow(stage.frame({0.5 * i, 0}));
  follow(stage.frame({10.2, 0}), kMoment);
  EXPECT_EQ(follow(stage.frame({10.7, 0})).state, HoldState::held);
  EXPECT_LT(distance(thing.report(), {10.7, 0}), 0.5);
  thing.follow(PlaneSource(stage.frame({16, 0})), 1e-9F);
  EXPECT_TRUE(std::isfinite(thing.follow(PlaneSource(stage.frame({16.5, 0})), 1).x));
}

TEST_F(AHeldThing, IsFollowedInALargeFrameThatIsReduced) {
  constexpr int kLargeWidth = 1200;
  constexpr int kLargeHeight = 240;
  const Texture texture(5, 10); // nothing that halving would lose
  const Shift middle{kLargeWidth / 2.0 + 0.3, kLargeHeight / 2.0 - 0.2};
  ASSERT_EQ(take(texture.frame(kLargeWidth, kLargeHeight, {}), middle).state, HoldState::held);
  for (int i = 1; i <= 10; ++i)
    follow(texture.frame(kLargeWidth, kLargeHeight, {3.7 * i, -1.1 * i}));
  EXPECT_NEAR(thing.report().x, middle.x + 37, 0.2);
  EXPECT_NEAR(thing.report().y, middle.y - 11, 0.2);
}

TEST_F(AHeldThing, IsFollowedWhileItTurns) {
  constexpr int kSide = 240;
  const Texture texture(6);
  take(texture.turned(kSide, kSide, 0), {kSide / 2.0, kSide / 2.0});
  for (int i = 1; i <= 60; ++i) {
    const HeldReport &report = follow(texture.turned(kSide, kSide, 0.01 * i));
    ASSERT_EQ(report.state, HoldState::held) << i;
    EXPECT_LT(std::hypot(report.x - kSide / 2.0, report.y - kSide / 2.0), 0.5) << i;
  }
}

TEST_F(AHeldThing, IsTheSameInEveryInstructionSet) {
  std::optional<HeldReport> best;
  test::for_instruction_sets([&](const char *name) {
    take(stage.frame({}));
    for (int i = 1; i <= 15; ++i)
      follow(stage.frame(sway(i / kRate)));
    const HeldReport report = thing.report();
    if (!best)
      best = report;
    EXPECT_EQ(report.state, best->state) << name;
    EXPECT_NEAR(report.x, best->x, 0.01) << name;
    EXPECT_NEAR(report.y, best->y, 0.01) << name;
  });
}

TEST_F(AHeldThing, StaysWhereTheSamePixelsStay) {
  take(stage.frame({}));
  const Frame still = stage.frame(sway(1 / kRate));
  follow(still);
  const HeldReport before = thing.report();
  for (int i = 0; i < 300; ++i)
    thing.rest(PlaneSource(still), static_cast<float>(1 / kRate));
  EXPECT_EQ(thing.report().x, before.x);
  EXPECT_EQ(thing.report().y, before.y);
  EXPECT_EQ(thing.report().dx, 0);
  EXPECT_EQ(thing.report().dy, 0);
}

// What is not seen

TEST_F(AHeldThing, IsHiddenBehindABarAndFoundAgain) {
  take(stage.frame({}));
  const auto bar_at = [](int i) { return kWidth - 12.0 * i; }; // before the middle at frame 14
  int hidden = 0;
  for (int i = 1; i <= 30; ++i) {
    const Shift shift = sway(i / kRate, 8);
    const HeldReport &report = follow(stage.frame(shift, bar_at(i)));
    const double left = bar_at(i);
    const double middle = kMiddle.x + shift.x;
    if (left < middle - 12 && left + Stage::kBarWidth > middle + 12) {
      EXPECT_NE(report.state, HoldState::held) << i;
      hidden += report.state == HoldState::hidden;
    }
  }
  EXPECT_GE(hidden, 3);
  const HeldReport &report = follow(stage.frame(sway(31 / kRate, 8), bar_at(31)));
  EXPECT_EQ(report.state, HoldState::held);
  EXPECT_LT(distance(report, sway(31 / kRate, 8)), 0.3);
}

// When it was seen last, its velocity led to the right by 100 px.
TEST_F(AHeldThing, ThatTurnsBackWhileItIsHiddenIsFoundInItsSwing) {
  constexpr double kAmplitude = 60; // px
  take(stage.frame({}));
  int i = 1;
  for (; i <= 35; ++i)
    ASSERT_EQ(follow(stage.frame(sway(i / kRate, kAmplitude))).state, HoldState::held) << i;
  const Frame empty = stage.ground.frame(kWidth, kHeight, {});
  for (; i <= 53; ++i)
    EXPECT_EQ(follow(empty).state, HoldState::hidden) << i;
  for (; i <= 58; ++i)
    follow(stage.frame(sway(i / kRate, kAmplitude)));
  EXPECT_EQ(thing.report().state, HoldState::held);
  EXPECT_LT(distance(thing.report(), sway((i - 1) / kRate, kAmplitude)), 0.5);
}

// In a shade that changes all the time it is followed about. A bar covers it, and went away with it
// by 57 px.
TEST_F(AHeldThing, ThatIsRestlessIsNotSaidToGoWithWhatCoversIt) {
  const Texture shade{30};
  const auto shaded = [&](Frame frame, int i) {
    const Frame over = shade.frame(kWidth, kHeight, {4.0 * i, 0});
    const double part = 0.36 - 0.36 * std::cos(2 * std::numbers::pi * i / 6);
    for (std::size_t at = 0; at < frame.pixels.size(); ++at)
      frame.pixels[at] = static_cast<std::uint8_t>(
          std::lround((1 - part) * frame.pixels[at] + part * over.pixels[at]));
    return frame;
  };
  take(shaded(stage.frame({}), 0));
  for (int i = 1; i <= 30; ++i)
    follow(shaded(stage.frame(sway(i / kRate, 8)), i));
  ASSERT_EQ(thing.report().state, HoldState::held);
  int about = 0;
  for (int i = 31; i <= 70; ++i) {
    const Shift shift = sway(i / kRate, 8);
    const HeldReport &report = follow(shaded(stage.frame(shift, kWidth - 5.0 * (i - 20)), i));
    about += report.state == HoldState::about;
    EXPECT_LT(distance(report, shift), 30) << i;
  }
  EXPECT_GE(about, 3);
}

TEST_F(AHeldThing, IsLostAfterThreeSeconds) {
  take(stage.frame({}));
  for (int i = 1; i <= 10; ++i)
    follow(stage.frame({}));
  const Frame empty = stage.ground.frame(kWidth, kHeight, {});
  for (int i = 1; i <= 89; ++i)
    ASSERT_EQ(follow(empty).state, HoldState::hidden) << i;
  for (int i = 1; i <= 3; ++i)
    follow(empty);
  EXPECT_EQ(thing.report().state, HoldState::lost);
  EXPECT_EQ(follow(stage.frame({})).state, HoldState::lost); // until it is pressed again
}

TEST_F(AHeldThing, ThatLeavesTheFrameIsLostAtThatBorder) {
  take(stage.frame({}));
  for (int i = 1; i <= 150; ++i)
    follow(stage.frame({std::min(4.0 * i, 400.0), 0}));
  EXPECT_EQ(thing.report().state, HoldState::lost);
  EXPECT_TRUE(std::isfinite(thing.report().x));
  EXPECT_TRUE(std::isfinite(thing.report().y));
}

TEST_F(AHeldThing, IsStillHeldInAnotherLight) {
  take(stage.frame({}));
  for (int i = 1; i <= 30; ++i) {
    Frame frame = stage.frame(sway(i / kRate, 6));
    const double gain = 1 - 0.4 * i / 30;
    for (std::uint8_t &pixel : frame.pixels)
      pixel = static_cast<std::uint8_t>(std::lround(gain * pixel));
    ASSERT_EQ(follow(frame).state, HoldState::held) << i;
  }
  EXPECT_LT(distance(thing.report(), sway(1, 6)), 0.3);
}

TEST_F(AHeldThing, IsLostAtACut) {
  take(stage.frame({}));
  thing.lose();
  EXPECT_EQ(thing.report().state, HoldState::lost);
}

// A press

TEST_F(AHeldThing, IsNothingAfterItIsReleased) {
  take(stage.frame({}));
  thing.release();
  EXPECT_EQ(thing.report().state, HoldState::none);
  EXPECT_EQ(follow(stage.frame({})).state, HoldState::none);
  thing.lose();
  EXPECT_EQ(thing.report().state, HoldState::none);
}

TEST_F(AHeldThing, IsRefusedWhereNothingCanBeSeen) {
  Frame sky(kWidth, kHeight);
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0, 1.5); // grey levels, of a camera
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      sky.at(x, y) = static_cast<std::uint8_t>(std::lround(150 + 0.1 * y + noise(random)));
  EXPECT_EQ(take(sky).state, HoldState::refused);
  EXPECT_EQ(follow(sky).state, HoldState::refused);
  EXPECT_EQ(take(Frame(kWidth, kHeight, 90)).state, HoldState::refused);
}

TEST_F(AHeldThing, OfManyThatLookTheSameIsFollowedAbout) {
  Frame stripes(kWidth, kHeight);
  const auto paint = [&](double shift) {
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        stripes.at(x, y) = static_cast<std::uint8_t>(
            std::lround(128 + 50 * std::sin((x - shift) / 2.5) * std::sin(y / 2.5)));
  };
  paint(0);
  EXPECT_EQ(take(stripes).state, HoldState::about);
  for (int i = 1; i <= 10; ++i) {
    paint(0.5 * i);
    EXPECT_EQ(follow(stripes).state, HoldState::about);
  }
  EXPECT_NEAR(thing.report().x, kMiddle.x + 5, 0.5);
}

/// A blade without texture before the ground, its upper end so far above the middle of the frame.
Frame blade_before(const Texture &ground, double shift, int above) {
  constexpr double kHalfWidth = 3; // px
  Frame frame = ground.frame(kWidth, kHeight, {});
  for (int y = static_cast<int>(kMiddle.y) - above; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double part =
          std::clamp(kHalfWidth + 0.5 - std::abs(x + 0.5 - kMiddle.x - shift), 0.0, 1.0);
      frame.at(x, y) =
          static_cast<std::uint8_t>(std::lround(part * 220 + (1 - part) * frame.at(x, y)));
    }
  return frame;
}

TEST_F(AHeldThing, ThatLooksTheSameAlongAnEdgeIsFollowedAboutButItsEndIsHeld) {
  const Texture ground(8, 6, 25);
  for (const int above : {60, 2}) {
    ASSERT_EQ(take(blade_before(ground, 0, above)).state, HoldState::held) << above;
    for (int i = 1; i <= 45; ++i) {
      const double shift = sway(i / kRate).x;
      const HeldReport &report = follow(blade_before(ground, shift, above));
      if (i > 20) { // the ground was seen to stay
        EXPECT_EQ(report.state, above > 10 ? HoldState::about : HoldState::held) << i;
      }
      EXPECT_NEAR(report.x, kMiddle.x + shift, 1) << above << ' ' << i;
    }
  }
}

TEST_F(AHeldThing, MayBeTakenAtAnyPlaceOfAnyFrame) {
  for (const auto &[width, height] :
       {std::pair{1, 1}, {3, 200}, {2048, 1}, {3840, 3}, {16, 16}, {kWidth, kHeight}}) {
    const Frame pixels = stage.disc.frame(width, height, {});
    const PlaneSource frame(pixels);
    for (const double x : {0.0, width / 2.0, static_cast<double>(width)})
      for (const double y : {0.0, height / 2.0, static_cast<double>(height)}) {
        thing.take(frame, width, height, static_cast<float>(x), static_cast<float>(y));
        for (int i = 0; i < 3; ++i)
          thing.follow(frame, 1 / static_cast<float>(kRate));
        EXPECT_TRUE(std::isfinite(thing.report().x)) << width << " " << x;
        EXPECT_TRUE(std::isfinite(thing.report().y)) << height << " " << y;
      }
  }
}

// Films of any speed and shape with noise, black, cuts, frames that repeat and times between them
// from a millisecond to a second.
TEST_F(AHeldThing, WhateverTheFilmDoesIsAtAFinitePlace) {
  constexpr int kFilms = 40;
  constexpr int kFrames = 40;
  std::mt19937 random(31);
  std::uniform_real_distribution<double> share(0, 1);
  const auto one_in = [&](unsigned count) { return random() % count == 0; };
  int seen = 0;
  for (int film = 0; film < kFilms; ++film) {
    const int width = 16 + static_cast<int>(random() % (film % 8 == 0 ? 700 : 200));
    const int height = 16 + static_cast<int>(random() % 200);
    const Texture scene(static_cast<unsigned>(random() % 100), 2 + static_cast<int>(random() % 12),
                        60 * share(random));
    const Shift by{20 * share(random) - 10, 20 * share(random) - 10};
    Frame frame = scene.frame(width, height, {});
    take(frame, {width * share(random), height * share(random)});
    for (int i = 1; i < kFrames; ++i) {
      frame = one_in(30) ? Frame(width, height, 0)
                         : scene.frame(width, height, {by.x * i * share(random), by.y * i});
      if (film % 3 == 0)
        test::add_noise(frame, 20 * share(random), random);
      if (one_in(40))
        thing.lose();
      const double rate = one_in(10) ? 1 + 1000 * share(random) : kRate;
      const HeldReport report = one_in(10)
                                    ? thing.rest(PlaneSource(frame), static_cast<float>(1 / rate))
                                    : follow(frame, rate);
      seen += report.state == HoldState::held || report.state == HoldState::about;
      ASSERT_TRUE(std::isfinite(report.x + report.y + report.radius + report.dx + report.dy +
                                report.variance))
          << film << ' ' << i;
      EXPECT_GE(report.radius, 0);
      EXPECT_GE(report.variance, 0);
    }
  }
  EXPECT_GT(seen, kFilms);
}

} // namespace held_thing_test
