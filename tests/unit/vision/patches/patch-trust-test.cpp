// SPDX-License-Identifier: LGPL-2.1-or-later
// The rules that the tracker of a region and that of the whole frame share.
#include "field-frames.hpp"
#include "patches/patch-trust.hpp"
#include "patches/start-set.hpp"
#include "pixels/frame-reduction.hpp"
#include "tracking/noise-estimate.hpp"
#include "tracking/patch-tracker.hpp"

#include <gtest/gtest.h>
#include <random>

namespace patch_trust_test {

using haptic::Alignment;
using haptic::Measurement;
using haptic::Template;
using test::Frame;
using test::Texture;

constexpr float kNoise = 1.5F * 1.5F;

Template patch_on(const Frame &frame) {
  haptic::Plane plane;
  haptic::smooth(test::view_of(frame), plane);
  Template patch;
  patch.x = patch.y = 10;
  haptic::prepare_templates(plane, {&patch, 1});
  return patch;
}

Frame wall(double sigma, unsigned seed) {
  std::mt19937 random(seed);
  Frame frame(40, 40, 120);
  test::add_noise(frame, sigma, random);
  return frame;
}

Alignment aligned(float correlation, float residual) {
  return {{1, 2}, {.correlation = correlation, .residual = residual, .inside = true}};
}

TEST(PatchTrust, GrowsWithTheCorrelationFromZeroToOne) {
  EXPECT_EQ(haptic::trust_of(-1), 0);
  EXPECT_EQ(haptic::trust_of(0.6F), 0);
  EXPECT_NEAR(haptic::trust_of(0.75F), 0.5, 1e-6);
  EXPECT_EQ(haptic::trust_of(0.9F), 1);
  EXPECT_EQ(haptic::trust_of(1), 1);
}

TEST(PatchTrust, NoiseIsNoTexture) {
  for (unsigned seed = 0; seed < 50; ++seed)
    EXPECT_FALSE(
        haptic::has_texture(eigenvalues(patch_on(wall(1.5, seed)).structure).most, 64, kNoise));
  EXPECT_TRUE(haptic::has_texture(
      eigenvalues(patch_on(Texture(1).frame(40, 40, {})).structure).most, 64, kNoise));
}

TEST(PatchTrust, AGoodPatchIsAddedWithItsPrecision) {
  const Template patch = patch_on(Texture(1).frame(40, 40, {}));
  Measurement good;
  EXPECT_EQ(haptic::add_patch(patch, aligned(0.95F, 1), kNoise, good), 1);
  EXPECT_EQ(good.candidates, 1);
  ASSERT_EQ(good.count, 1);
  EXPECT_EQ(good.patches[0].x, 14);
  EXPECT_EQ(good.patches[0].width, 8);
  EXPECT_EQ(good.patches[0].dx, 1);
  EXPECT_EQ(good.patches[0].dy, 2);
  EXPECT_FLOAT_EQ(good.patches[0].precision_xx, patch.structure.xx / haptic::displacement_noise(1));
  // Half the trust, half the precision.
  Measurement doubtful;
  EXPECT_NEAR(haptic::add_patch(patch, aligned(0.75F, 1), kNoise, doubtful), 0.5, 1e-6);
  EXPECT_NEAR(doubtful.patches[0].precision_xx, good.patches[0].precision_xx / 2,
              1e-4 * good.patches[0].precision_xx);
}

TEST(PatchTrust, APatchThatIsNotFoundAgainIsOnlyACandidate) {
  const Template patch = patch_on(Texture(1).frame(40, 40, {}));
  Measurement measurement;
  EXPECT_EQ(haptic::add_patch(patch, aligned(0.5F, 9), kNoise, measurement), 0);
  EXPECT_EQ(haptic::add_patch(patch, {}, kNoise, measurement), 0); // outside the frame
  EXPECT_EQ(measurement.candidates, 2);
  EXPECT_EQ(measurement.count, 0);
}

TEST(PatchTrust, APatchWithoutTextureIsNoCandidate) {
  Measurement measurement;
  haptic::add_patch(patch_on(wall(1.5, 1)), aligned(0.3F, 1), kNoise, measurement);
  EXPECT_EQ(measurement.candidates, 0);
}

TEST(PatchTrust, WhatCannotBeTrustedIsNotAddedEvenWithoutTexture) {
  Measurement measurement;
  haptic::add_patch(patch_on(wall(1.5, 1)), aligned(0.3F, 1), kNoise, measurement);
  EXPECT_EQ(measurement.count, 0);
}

TEST(PatchTrust, MostCandidatesMustBeTrusted) {
  EXPECT_TRUE(haptic::is_same_scene(15, 20));
  EXPECT_FALSE(haptic::is_same_scene(10, 20));
  EXPECT_TRUE(haptic::is_same_scene(0, 0));
}

TEST(StartSet, HoldsNoTwoThatAreClose) {
  haptic::StartSet starts;
  starts.add({0, 0});
  starts.add({0.5F, 0.5F});
  starts.add({1, 1});
  starts.add({0.6F, 0.6F});
  ASSERT_EQ(starts.view().size(), 2U);
  EXPECT_EQ(starts.view()[1].x, 1);
  for (int i = 0; i < 30; ++i)
    starts.add({static_cast<float>(2 * i), 5});
  EXPECT_EQ(starts.view().size(), 12U);
  starts.clear();
  EXPECT_TRUE(starts.view().empty());
}

TEST(NoiseEstimate, ApproachesHalfTheEnergyOfTheDifference) {
  haptic::NoiseEstimate noise(0.5F);
  EXPECT_FLOAT_EQ(noise.variance(), haptic::kAssumedVariance);
  noise.reset(4, 1);
  noise.learn(12);
  EXPECT_FLOAT_EQ(noise.variance(), 5);
  for (int i = 0; i < 50; ++i)
    noise.learn(0);
  EXPECT_NEAR(noise.variance(), 1, 1e-4);
  for (int i = 0; i < 50; ++i)
    noise.learn(1e9F);
  EXPECT_NEAR(noise.variance(), 150, 1e-2);
}

TEST(Measurement, ScalesLengthsAndPrecisionsAndShiftsCentres) {
  Measurement measurement;
  measurement.add({1, 2, 8, 16, 0.5F, -0.5F, 40, 8, 20, 3});
  measurement.shift(1, 1);
  measurement.scale(2);
  measurement.shift(100, 0);
  const haptic::Patch &patch = measurement.patches[0];
  EXPECT_EQ(patch.x, 104);
  EXPECT_EQ(patch.y, 6);
  EXPECT_EQ(patch.width, 16);
  EXPECT_EQ(patch.height, 32);
  EXPECT_EQ(patch.dx, 1);
  EXPECT_EQ(patch.dy, -1);
  EXPECT_EQ(patch.precision_xx, 10);
  EXPECT_EQ(patch.precision_xy, 2);
  EXPECT_EQ(patch.precision_yy, 5);
  EXPECT_EQ(patch.residual, 3);
}

TEST(Measurement, HoldsNoMoreThanItsArray) {
  Measurement measurement;
  for (int i = 0; i < 2 * haptic::kMaxPatches; ++i)
    measurement.add({});
  EXPECT_EQ(measurement.count, haptic::kMaxPatches);
}

TEST(FrameReduction, HalvesAsOftenAsAsked) {
  const Frame frame = Texture(2).frame(101, 64, {});
  haptic::FrameReduction reduction;
  EXPECT_EQ(reduction.reduce(test::view_of(frame), 0).pixels, frame.pixels.data());
  const haptic::LumaView small = reduction.reduce(test::view_of(frame), 3);
  EXPECT_EQ(small.width, 12);
  EXPECT_EQ(small.height, 8);
}

TEST(Doublings, CountHowOftenTheRegionOfThePaperFits) {
  for (const auto &[side, doublings] :
       {std::pair(12, 0), {30, 0}, {59, 0}, {60, 1}, {119, 1}, {120, 2}, {480, 4}})
    EXPECT_EQ(haptic::doublings(side), doublings) << side;
}

} // namespace patch_trust_test
