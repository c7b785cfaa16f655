// SPDX-License-Identifier: LGPL-2.1-or-later
// What the fast tracker promises of memory and of instruction sets.
#include "counted-allocations.hpp"
#include "guarded-frame.hpp"
#include "moving-texture.hpp"
#include "patch-tracker.hpp"
#include "velocity-estimate.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <hwy/targets.h>
#include <random>

namespace {

using haptic::CropPair;
using haptic::LumaView;
using haptic::Measurement;
using haptic::Rectangle;
using test::Frame;
using test::Texture;

constexpr Rectangle kRegion{55, 55, 30, 30};
constexpr int kSide = 140;

CropPair pair_of(Frame &previous, Frame &current, const haptic::PatchTracker &tracker) {
  const Rectangle crop = haptic::crop_around(kRegion, tracker.margin(kRegion.width), kSide, kSide);
  const auto view = [&](Frame &frame) {
    return LumaView{&frame.at(crop.x, crop.y), crop.width, crop.height, frame.width};
  };
  return {view(previous), view(current), crop, kRegion};
}

// Two objects: a grid of patches, some on the border between them.
Frame two_objects(const Texture &left, const Texture &right, double time) {
  Frame frame = left.frame(kSide, kSide, {1.7 * time, -0.6 * time});
  Frame other = right.frame(kSide, kSide, {-1.2 * time, 0.9 * time});
  for (int y = 0; y < kSide; ++y)
    for (int x = kSide / 2; x < kSide; ++x)
      frame.at(x, y) = other.at(x, y);
  return frame;
}

// Together they climb every rung of the ladder.
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

haptic::VelocityEstimate answer(const Measurement &found, const CropPair &pair) {
  const auto &r = pair.region;
  return haptic::estimate_velocity(
      {.patches = found.view(),
       .candidates = found.candidates,
       .pointer_x = static_cast<float>(r.x) + static_cast<float>(r.width) / 2,
       .pointer_y = static_cast<float>(r.y) + static_cast<float>(r.height) / 2,
       .interval = 1,
       .region_x = static_cast<float>(r.x),
       .region_y = static_cast<float>(r.y),
       .region_width = static_cast<float>(r.width),
       .region_height = static_cast<float>(r.height)},
      haptic::Average::model, haptic::ModelChoice::automatic);
}

TEST(FastTrackerLimits, EveryInstructionSetGivesTheSameAnswer) {
  int targets = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const auto scene = static_cast<Scene>(seed % 3);
    // A patch of a grid may stop a step earlier or later: steps below 0.017 px are the last.
    const float alike = scene == Scene::translation ? 1e-3F : 5e-3F;
    Frame before = frame_of(scene, seed, 0);
    Frame after = frame_of(scene, seed, 1);
    haptic::VelocityEstimate reference;
    targets = 0;
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      const auto tracker = haptic::make_fast_tracker();
      const CropPair pair = pair_of(before, after, *tracker);
      Measurement found;
      tracker->measure(pair, found);
      const auto estimate = answer(found, pair);
      EXPECT_GT(estimate.confidence, 0) << hwy::TargetName(target);
      if (targets++ == 0)
        reference = estimate;
      EXPECT_NEAR(estimate.velocity_x, reference.velocity_x, alike) << hwy::TargetName(target);
      EXPECT_NEAR(estimate.velocity_y, reference.velocity_y, alike) << hwy::TargetName(target);
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().DeInit();
  }
  RecordProperty("targets", targets);
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

} // namespace
