// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hold/patch-kernels.hpp"
#include "instruction-sets.hpp"
#include "moving-texture.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace patch_kernels_test {

using haptic::kPatchRadius;
using haptic::kPatchRoom;
using haptic::kPatchSamples;
using haptic::kPatchSide;
using haptic::PatchPose;
using haptic::PatchSamples;
using haptic::Plane;

constexpr int kSide = 64;

// Any grey levels, and of a plane that rises evenly.
Plane textured() {
  Plane plane;
  plane.resize(kSide, kSide);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> grey(0, 255);
  for (int y = 0; y < kSide; ++y)
    std::generate_n(plane.row(y), kSide, [&] { return grey(random); });
  return plane;
}
Plane ramp() {
  Plane plane;
  plane.resize(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      plane.row(y)[x] = static_cast<float>(2 * x + y);
  return plane;
}

PatchSamples some(unsigned seed, float low, float high) {
  PatchSamples samples;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(low, high);
  std::generate_n(samples.data(), kPatchSamples, [&] { return value(random); });
  return samples;
}

TEST(PatchKernels, SamplesAreLinearBetweenPixels) {
  const Plane plane = ramp();
  const PatchPose pose{.a = 0.9F, .b = -0.2F, .c = 0.2F, .d = 0.9F, .x = 30.3F, .y = 28.6F};
  test::for_instruction_sets([&](const char *name) {
    PatchSamples samples;
    haptic::sample_plane(plane, pose, samples);
    for (int v = -kPatchRadius; v <= kPatchRadius; ++v)
      for (int u = -kPatchRadius; u <= kPatchRadius; ++u) {
        const auto fu = static_cast<float>(u);
        const auto fv = static_cast<float>(v);
        const float x = pose.a * fu + pose.b * fv + pose.x;
        const float y = pose.c * fu + pose.d * fv + pose.y;
        ASSERT_NEAR(samples[(v + kPatchRadius) * kPatchSide + u + kPatchRadius], 2 * x + y, 0.01)
            << name;
      }
    EXPECT_TRUE(std::all_of(samples.values.begin() + kPatchSamples, samples.values.end(),
                            [](float value) { return value == 0; }))
        << name;
  });
}

TEST(PatchKernels, MomentsAreThoseOfTheDefinition) {
  const PatchSamples weights = some(1, 0, 1);
  const PatchSamples a = some(2, 0, 255);
  const PatchSamples b = some(3, 0, 255);
  double weight = 0;
  double mean_a = 0;
  double mean_b = 0;
  for (int i = 0; i < kPatchSamples; ++i) {
    weight += weights[i];
    mean_a += weights[i] * a[i];
    mean_b += weights[i] * b[i];
  }
  mean_a /= weight;
  mean_b /= weight;
  double variance = 0;
  double covariance = 0;
  for (int i = 0; i < kPatchSamples; ++i) {
    variance += weights[i] * (a[i] - mean_a) * (a[i] - mean_a) / weight;
    covariance += weights[i] * (a[i] - mean_a) * (b[i] - mean_b) / weight;
  }
  test::for_instruction_sets([&](const char *name) {
    const haptic::PatchMoments moments = haptic::compare_patches(weights, a, b);
    EXPECT_NEAR(moments.weight, weight, 1e-3 * weight) << name;
    EXPECT_NEAR(moments.mean_a, mean_a, 0.01) << name;
    EXPECT_NEAR(moments.mean_b, mean_b, 0.01) << name;
    EXPECT_NEAR(moments.variance_a, variance, 1e-3 * variance) << name;
    EXPECT_NEAR(moments.covariance, covariance, 1e-3 * variance) << name;
  });
}

TEST(PatchKernels, TheNormalEquationsFindASmallStep) {
  // A step of (0.1, -0.2) samples changes each grey level by its gradient times the step.
  haptic::PatchTemplate patch{.grey = some(4, 0, 255)};
  haptic::differentiate(patch);
  PatchSamples errors;
  for (int i = 0; i < kPatchSamples; ++i)
    errors[i] = 0.1F * patch.gradient_x[i] - 0.2F * patch.gradient_y[i];
  const PatchSamples weights = some(5, 0, 1);
  test::for_instruction_sets([&](const char *name) {
    const auto sums = haptic::sum_normal_equations(patch, errors, weights, 1e4F, false);
    const double xx = sums.matrix[0];
    const double xy = sums.matrix[1];
    const double yy = sums.matrix[2];
    const double determinant = xx * yy - xy * xy;
    EXPECT_NEAR((yy * sums.right[0] - xy * sums.right[1]) / determinant, 0.1, 1e-3) << name;
    EXPECT_NEAR((xx * sums.right[1] - xy * sums.right[0]) / determinant, -0.2, 1e-3) << name;
  });
}

TEST(PatchKernels, WhatDoesNotFitIsNotLearned) {
  const PatchSamples known = some(6, 60, 120);
  PatchSamples now = known;
  for (int i = 0; i < kPatchSamples / 2; ++i)
    now[i] += 80; // something covers the upper half
  test::for_instruction_sets([&](const char *name) {
    PatchSamples appearance = known;
    PatchSamples fits;
    fits.values.fill(1);
    for (int frame = 0; frame < 30; ++frame)
      haptic::learn_samples(now, 1, 0, 5, {.fits = 0.1F, .appearance = 0.01F}, appearance, fits);
    EXPECT_LT(fits[0], 0.1F) << name;
    EXPECT_LT(appearance[0] - known[0], 5) << name;
    EXPECT_GT(fits[kPatchSamples - 1], 0.99F) << name;
  });
}

TEST(PatchKernels, ACorrelationIsOneWhereThePatchIsAndNowhereElse) {
  const Plane plane = textured();
  PatchSamples grey;
  haptic::sample_plane(plane, {.x = 35, .y = 29}, grey);
  PatchSamples weights;
  std::fill_n(weights.data(), kPatchSamples, 1.0F);
  constexpr int kRadius = 9;
  constexpr int kScores = (2 * kRadius + 1) * (2 * kRadius + 1);
  test::for_instruction_sets([&](const char *name) {
    std::vector<float> scores(kScores);
    haptic::correlate(plane, 32, 31, kRadius, weights, grey, scores.data());
    const auto best = std::ranges::max_element(scores);
    EXPECT_EQ(best - scores.begin(), (kRadius - 2) * (2 * kRadius + 1) + kRadius + 3) << name;
    EXPECT_NEAR(*best, 1, 0.001) << name;
    *best = -1;
    EXPECT_LT(*std::ranges::max_element(scores), 0.6F) << name;
  });
}

TEST(PatchKernels, ACorrelationOutsideThePlaneIsNone) {
  const Plane plane = textured();
  const PatchSamples grey = some(7, 0, 255);
  PatchSamples weights;
  std::fill_n(weights.data(), kPatchSamples, 1.0F);
  for (const int at : {-100, 0, kSide, 1000}) {
    std::vector<float> scores(49);
    haptic::correlate(plane, at, at, 3, weights, grey, scores.data());
    EXPECT_TRUE(std::ranges::all_of(scores, [](float score) { return score == -1; })) << at;
  }
}

} // namespace patch_kernels_test
