#include "velocity-estimate.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace {

using haptic::Average;
using haptic::estimate_velocity;
using haptic::ModelChoice;
using haptic::MotionModel;
using haptic::PatchSet;
using haptic::VelocityEstimate;

constexpr float kPointerX = 100;
constexpr float kPointerY = 80;
constexpr double kInterval = 0.04;

// dx, dy at a place about the pointer.
struct Motion {
  double x0 = 0, y0 = 0, xx = 0, xy = 0, yx = 0, yy = 0;
};

std::vector<GstHapticPatch> patches_of(const Motion &motion, int count, double noise = 0) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-15, 15);
  std::normal_distribution<double> error(0, 1);
  std::vector<GstHapticPatch> patches;
  for (int i = 0; i < count; ++i) {
    const double x = place(random);
    const double y = place(random);
    GstHapticPatch patch{};
    patch.x = static_cast<float>(kPointerX + x);
    patch.y = static_cast<float>(kPointerY + y);
    patch.dx =
        static_cast<float>(motion.x0 + motion.xx * x + motion.xy * y + noise * error(random));
    patch.dy =
        static_cast<float>(motion.y0 + motion.yx * x + motion.yy * y + noise * error(random));
    patch.residual = 2;
    patches.push_back(patch);
  }
  return patches;
}

VelocityEstimate estimate(const std::vector<GstHapticPatch> &patches, Average average,
                          ModelChoice choice = ModelChoice::automatic, int candidates = 0) {
  return estimate_velocity({patches, candidates ? candidates : static_cast<int>(patches.size()),
                            kPointerX, kPointerY, kInterval},
                           average, choice);
}

TEST(VelocityEstimate, IsTheDisplacementOverTheIntervalWhateverTheAverage) {
  const auto patches = patches_of({2, -1}, 20);
  for (const Average average : {Average::model, Average::mean, Average::median}) {
    const VelocityEstimate found = estimate(patches, average);
    EXPECT_NEAR(found.velocity_x, 50, 1e-3);
    EXPECT_NEAR(found.velocity_y, -25, 1e-3);
    EXPECT_EQ(found.spin, 0);
    EXPECT_EQ(found.divergence, 0);
    EXPECT_EQ(found.confidence, 1);
    EXPECT_EQ(found.points, 20);
    EXPECT_EQ(found.model, MotionModel::translation);
  }
}

TEST(VelocityEstimate, TheMeanIsEquationThreeAsPrinted) {
  auto patches = patches_of({1, 0}, 3);
  patches[2].dx = 4;
  EXPECT_NEAR(estimate(patches, Average::mean).velocity_x, (1 + 1 + 4) / 3.0 / kInterval, 1e-3);
  EXPECT_NEAR(estimate(patches, Average::median).velocity_x, 1 / kInterval, 1e-3);
}

TEST(VelocityEstimate, TheMedianOfAnEvenNumberLiesBetweenTheMiddleTwo) {
  auto patches = patches_of({}, 4);
  for (std::size_t i = 0; i < 4; ++i)
    patches[i].dy = static_cast<float>(i);
  EXPECT_NEAR(estimate(patches, Average::median).velocity_y, 1.5 / kInterval, 1e-3);
}

TEST(VelocityEstimate, TheModelIgnoresPatchesOnAnotherObject) {
  auto patches = patches_of({2, -1}, 20, 0.02);
  for (std::size_t i = 0; i < 6; ++i) {
    patches[i].dx = -8;
    patches[i].dy = 5;
  }
  const VelocityEstimate found = estimate(patches, Average::model);
  EXPECT_NEAR(found.velocity_x * kInterval, 2, 0.03);
  EXPECT_NEAR(found.velocity_y * kInterval, -1, 0.03);
  EXPECT_EQ(found.points, 14);
}

TEST(VelocityEstimate, TheStaticModelNeverMoves) {
  const VelocityEstimate found =
      estimate(patches_of({2, -1}, 20), Average::model, ModelChoice::still);
  EXPECT_EQ(found.velocity_x, 0);
  EXPECT_EQ(found.velocity_y, 0);
  EXPECT_EQ(found.model, MotionModel::still);
}

