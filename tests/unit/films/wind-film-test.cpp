// SPDX-License-Identifier: LGPL-2.1-or-later
// The film of the demonstration: its true motion is what the trackers find, and its tree is felt.
#include "field-frames.hpp"
#include "motion/motion-conditioning.hpp"
#include "region-tracking.hpp"
#include "samples/force-defaults.hpp"
#include "scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>

namespace wind_film_test {

constexpr double kInterval = 1.0 / 60; // s

// A frame of the film, its luma, and its true motion.
class Film {
public:
  Film(int width, int height)
      : scene(width, height, 1), luma(width, height), canvas_(width, height) {}

  const test::Frame &draw(double time) {
    std::vector<std::uint8_t> planes(static_cast<std::size_t>(luma.width) * luma.height * 3 / 2);
    scene.draw(canvas_, time, kInterval);
    canvas_.write_i420(planes);
    std::copy_n(planes.begin(), luma.pixels.size(), luma.pixels.begin());
    return luma;
  }
  // px per frame
  std::vector<haptic::FieldCell> motion(const haptic::FieldShape &shape) const {
    haptic::MotionField field;
    field.columns = static_cast<std::uint16_t>(shape.columns);
    field.rows = static_cast<std::uint16_t>(shape.rows);
    canvas_.field_of(1'000'000'000, field);
    return field.cells;
  }
  // Mean of a region, px per frame
  haptic::FieldCell motion(const haptic::Rectangle &region) const {
    const film::Point moved =
        canvas_.mean_motion(region.x, region.y, region.x + region.width, region.y + region.height);
    return {moved.x, moved.y, 1};
  }

  film::Scene scene;
  test::Frame luma;

private:
  film::Canvas canvas_;
};

double distance(const haptic::FieldCell &a, const haptic::FieldCell &b) {
  return std::hypot(static_cast<double>(a.velocity_x - b.velocity_x),
                    static_cast<double>(a.velocity_y - b.velocity_y));
}

double length(const haptic::FieldCell &cell) {
  return distance(cell, {});
}

double quantile(std::vector<double> &values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

TEST(WindFilm, MotionfieldAgreesWithTheTrueMotionWhereItIsConfident) {
  constexpr int kFrames = 5;       // of each run; the first ones teach the field the noise
  constexpr double kMoving = 0.15; // px per frame
  Film film(640, 360);
  std::vector<double> of_all;
  std::vector<double> of_moving;
  for (const double start : {2.0, 5.0, 9.0, 14.0}) {
    test::Field field(640, 360);
    for (int i = 0; i < kFrames; ++i)
      field.follow(film.draw(start + i * kInterval));
    const std::vector<haptic::FieldCell> truth = film.motion(field.shape);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (field.cells[i].confidence < 0.5F)
        continue;
      of_all.push_back(distance(field.cells[i], truth[i]));
      if (length(truth[i]) > kMoving)
        of_moving.push_back(of_all.back());
    }
  }
  ASSERT_GT(of_all.size(), 2000U);
  ASSERT_GT(of_moving.size(), 300U);
  EXPECT_LE(quantile(of_all, 0.5), 0.15);
  EXPECT_LE(quantile(of_all, 0.9), 0.4);
  EXPECT_LE(quantile(of_moving, 0.5), 0.2);
  EXPECT_LE(quantile(of_moving, 0.9), 0.6);
  std::printf("px per frame: median %.3f, p90 %.3f; where it moves %.3f, %.3f\n",
              quantile(of_all, 0.5), quantile(of_all, 0.9), quantile(of_moving, 0.5),
              quantile(of_moving, 0.9));
}

// Regions of the default size, side by side in the crown.
std::vector<haptic::Rectangle> hands_in_crown(const film::Scene &scene, int width, int height) {
  const int side = static_cast<int>(std::lround(haptic::default_region_side(width)));
  std::vector<haptic::Rectangle> hands;
  for (int y = side; y < height; y += side)
    for (int x = side; x < width; x += side)
      if (scene.is_crown(static_cast<float>(x), static_cast<float>(y)))
        hands.push_back({x - side / 2, y - side / 2, side, side});
  return hands;
}

// N, after the deadband, with the `alpha` of the demonstration. `speed` in px/s.
double force_of(double speed, int width) {
  haptic::Motion motion;
  motion.velocity.x = speed * haptic::kReferenceWidth / width;
  const double felt = haptic::MotionConditioner().step(motion, 0, 1e-3).velocity.x;
  return haptic::arctan_gain(felt, WIND_ALPHA, 1) * felt;
}

TEST(WindFilm, AHandAnywhereInTheCrownFeelsItAtLeastHalfOfTheTime) {
  constexpr int kWidth = 480;
  constexpr int kHeight = 270;
  Film film(kWidth, kHeight);
  const auto tracker = haptic::make_fast_tracker();
  const std::vector<haptic::Rectangle> hands = hands_in_crown(film.scene, kWidth, kHeight);
  ASSERT_GT(hands.size(), 10U);
  std::vector<int> felt(hands.size());
  std::vector<double> differences;
  int frames = 0;
  for (double time = 0.2; time < 20; time += 0.35, ++frames) {
    test::Frame before = film.draw(time - kInterval);
    test::Frame after = film.draw(time);
    for (std::size_t i = 0; i < hands.size(); ++i) {
      haptic::Measurement found;
      tracker->measure(test::crop_pair(before, after, hands[i], *tracker), found);
      const auto motion = test::estimate(found, hands[i]);
      if (motion.confidence < 0.5F)
        continue;
      const haptic::FieldCell cell{motion.velocity_x, motion.velocity_y, 1};
      differences.push_back(distance(cell, film.motion(hands[i])));
      felt[i] += force_of(length(cell) / kInterval, kWidth) > 0.05;
    }
  }
  for (std::size_t i = 0; i < hands.size(); ++i)
    EXPECT_GE(2 * felt[i], frames) << hands[i].x << ", " << hands[i].y;
  EXPECT_LE(quantile(differences, 0.5), 0.1);
  EXPECT_LE(quantile(differences, 0.9), 0.3);
  std::printf("felt %.0f to %.0f %% of the time; px per frame: median %.3f, p90 %.3f\n",
              100.0 * std::ranges::min(felt) / frames, 100.0 * std::ranges::max(felt) / frames,
              quantile(differences, 0.5), quantile(differences, 0.9));
}

} // namespace wind_film_test
