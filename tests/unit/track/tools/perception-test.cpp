// SPDX-License-Identifier: LGPL-2.1-or-later
// The model of haptic-track compare on gusts: identity, symmetry, and growth with each kind of
// change.
#include "felt/perception.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace perception_test {

using haptic::Comparison;
using haptic::Force;
using haptic::ForceSignal;

constexpr std::int64_t kSteps = 10'000;
constexpr unsigned kSeeds = 5;

// A wind between 0.2 and 4 Hz, rms 0.3 N on each axis or so, with a calm of a second.
ForceSignal gusts(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  ForceSignal signal;
  signal.forces.resize(kSteps);
  for (float Force::*axis : {&Force::x, &Force::y})
    for (int wave = 0; wave < 6; ++wave) {
      const double frequency = 0.2 * std::pow(20, unit(random)); // Hz
      const double phase = 2 * std::numbers::pi * unit(random);
      for (std::size_t i = 0; i < signal.forces.size(); ++i) {
        const double time = static_cast<double>(i) * haptic::kForceStep;
        signal.forces[i].*axis +=
            static_cast<float>(0.17 * std::sin(2 * std::numbers::pi * frequency * time + phase));
      }
    }
  std::fill_n(signal.forces.begin() + 4000, 1000, Force{});
  return signal;
}

Comparison compare_signals(std::size_t places, const haptic::SignalsAt &signals_at) {
  return haptic::compare_at(haptic::best_shift(places, signals_at), places, signals_at);
}

Comparison compare(const ForceSignal &a, const ForceSignal &b) {
  return compare_signals(1, [&](std::size_t) { return haptic::SignalPair(a, b); });
}

ForceSignal delayed(ForceSignal signal, std::int64_t steps) {
  signal.first += steps;
  return signal;
}

ForceSignal rotated(ForceSignal signal, double degrees) {
  const double angle = degrees / 180 * std::numbers::pi;
  for (Force &force : signal.forces)
    force = {static_cast<float>(std::cos(angle) * force.x - std::sin(angle) * force.y),
             static_cast<float>(std::sin(angle) * force.x + std::cos(angle) * force.y), force.z};
  return signal;
}

ForceSignal scaled(ForceSignal signal, double gain) {
  for (Force &force : signal.forces)
    force = {static_cast<float>(gain * force.x), static_cast<float>(gain * force.y), force.z};
  return signal;
}

// Noise of a tracker: new for each frame, linear between.
ForceSignal noisy(ForceSignal signal, double newtons, unsigned seed) {
  constexpr std::size_t kFrame = 33;
  std::mt19937 random(seed + 1000);
  std::normal_distribution<float> noise;
  Force from;
  Force to;
  for (std::size_t i = 0; i < signal.forces.size(); ++i) {
    if (i % kFrame == 0) {
      from = to;
      to = {noise(random), noise(random), 0};
    }
    const float share = static_cast<float>(i % kFrame) / kFrame;
    const auto size = static_cast<float>(newtons);
    signal.forces[i].x += size * std::lerp(from.x, to.x, share);
    signal.forces[i].y += size * std::lerp(from.y, to.y, share);
  }
  return signal;
}

// Silent for a share of the time, in the middle.
ForceSignal silenced(ForceSignal signal, double share) {
  const auto steps = static_cast<std::ptrdiff_t>(share * kSteps);
  std::fill_n(signal.forces.begin() + (kSteps - steps) / 2, steps, Force{});
  return signal;
}

// The share never falls by more than `slack`, and grows to most of what is felt.
template <typename Change>
void expect_growth(const std::vector<double> &amounts, const Change &change, double slack = 0) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const ForceSignal signal = gusts(seed);
    double before = 0;
    for (const double amount : amounts) {
      const Comparison result = compare(signal, change(signal, amount, seed));
      EXPECT_GE(result.all.distinguishable, before - slack) << amount << ", seed " << seed;
      before = result.all.distinguishable;
    }
    EXPECT_GT(before, 0.7) << "seed " << seed;
  }
}

TEST(Perception, NobodyTellsASignalFromItself) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const ForceSignal signal = gusts(seed);
    const Comparison result = compare(signal, signal);
    EXPECT_EQ(result.all.distinguishable, 0);
    EXPECT_EQ(result.shift, 0);
    EXPECT_EQ(result.all.force_rms, 0);
    EXPECT_GT(result.all.felt, 0.7);
    EXPECT_LT(result.all.felt, 0.92) << "the calm is not felt";
  }
}