TEST(VelocityEstimate, ASimilarityTellsSpinAndExpansionAndTheVelocityAtThePointer) {
  // Turns x towards y by 0.05 rad and grows by 2 % a picture, about a centre beside the pointer.
  const Motion motion{0.7, -0.4, 0.02, -0.05, 0.05, 0.02};
  for (const ModelChoice choice : {ModelChoice::similarity, ModelChoice::affine}) {
    const VelocityEstimate found = estimate(patches_of(motion, 20), Average::model, choice);
    EXPECT_NEAR(found.velocity_x, 0.7 / kInterval, 0.01);
    EXPECT_NEAR(found.velocity_y, -0.4 / kInterval, 0.01);
    EXPECT_NEAR(found.spin, 0.05 / kInterval, 0.01);
    EXPECT_NEAR(found.divergence, 0.02 / kInterval, 0.01);
  }
}

TEST(VelocityEstimate, AnAffineMotionShears) {
  const Motion shear{0, 0, 0.04, 0.03, 0, 0};
  const VelocityEstimate found =
      estimate(patches_of(shear, 20), Average::model, ModelChoice::affine);
  EXPECT_NEAR(found.velocity_x, 0, 0.01);
  EXPECT_NEAR(found.spin, -0.015 / kInterval, 0.01);
  EXPECT_NEAR(found.divergence, 0.02 / kInterval, 0.01);
  EXPECT_EQ(found.model, MotionModel::affine);
}

TEST(VelocityEstimate, AModelThatThePatchesCannotDetermineGivesWayToASmallerOne) {
  EXPECT_EQ(estimate(patches_of({1, 1}, 3), Average::model, ModelChoice::affine).model,
            MotionModel::similarity);
  EXPECT_EQ(estimate(patches_of({1, 1}, 2), Average::model, ModelChoice::affine).model,
            MotionModel::translation);
  auto line = patches_of({1, 1}, 10);
  for (auto &patch : line)
    patch.y = kPointerY;
  EXPECT_EQ(estimate(line, Average::model, ModelChoice::affine).model, MotionModel::similarity);
  auto spot = patches_of({1, 1}, 10);
  for (auto &patch : spot)
    patch.x = patch.y = 0;
  EXPECT_EQ(estimate(spot, Average::model, ModelChoice::similarity).model,
            MotionModel::translation);
}

TEST(VelocityEstimate, ConfidenceFallsWithEveryDoubt) {
  const auto sure = patches_of({2, -1}, 20);
  const auto confidence = [](const std::vector<GstHapticPatch> &patches, int candidates) {
    return estimate(patches, Average::model, ModelChoice::automatic, candidates).confidence;
  };
  EXPECT_EQ(confidence(sure, 20), 1);
  // Most corners were lost.
  EXPECT_LT(confidence(sure, 50), confidence(sure, 40));
  EXPECT_EQ(confidence(patches_of({2, -1}, 4), 20), 0);
  // Few agree at all.
  EXPECT_LT(confidence(patches_of({2, -1}, 1), 1), confidence(patches_of({2, -1}, 2), 2));
  // The pictures differ where they should match.
  auto changed = sure;
  for (auto &patch : changed)
    patch.residual = 30;
  EXPECT_LT(confidence(changed, 20), 1);
  for (auto &patch : changed)
    patch.residual = 60;
  EXPECT_EQ(confidence(changed, 20), 0);
}

TEST(VelocityEstimate, NothingMeasuredIsNothingAndNotANumberNeverLeaves) {
  EXPECT_EQ(estimate({}, Average::model).confidence, 0);
  EXPECT_EQ(estimate({}, Average::model).model, MotionModel::none);
  auto patches = patches_of({2, -1}, 20);
  EXPECT_EQ(estimate_velocity({patches, 20, kPointerX, kPointerY, 0}, Average::mean,
                              ModelChoice::automatic)
                .confidence,
            0);
  EXPECT_EQ(estimate_velocity({patches, 20, kPointerX, kPointerY, 1e-9}, Average::mean,
                              ModelChoice::automatic)
                .confidence,
            0)
      << "a nanosecond apart";
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    patches[3].dx = bad;
    for (const Average average : {Average::model, Average::mean, Average::median})
      for (const ModelChoice choice : {ModelChoice::automatic, ModelChoice::affine}) {
        const VelocityEstimate found = estimate(patches, average, choice);
        EXPECT_TRUE(std::isfinite(found.velocity_x) && std::isfinite(found.velocity_y) &&
                    std::isfinite(found.spin) && std::isfinite(found.divergence) &&
                    std::isfinite(found.confidence));
      }
  }
}

} // namespace
