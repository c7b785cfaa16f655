// SPDX-License-Identifier: LGPL-2.1-or-later
#include "array/array-drive.hpp"
#include "array/array-layout.hpp"
#include "array/array-mapping.hpp"
#include "array/array-voices.hpp"
#include "temporary-folder.hpp"

#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <sys/stat.h>

namespace array_test {

using haptic::ArrayLayout;
using haptic::ArrayVoices;
using haptic::SkinMap;
using haptic::SkinPlace;
using haptic::Stroke;

constexpr const char *kBuiltin[] = {"back-3x4", "ring-8", "shakers-2", "coils-2"};
constexpr int kRate = 48000;

double sum(std::span<const double> numbers) {
  return std::accumulate(numbers.begin(), numbers.end(), 0.0);
}

SkinPlace centroid(const SkinMap &map, std::span<const double> shares) {
  SkinPlace centre = SkinPlace::Zero();
  for (std::size_t i = 0; i < shares.size(); ++i)
    centre += shares[i] * map.places()[i];
  return centre;
}

// A jacket: 64 actuators in no order.
ArrayLayout jacket() {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.3, 0.3);
  ArrayLayout layout;
  for (int i = 0; i < 64; ++i)
    layout.actuators.push_back({place(random), place(random), 160, 1});
  return layout;
}

std::vector<ArrayLayout> layouts() {
  std::vector<ArrayLayout> all = {jacket()};
  for (const char *name : kBuiltin)
    all.push_back(haptic::load_array_layout(name));
  return all;
}

// Layout files

class LayoutFile : public ::testing::Test {
protected:
  // The message of the refusal; empty if the file is read.
  std::string refusal(const std::string &text) const {
    const std::string path = ::testing::TempDir() + "array-layout-test.ini";
    std::ofstream(path) << text;
    try {
      haptic::load_array_layout(path);
    } catch (const std::runtime_error &error) {
      return error.what();
    }
    return "";
  }
  static bool has(const std::string &text, const char *part) {
    return text.find(part) != std::string::npos;
  }
  static constexpr char kHead[] = "[array]\nunit=mm\ncarrier=100\n";
  static constexpr char kTwo[] = "[actuator-1]\nx=0\ny=0\n[actuator-2]\nx=5\ny=0\n";
};

TEST_F(LayoutFile, TheBuiltInOnesAreRead) {
  EXPECT_EQ(haptic::load_array_layout("back-3x4").actuators.size(), 12U);
  EXPECT_EQ(haptic::load_array_layout("ring-8").actuators.size(), 8U);
  const ArrayLayout coils = haptic::load_array_layout("coils-2");
  EXPECT_EQ(coils.actuators[0].x, -0.06);
  EXPECT_EQ(coils.actuators[0].carrier, 180);
  EXPECT_EQ(coils.actuators[0].gain, 1);
}

TEST_F(LayoutFile, AnActuatorMayHaveItsOwnCarrierAndGain) {
  EXPECT_EQ(refusal(std::string(kHead) + kTwo + "carrier=60\ngain=0.5\n"), "");
}

TEST_F(LayoutFile, WhatIsWrongIsNamedWithItsCure) {
  const std::string head = kHead;
  const std::string two = kTwo;
  EXPECT_TRUE(has(refusal(head + "[actuator-1]\nx=0\ny=0\n"), "has 1 actuators"));
  std::string many = head;
  for (int i = 1; i <= 65; ++i)
    many += "[actuator-" + std::to_string(i) + "]\nx=" + std::to_string(10 * i) + "\ny=0\n";
  EXPECT_TRUE(has(refusal(many), "has 65 actuators"));
  EXPECT_TRUE(
      has(refusal(head + two + "[actuator-3]\nx=5.5\ny=0\n"), "2 and 3 are at the same place"));
  EXPECT_TRUE(has(refusal("[array]\ncarrier=100\n" + two), "no unit"));
  EXPECT_TRUE(has(refusal("[array]\nunit=mm\n" + two), "[actuator-1] has no carrier"));
  EXPECT_TRUE(has(refusal(head + "[actuator-1]\nx=0\n"), "[actuator-1] has no y"));
  EXPECT_TRUE(has(refusal(head + two + "[actuator-4]\nx=9\ny=0\n"), "[actuator-4] has an unknown"));
  EXPECT_TRUE(has(refusal(head + two + "pitch=1\n"), "unknown key, pitch"));
  EXPECT_TRUE(has(refusal(head + "[actuator-1]\nx=nan\ny=0\n"), "x=nan is not a number"));
  EXPECT_TRUE(
      has(refusal("[array]\nunit=mm\ncarrier=9000\n" + two), "carrier=9000 is not a number"));
  EXPECT_TRUE(has(refusal("not a layout"), "cannot be read"));
  EXPECT_THROW(haptic::load_array_layout("jacket"), std::runtime_error);
  EXPECT_THROW(haptic::load_array_layout("/nowhere/jacket.ini"), std::runtime_error);
}

TEST_F(LayoutFile, AFifoIsRefusedAndNotWaitedFor) {
  const test::TemporaryFolder folder;
  const std::string fifo = folder.path_of("fifo.ini");
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_THROW(haptic::load_array_layout(fifo), std::runtime_error);
}

