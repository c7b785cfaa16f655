// SPDX-License-Identifier: LGPL-2.1-or-later
// What one estimate costs by what the patches show, beside OpenCV's similarity fit of the same
// patches: ns per frame.
#include "velocity/velocity-estimate.hpp"

#include <benchmark/benchmark.h>
#include <cmath>
#include <cstdint>
#include <opencv2/calib3d.hpp>
#include <random>
#include <vector>

namespace {

struct Gradient {
  double xx = 0, xy = 0, yx = 0, yy = 0;
};

enum Scene : std::int64_t { kStatic, kTranslation, kSimilarity, kAffine, kMixture };

// In a region of 30 px, to 0.05 px each; one in ten is a false match.
std::vector<GstHapticPatch> patches_of(std::int64_t scene, std::int64_t count, unsigned seed) {
  constexpr double kSigma = 0.05;
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0, kSigma);
  std::uniform_real_distribution<double> place(-15, 15);
  std::uniform_real_distribution<double> anything(-8, 8);
  const double shift = scene == kStatic ? 0 : 2;
  const Gradient gradient = scene == kSimilarity ? Gradient{0.03, -0.07, 0.07, 0.03}
                            : scene == kAffine   ? Gradient{0.05, 0.03, 0.03, -0.05}
                                                 : Gradient{};
  std::vector<GstHapticPatch> patches;
  for (std::int64_t i = 0; i < count; ++i) {
    const double x = place(random);
    const double y = place(random);
    const bool other = scene == kMixture && x > 3;
    double dx = (other ? -shift : shift) + gradient.xx * x + gradient.xy * y + error(random);
    double dy = gradient.yx * x + gradient.yy * y + error(random);
    if (i % 10 == 9 && scene != kMixture) {
      dx = anything(random);
      dy = anything(random);
    }
    GstHapticPatch patch{};
    patch.x = static_cast<float>(x);
    patch.y = static_cast<float>(y);
    patch.dx = static_cast<float>(dx);
    patch.dy = static_cast<float>(dy);
    patch.precision_xx = patch.precision_yy = static_cast<float>(1 / (kSigma * kSigma));
    patches.push_back(patch);
  }
  return patches;
}

constexpr unsigned kFrames = 64;

std::vector<std::vector<GstHapticPatch>> frames_of(const benchmark::State &state) {
  std::vector<std::vector<GstHapticPatch>> frames;
  for (unsigned i = 0; i < kFrames; ++i)
    frames.push_back(patches_of(state.range(0), state.range(1), i));
  return frames;
}

void estimate(benchmark::State &state) {
  const auto frames = frames_of(state);
  haptic::ModelHistory history;
  std::size_t i = 0;
  for (auto _ : state) {
    const auto found = haptic::estimate_velocity(
        {frames[i++ % kFrames], static_cast<int>(state.range(1)), 0, 0, 0.04, -15, -15, 30, 30},
        haptic::Average::model, haptic::ModelChoice::automatic, history);
    history = found.history;
    benchmark::DoNotOptimize(found);
  }
}

void opencv(benchmark::State &state) {
  std::vector<std::vector<cv::Point2f>> from(kFrames);
  std::vector<std::vector<cv::Point2f>> to(kFrames);
  const auto frames = frames_of(state);
  for (std::size_t i = 0; i < kFrames; ++i)
    for (const GstHapticPatch &patch : frames[i]) {
      from[i].emplace_back(patch.x, patch.y);
      to[i].emplace_back(patch.x + patch.dx, patch.y + patch.dy);
    }
  cv::setNumThreads(1);
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(cv::estimateAffinePartial2D(from[i % kFrames], to[i % kFrames],
                                                         cv::noArray(), cv::RANSAC, 0.2));
    ++i;
  }
}

} // namespace

BENCHMARK(estimate)
    ->ArgNames({"scene", "patches"})
    ->Args({kTranslation, 1})
    ->ArgsProduct({{kStatic, kTranslation, kSimilarity, kAffine, kMixture}, {20}})
    ->ArgsProduct({{kAffine}, {8, 40, 64}});
BENCHMARK(opencv)->ArgNames({"scene", "patches"})->ArgsProduct({{kTranslation, kSimilarity}, {20}});

BENCHMARK_MAIN();
