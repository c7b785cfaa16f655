// SPDX-License-Identifier: LGPL-2.1-or-later
// What the hand feels of a frame 30 times a second, in numbers.
#include "leaf-motion.hpp"
#include "motion/cadence.hpp"
#include "spectrum.hpp"

#include <algorithm>
#include <gtest/gtest.h>

namespace force_smoothness_test {

using test::Leaf;

constexpr double kSeconds = 20;
constexpr std::size_t kBegin = 1000; // ms; the fade-in is over
constexpr double kNoise = 0.1;       // px, of a good tracker

std::span<const double> settled(const std::vector<double> &forces) {
  return std::span(forces).subspan(kBegin);
}

double largest_step(std::span<const double> forces) {
  double step = 0;
  for (std::size_t i = 1; i < forces.size(); ++i)
    step = std::max(step, std::abs(forces[i] - forces[i - 1]));
  return step;
}

// ms by which the forces follow the true one.
int lag(const std::vector<double> &forces) {
  int best = 0;
  double least = 1e9;
  for (int shift = -100; shift <= 150; ++shift) {
    double error = 0;
    for (std::size_t i = kBegin; i < forces.size() - 200; ++i)
      error += std::pow(forces[i] - Leaf::force(0.001 * (static_cast<double>(i) - shift)), 2);
    if (error < least) {
      least = error;
      best = shift;
    }
  }
  return best;
}

TEST(ForceSmoothness, AFilmIsFeltWithoutBuzz) {
  const auto forces = test::feel(test::film_leaf(30, kSeconds, 1.5, kNoise), kSeconds);
  EXPECT_LE(test::energy_above_db(settled(forces), 1000, 20), -40);
  EXPECT_LE(largest_step(settled(forces)), 0.02 + 1e-9);
}

TEST(ForceSmoothness, ACameraIsFeltWithoutBuzz) {
  const auto forces = test::feel(test::film_leaf(30, kSeconds, {}, kNoise), kSeconds);
  EXPECT_LE(test::energy_above_db(settled(forces), 1000, 20), -40);
  EXPECT_LE(largest_step(settled(forces)), 0.02 + 1e-9);
}

TEST(ForceSmoothness, SmoothHzTakesSomeMoreOfIt) {
  const auto forces =
      test::feel(test::film_leaf(30, kSeconds, 1.5, kNoise), kSeconds, {.smooth_hz = 12});
  EXPECT_LE(test::energy_above_db(settled(forces), 1000, 20), -45);
}

TEST(ForceSmoothness, TheForceOfAFilmCoincidesWithTheFrame) {
  const auto forces = test::feel(test::film_leaf(30, kSeconds, 1.5), kSeconds);
  EXPECT_LE(std::abs(lag(forces)), 1);
  for (std::size_t i = kBegin; i < forces.size() - 100; ++i)
    ASSERT_NEAR(forces[i], Leaf::force(0.001 * static_cast<double>(i)), 0.06) << i;
}

TEST(ForceSmoothness, TheForceOfACameraIsOneAndAHalfFramesLate) {
  for (const double fps : {25.0, 30.0, 60.0})
    EXPECT_LE(lag(test::feel(test::film_leaf(fps, kSeconds, {}), kSeconds)), 1500 / fps + 2) << fps;
}

TEST(ForceSmoothness, SamplesThatComeLessThanEnoughAheadAreNoStepsEither) {
  for (const double look_ahead : {0.0, 0.4, 0.5, 0.6, 1.0, 1.4}) {
    const auto forces = test::feel(test::film_leaf(30, kSeconds, look_ahead), kSeconds);
    EXPECT_LE(test::energy_above_db(settled(forces), 1000, 20), -40) << look_ahead;
    EXPECT_LE(largest_step(settled(forces)), 0.0201) << look_ahead;
  }
}

TEST(ForceSmoothness, TheSameMotionIsTheSameForceAtEveryFrameRate) {
  for (const double fps : {5.0, 25.0, 60.0}) {
    std::vector<test::Shown> frames;
    for (double pts = 1 / fps; pts < 3; pts += 1 / fps)
      frames.push_back({test::seen(100, 1 / fps), std::llround(pts * 1e9)});
    EXPECT_NEAR(test::feel(frames, 3).back(), 0.5, 0.5 * 0.05) << fps;
  }
}

TEST(ForceSmoothness, AFrameRateThatJumpsIsNotFelt) {
  std::vector<test::Shown> frames;
  std::vector<double> jumps; // s
  double pts = 0;
  for (const double fps : {25.0, 60.0, 5.0, 25.0}) {
    jumps.push_back(pts);
    while (pts < jumps.back() + 2) {
      pts += 1 / fps;
      frames.push_back({test::seen(100, 1 / fps), std::llround(pts * 1e9)});
    }
  }
  const auto forces = test::feel(frames, 7.9);
  for (const double jump :
       jumps) // a source that has become slow seems to have stopped for a moment
    for (double t = jump + 0.4; t < std::min(jump + 1.9, 7.9); t += 0.001)
      ASSERT_NEAR(forces[static_cast<std::size_t>(t * 1000)], 0.5, 0.5 * 0.05) << t;
  EXPECT_LE(largest_step(forces), 0.02 + 1e-9);
}

// 24 frames a second of an even motion, carried in 30: the fourth of each is shown twice.
std::vector<test::Shown> pulldown(bool corrected) {
  std::vector<test::Shown> frames;
  haptic::Cadence cadence;
  int film_before = -1;
  int video_before = 0;
  for (int video = 1; video < 600; ++video) {
    const int film = video * 4 / 5;
    const double interval = (video - video_before) / 30.0;
    auto sample = test::seen(100 * (film - film_before) / 24.0 / interval, interval);
    if (film == film_before) {
      sample = frames.back().sample; // velocityavg repeats the motion
      sample.flags = haptic::kMotionDuplicate;
    } else {
      film_before = film;
      video_before = video;
    }
    const double correction = cadence.correction(sample);
    if (corrected)
      sample.velocity_x *= static_cast<float>(correction);
    if (!(sample.flags & haptic::kMotionDuplicate))
      frames.push_back({sample, std::llround(video / 30.0 * 1e9)});
  }
  return frames;
}

TEST(ForceSmoothness, FilmInVideoDoesNotPulse) {
  const auto plain = test::feel(pulldown(false), kSeconds);
  const auto forces = test::feel(pulldown(true), kSeconds);
  const double before = test::line_amplitude(settled(plain), 1000, 6);
  const double after = test::line_amplitude(settled(forces), 1000, 6);
  EXPECT_GT(before, 0.02); // N: there was something to correct
  EXPECT_LE(20 * std::log10(after / before), -30);
  EXPECT_LE(20 * std::log10(after / 0.5), -30);
  EXPECT_NEAR(forces.back(), 0.5, 0.5 * 0.05);
}

TEST(Cadence, UnevenTimeStampsWithoutARepeatedFrameAreTrue) {
  haptic::Cadence cadence;
  for (int i = 0; i < 100; ++i)
    EXPECT_EQ(cadence.correction(test::seen(100, i % 2 ? 0.04 : 0.08)), 1);
}

TEST(Cadence, FindsEveryUsualPattern) {
  // film and video, frames/s
  const std::pair<int, int> kPatterns[] = {{24, 30}, {24, 60}, {25, 30},
                                           {12, 30}, {15, 30}, {24, 25}};
  for (const auto &[film_rate, video_rate] : kPatterns) {
    haptic::Cadence cadence;
    int film_before = 0;
    int video_before = 0;
    double corrected = 0;
    for (int video = 1; video < 300; ++video) {
      const int film = video * film_rate / video_rate;
      const double interval = static_cast<double>(video - video_before) / video_rate;
      auto sample = test::seen(1, interval);
      if (film == film_before)
        sample.flags = haptic::kMotionDuplicate;
      const double correction = cadence.correction(sample);
      if (film == film_before)
        continue;
      corrected = static_cast<double>(film - film_before) / film_rate / interval * correction;
      film_before = film;
      video_before = video;
      if (video > 200) {
        ASSERT_NEAR(corrected, 1, 0.02) << film_rate << " in " << video_rate << " at " << video;
      }
    }
  }
}

} // namespace force_smoothness_test