// Places

TEST(SkinMap, TheEnergyIsOneAndItsCentroidIsThePlaceOnAnyStraightPath) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const ArrayLayout &layout : layouts()) {
    const SkinMap map(layout);
    std::vector<double> shares(layout.actuators.size());
    int inside = 0;
    for (int path = 0; path < 50; ++path) {
      const Eigen::Vector2d size = map.highest() - map.lowest();
      const auto anywhere = [&]() -> SkinPlace {
        return map.lowest() + size.cwiseProduct(Eigen::Vector2d(unit(random), unit(random)));
      };
      const SkinPlace from = anywhere();
      const SkinPlace to = anywhere();
      for (double at = 0; at <= 1; at += 1.0 / 64) {
        const SkinPlace place = from + at * (to - from);
        map.share_energy(place, shares);
        EXPECT_NEAR(sum(shares), 1, 1e-9);
        EXPECT_GE(*std::ranges::min_element(shares), 0);
        if (!map.contains(place))
          continue;
        ++inside;
        EXPECT_LE((centroid(map, shares) - place).norm(), 1e-6 * map.spacing());
      }
    }
    EXPECT_GT(inside, 1000);
  }
}

TEST(SkinMap, AnActuatorAloneIsFeltAtItsPlaceAndTheBorderOutside) {
  const SkinMap map(haptic::load_array_layout("back-3x4"));
  std::vector<double> shares(12);
  map.share_energy(map.places()[4], shares);
  EXPECT_NEAR(shares[4], 1, 1e-9);
  map.share_energy({-1, 0.15}, shares); // left of the first row
  EXPECT_NEAR(shares[0], 1, 1e-9);
  map.share_energy({0.05, 1}, shares); // above, between columns 2 and 3
  EXPECT_NEAR(shares[1], 0.5, 1e-9);
  EXPECT_NEAR(shares[2], 0.5, 1e-9);
}

TEST(SkinMap, NoPlaceOfAGridIsLeftOut) {
  const SkinMap map(haptic::load_array_layout("back-3x4"));
  for (double x = -0.1; x <= 0.1; x += 0.004)
    for (double y = -0.15; y <= 0.15; y += 0.004)
      EXPECT_TRUE(map.contains({x, y})) << x << ", " << y;
}

// Strokes

TEST(Stroke, RunsAcrossTheArrayInTheDirectionOfTheMotionWithConstantEnergy) {
  constexpr double kStep = 0.001; // s
  for (const ArrayLayout &layout : layouts()) {
    const SkinMap map(layout);
    std::vector<double> shares(layout.actuators.size());
    for (const Eigen::Vector2d &velocity :
         {Eigen::Vector2d(0.5, 0), {-0.3, 0.3}, {0.1, -0.8}, {3, 0}}) {
      Stroke stroke(map);
      double forward = 0;
      double back = 0;
      for (int i = 0; i < 5000; ++i) {
        const SkinPlace before = stroke.place();
        stroke.step(velocity, kStep, shares);
        EXPECT_NEAR(sum(shares), 1, 0.01);
        const double moved = (stroke.place() - before).dot(velocity.normalized());
        (moved > 0 ? forward : back) += std::abs(moved) > 0 ? 1 : 0;
      }
      EXPECT_GT(forward, 3000);
      EXPECT_GT(back, 0); // it comes in again
      EXPECT_LT(back, 50);
    }
  }
}

TEST(Stroke, TheOnsetsOfNeighboursAreFarEnoughApart) {
  const SkinMap map(haptic::load_array_layout("shakers-2"));
  Stroke stroke(map);
  std::vector<double> shares(2);
  const SkinPlace before = stroke.place();
  stroke.step({100, 0}, 0.001, shares);
  const double onset = map.spacing() / ((stroke.place() - before).norm() / 0.001);
  EXPECT_NEAR(onset, 0.32 * 2 * onset + 0.0473, 1e-6);
}

TEST(Stroke, RestsWhenNothingMoves) {
  const SkinMap map(haptic::load_array_layout("ring-8"));
  Stroke stroke(map);
  std::vector<double> shares(8);
  const SkinPlace before = stroke.place();
  stroke.step({0, 0}, 1, shares);
  EXPECT_EQ(stroke.place(), before);
}

// Vibrations

// A damaged sample. The noise beside its speed would be felt for seconds.
TEST(ArrayDrive, ASpeedThatIsNoneIsForgottenAtOnce) {
  haptic::ArrayDrive drive(haptic::load_array_layout("ring-8"));
  const haptic::DriveSettings settings{.map = haptic::MapChoice::point};
  haptic::MotionSample sample;
  sample.frame_width = 352;
  sample.frame_height = 288;
  sample.confidence = 1;
  std::vector<double> amplitudes(8);
  const auto felt_at = [&](float speed) {
    sample.velocity_x = speed; // px/s
    drive.follow(sample, settings);
    for (int step = 0; step < 100; ++step)
      drive.step(0.01, settings, amplitudes);
    return sum(amplitudes);
  };
  EXPECT_GT(felt_at(100), 0.5);
  EXPECT_EQ(felt_at(1e30F), 0);
  EXPECT_EQ(felt_at(2), 0);
}