TEST(Perception, TheOrderOfTwoSignalsDoesNotMatter) {
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const ForceSignal a = gusts(seed);
    for (const ForceSignal &b :
         {noisy(a, 0.1, seed), delayed(a, 17), delayed(a, 170), rotated(a, 60), scaled(a, 1.5),
          silenced(a, 0.3), gusts(seed + 100)}) {
      const Comparison there = compare(a, b);
      const Comparison back = compare(b, a);
      EXPECT_EQ(there.all.distinguishable, back.all.distinguishable) << seed;
      EXPECT_EQ(there.all.felt, back.all.felt) << seed;
      EXPECT_EQ(there.shift, -back.shift) << seed;
      EXPECT_DOUBLE_EQ(there.all.force_rms, back.all.force_rms) << seed;
    }
  }
}

TEST(Perception, NoiseIsToldApartTheMoreThereIs) {
  expect_growth({0, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64},
                [](const ForceSignal &signal, double newtons, unsigned seed) {
                  return noisy(signal, newtons, seed);
                });
}

TEST(Perception, AGainIsToldApartTheMoreThereIs) {
  const auto change = [](const ForceSignal &signal, double gain, unsigned) {
    return scaled(signal, gain);
  };
  expect_growth({1, 1.03, 1.06, 1.1, 1.15, 1.3, 2, 4}, change);
  expect_growth({1, 0.97, 0.9, 0.8, 0.5, 0.2, 0}, change);
}

// A wind that is turned far may fit better when it is shifted far; then the calms do not coincide.
TEST(Perception, ARotationIsToldApartTheMoreThereIs) {
  expect_growth(
      {0, 5, 10, 15, 17, 20, 30, 60, 90, 180},
      [](const ForceSignal &signal, double degrees, unsigned) { return rotated(signal, degrees); },
      0.05);
}

TEST(Perception, ADelayIsToldApartFrom45MillisecondsOn) {
  expect_growth({0, 10, 30, 45, 46, 60, 100, 300, 1000},
                [](const ForceSignal &signal, double ms, unsigned) {
                  return delayed(signal, std::llround(ms));
                });
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    const ForceSignal signal = gusts(seed);
    for (const std::int64_t ms : {-300, -46, -45, -1, 1, 45, 46, 300}) {
      const Comparison result = compare(signal, delayed(signal, ms));
      EXPECT_DOUBLE_EQ(result.shift, static_cast<double>(ms) / 1000) << "seed " << seed;
      if (std::abs(ms) <= 45)
        EXPECT_EQ(result.all.distinguishable, 0) << ms;
      else
        EXPECT_EQ(result.all.distinguishable, result.all.felt) << ms;
    }
  }
}

TEST(Perception, MissingForceIsFelt) {
  expect_growth({0, 0.1, 0.2, 0.4, 0.8, 1}, [](const ForceSignal &signal, double share, unsigned) {
    return silenced(signal, share);
  });
  ForceSignal half = gusts(1);
  half.forces.resize(kSteps / 4);
  const Comparison result = compare(gusts(1), half);
  EXPECT_EQ(result.end - result.first, kSteps) << "all of the longer one counts";
  EXPECT_GT(result.all.distinguishable, 0.7 * result.all.felt);
}

TEST(Perception, TheShiftIsThatOfAllPlacesTogether) {
  const Comparison result = compare_signals(3, [](std::size_t place) {
    const ForceSignal signal = place == 0 ? ForceSignal{0, std::vector<Force>(kSteps)}
                                          : gusts(static_cast<unsigned>(place));
    return haptic::SignalPair(signal, delayed(place == 2 ? scaled(signal, 2) : signal, 20));
  });
  EXPECT_DOUBLE_EQ(result.shift, 0.02);
  ASSERT_EQ(result.places.size(), 3U);
  EXPECT_EQ(result.places[0].felt, 0);
  EXPECT_EQ(result.places[1].distinguishable, 0);
  EXPECT_GT(result.places[2].distinguishable, 0.9 * result.places[2].felt);
  EXPECT_NEAR(result.all.distinguishable, result.places[2].distinguishable / 3, 1e-9);
}

TEST(Perception, TheThresholdsAreThoseOfThePage) {
  const auto along = [](double newtons, double degrees) {
    const double angle = degrees / 180 * std::numbers::pi;
    return Force{static_cast<float>(newtons * std::cos(angle)),
                 static_cast<float>(newtons * std::sin(angle)), 0};
  };
  EXPECT_FALSE(differ(along(0.2, 0), along(0.229, 0)));
  EXPECT_TRUE(differ(along(0.2, 0), along(0.231, 0)));
  EXPECT_FALSE(differ(along(1, 0), along(1.074, 0)));
  EXPECT_TRUE(differ(along(1, 0), along(1.077, 0)));
  EXPECT_FALSE(differ(along(0.06, 0), along(0.06, 18.3)));
  EXPECT_TRUE(differ(along(0.06, 0), along(0.06, 18.5)));
  EXPECT_FALSE(differ(along(0.04, 0), along(0.04, 40)));
  EXPECT_TRUE(differ(along(0.04, 0), along(0.04, 180)));
  EXPECT_FALSE(differ(along(0.029, 0), along(0.029, 180))) << "neither is felt";
}

} // namespace perception_test
