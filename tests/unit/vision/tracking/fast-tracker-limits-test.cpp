// SPDX-License-Identifier: LGPL-2.1-or-later
// The fast tracker reads only its crop, allocates nothing once it runs, and gives the same result
// on every instruction set.
#include "counted-allocations.hpp"
#include "guarded-frame.hpp"
#include "instruction-sets.hpp"
#include "region-tracking.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <random>

namespace fast_tracker_limits_test {

using haptic::CropPair;
using haptic::Measurement;
using haptic::Rectangle;
using test::Frame;
using test::Texture;

constexpr Rectangle kRegion{55, 55, 30, 30};
constexpr int kSide = 140;

CropPair pair_of(Frame &previous, Frame &current, const haptic::PatchTracker &tracker) {
  return test::crop_pair(previous, current, kRegion, tracker);
}

// Two objects need a grid of patches, some of them on the border between the objects.
Frame two_objects(const Texture &left, const Texture &right, double time) {
  Frame frame = left.frame(kSide, kSide, {1.7 * time, -0.6 * time});
  Frame other = right.frame(kSide, kSide, {-1.2 * time, 0.9 * time});
  for (int y = 0; y < kSide; ++y)
    for (int x = kSide / 2; x < kSide; ++x)
      frame.at(x, y) = other.at(x, y);
  return frame;
}

// Together they need one translation, a grid, and a grid with strain.
enum class Scene { translation, two_objects, turning };

Frame frame_of(Scene scene, unsigned seed, double time) {
  switch (scene) {
  case Scene::two_objects:
    return two_objects(Texture(seed), Texture(seed + 100), time);
  case Scene::turning:
    return Texture(seed).turned(kSide, kSide, 0.09 * time); // 5 degrees
  case Scene::translation:
    break;
  }
  return Texture(seed).frame(kSide, kSide, {2.3 * time, -1.4 * time});
}

TEST(FastTrackerLimits, EveryInstructionSetGivesTheSameResult) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const auto scene = static_cast<Scene>(seed % 3);
    // A patch of a grid may stop a step earlier or later: steps below 0.017 px are the last.
    const float tolerance = scene == Scene::translation ? 1e-3F : 5e-3F;
    Frame before = frame_of(scene, seed, 0);
    Frame after = frame_of(scene, seed, 1);
    std::optional<haptic::VelocityEstimate> reference;
    test::for_instruction_sets([&](const char *name) {
      const auto tracker = haptic::make_fast_tracker();
      Measurement found;
      tracker->measure(pair_of(before, after, *tracker), found);
      const auto estimate = test::estimate(found, kRegion);
      EXPECT_GT(estimate.confidence, 0) << name;
      if (!reference)
        reference = estimate;
      EXPECT_NEAR(estimate.velocity_x, reference->velocity_x, tolerance) << name;
      EXPECT_NEAR(estimate.velocity_y, reference->velocity_y, tolerance) << name;
    });
  }
}

TEST(FastTrackerLimits, NothingOutsideTheCropIsRead) {
  for (const Scene scene : {Scene::translation, Scene::two_objects, Scene::turning})
    for (const bool ends : {false, true}) {
      Frame before = frame_of(scene, 3, 0);
      Frame after = frame_of(scene, 3, 1);
      const auto tracker = haptic::make_fast_tracker();
      CropPair pair = pair_of(before, after, *tracker);
      test::GuardedFrame previous(pair.crop.width, pair.crop.height);
      test::GuardedFrame current(pair.crop.width, pair.crop.height);
      pair.previous = previous.filled(pair.previous, ends);
      pair.current = current.filled(pair.current, ends);
      Measurement found;
      tracker->measure(pair, found);
      if (scene == Scene::translation)
        EXPECT_EQ(found.count, 1);
      else
        EXPECT_GT(found.count, 1);
    }
}

TEST(FastTrackerLimits, RegionsOfAnyShapeAtEveryBorderReadNothingOutsideTheCrop) {
  std::mt19937 random(2);
  int voted = 0;
  for (int i = 0; i < 150; ++i) {
    const int width = std::uniform_int_distribution(1, kSide)(random);
    const int height = std::uniform_int_distribution(1, kSide)(random);
    const auto [x, columns] = test::any_part(random, width);
    const auto [y, rows] = test::any_part(random, height);
    const Rectangle region{x, y, columns, rows};
    const auto tracker = haptic::make_fast_tracker();
    const Rectangle crop = haptic::crop_around(
        region, tracker->margin(std::max(region.width, region.height)), width, height);
    test::GuardedFrame previous(crop.width, crop.height);
    test::GuardedFrame current(crop.width, crop.height);
    const auto seed = static_cast<unsigned>(i);
    Frame before = two_objects(Texture(seed, 4), Texture(seed + 500, 4), 0);
    Frame after = two_objects(Texture(seed, 4), Texture(seed + 500, 4), i % 5);
    const Rectangle shown{(kSide - crop.width) / 2, (kSide - crop.height) / 2, crop.width,
                          crop.height};
    const bool ends = i % 2 == 0;
    Measurement found;
    tracker->measure({previous.filled(test::view(before, shown), ends),
                      current.filled(test::view(after, shown), ends), crop, region},
                     found);
    for (const haptic::Patch &patch : found.view()) {
      EXPECT_TRUE(std::isfinite(patch.dx) && std::isfinite(patch.dy));
      EXPECT_TRUE(patch.share >= 0 && patch.share <= 1) << patch.share;
      voted += patch.share > 0;
    }
  }
  EXPECT_GT(voted, 0);
}

TEST(FastTrackerLimits, AfterTheFirstFramesNothingIsAllocated) {
  std::mt19937 random(5);
  std::vector<Frame> movie;
  for (int i = 0; i < 6; ++i) {
    movie.push_back(two_objects(Texture(6), Texture(i % 2 ? 7 : 6), i));
    add_noise(movie.back(), 1.5, random);
  }
  const auto tracker = haptic::make_fast_tracker();
  Measurement found;
  const auto run = [&](int frames) {
    for (int i = 0; i < frames; ++i) {
      CropPair pair = pair_of(movie[static_cast<std::size_t>(i) % 6],
                              movie[static_cast<std::size_t>(i + 1) % 6], *tracker);
      pair.continues = i > 0;
      tracker->measure(pair, found);
    }
  };
  run(12);
  const long before = test::allocations;
  run(20000);
  EXPECT_EQ(test::allocations, before);
}

} // namespace fast_tracker_limits_test