TEST(ArrayDrive, AnotherMapAndBackFeelsNothingOfBefore) {
  haptic::ArrayDrive drive(haptic::load_array_layout("ring-8"));
  haptic::MotionField field;
  field.frame_width = 352;
  field.frame_height = 288;
  field.columns = 32;
  field.rows = 26;
  field.interval = 33'333'333; // ns
  std::vector<double> amplitudes(8);
  const auto felt = [&](haptic::MapChoice map) {
    for (int step = 0; step < 100; ++step)
      drive.step(0.01, {.map = map}, amplitudes);
    return sum(amplitudes);
  };
  const auto follow = [&](haptic::MapChoice map, float speed) {
    field.cells.assign(32 * 26, {.velocity_x = speed, .confidence = 1});
    drive.follow(field, {.map = map});
  };
  follow(haptic::MapChoice::field, 100);
  EXPECT_GT(felt(haptic::MapChoice::field), 0.5);
  follow(haptic::MapChoice::stroke, 0);
  EXPECT_EQ(felt(haptic::MapChoice::stroke), 0);
  EXPECT_EQ(felt(haptic::MapChoice::field), 0);
}

class Voices : public ::testing::Test {
protected:
  void run(const std::vector<double> &wanted, int steps, const haptic::VoiceLimits &limits = {}) {
    std::vector<float> frames(static_cast<std::size_t>(ArrayVoices::kStep) * wanted.size());
    for (int i = 0; i < steps; ++i) {
      voices.make(wanted, limits, frames);
      sound.insert(sound.end(), frames.begin(), frames.end());
    }
  }
  float highest() const {
    float highest = 0;
    for (const float sample : sound)
      highest = std::max(highest, std::abs(sample));
    return highest;
  }

  ArrayLayout layout = haptic::load_array_layout("coils-2");
  ArrayVoices voices{layout, kRate};
  std::vector<float> sound; // interleaved
};

TEST_F(Voices, SilenceIsDigitalZeroAndIsReachedAgain) {
  run({0, 0}, 10);
  EXPECT_EQ(highest(), 0);
  run({1, 0.5}, 30);
  EXPECT_GT(highest(), 0.9F);
  run({0, 0}, 20);
  EXPECT_TRUE(voices.silent());
  sound.clear();
  run({0, 0}, 1);
  EXPECT_EQ(highest(), 0);
}

TEST_F(Voices, NoSampleJumpsFartherThanTheCarrierDoes) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-0.5, 1.5);
  for (int i = 0; i < 500; ++i)
    run({unit(random), unit(random)}, 3);
  const double slope = 2 * std::numbers::pi * layout.actuators[0].carrier / kRate;
  for (std::size_t i = 2; i < sound.size(); ++i)
    ASSERT_LE(std::abs(sound[i] - sound[i - 2]), slope) << i;
}

TEST_F(Voices, TheAmplitudeStaysWithinTheLevelAndItsSlew) {
  run({5, std::numeric_limits<double>::quiet_NaN()}, 100, {.level = 0.4});
  EXPECT_NEAR(highest(), 0.4, 0.01);
  for (std::size_t i = 1; i < sound.size(); i += 2)
    ASSERT_EQ(sound[i], 0);
}

TEST_F(Voices, TheBudgetLimitsWhatLastsForAMinute) {
  constexpr double kBudget = 0.3;
  double squares = 0;
  constexpr int kSteps = 60 * kRate / ArrayVoices::kStep;
  for (int i = 0; i < kSteps; ++i) {
    sound.clear();
    run({1, 0}, 1, {.continuous_level = kBudget});
    squares += 2 * static_cast<double>(sound[0]) * sound[0]; // of the carrier's amplitude
  }
  EXPECT_LE(std::sqrt(squares / kSteps), 1.02 * kBudget);
  EXPECT_GE(std::sqrt(squares / kSteps), 0.9 * kBudget);
}

TEST_F(Voices, AnotherRateHasNoNewBudgetAndNoClick) {
  constexpr haptic::VoiceLimits kLimits = {.continuous_level = 0.3};
  run({1, 1}, 60 * kRate / ArrayVoices::kStep, kLimits);
  sound.clear();
  run({1, 1}, 10, kLimits);
  const float before = highest();
  voices.set_rate(kRate / 2);
  sound.clear();
  run({1, 1}, 10, kLimits);
  EXPECT_NEAR(highest(), before, 0.05F * before);
}

TEST_F(Voices, FullScaleTakesTwentyMilliseconds) {
  run({1, 1}, 14); // 18.7 ms
  EXPECT_LT(highest(), 0.95F);
  run({1, 1}, 10);
  EXPECT_NEAR(highest(), 1, 0.001);
}

TEST_F(Voices, TheCarrierKeepsItsAmplitude) {
  run({1, 1}, 100000); // two minutes
  sound.erase(sound.begin(), sound.end() - 2L * kRate);
  EXPECT_NEAR(highest(), 1, 0.001);
}

} // namespace array_test
