// SPDX-License-Identifier: LGPL-2.1-or-later
#include "velocity/velocity-estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace velocity_estimate_test {

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

// Of a region of 30 px around the pointer.
PatchSet around_pointer(const std::vector<GstHapticPatch> &patches) {
  return {.patches = patches,
          .candidates = static_cast<int>(patches.size()),
          .pointer_x = kPointerX,
          .pointer_y = kPointerY,
          .interval = kInterval,
          .region_x = kPointerX - 15,
          .region_y = kPointerY - 15,
          .region_width = 30,
          .region_height = 30};
}

TEST(VelocityEstimate, IsTheDisplacementOverTheIntervalWhateverTheAverage) {
  const auto patches = patches_of({2, -1}, 20);
  for (const Average average : {Average::model, Average::pointed, Average::mean, Average::median}) {
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

TEST(VelocityEstimate, OfThePointedThingIsThatOfThePatchesAboutThePointer) {
  auto patches = patches_of({2, -1}, 40);
  const auto is_far = [](const GstHapticPatch &patch) {
    return std::abs(patch.x - kPointerX) > 9 || std::abs(patch.y - kPointerY) > 9;
  };
  int far = 0;
  for (GstHapticPatch &patch : patches)
    if (is_far(patch)) {
      patch.dx = -3;
      ++far;
    }
  ASSERT_GT(far, 20); // most of the region moves another way
  const VelocityEstimate found =
      estimate_velocity(around_pointer(patches), Average::pointed, ModelChoice::automatic);
  EXPECT_NEAR(found.velocity_x * kInterval, 2, 1e-3);
  EXPECT_NEAR(found.velocity_y * kInterval, -1, 1e-3);
  EXPECT_EQ(found.points, 40 - far);
  EXPECT_EQ(found.confidence, 1);
}

// Five by five tiles of 6 px. A leaf lies under the pointer and reaches to one side of the region.
PatchSet leaf_of_tiles(std::vector<GstHapticPatch> &tiles) {
  for (int row = 0; row < 5; ++row)
    for (int column = 0; column < 5; ++column) {
      const bool is_leaf = row >= 1 && row <= 3 && column >= 2;
      tiles.push_back({.x = kPointerX + 6.0F * static_cast<float>(column - 2),
                       .y = kPointerY + 6.0F * static_cast<float>(row - 2),
                       .width = 6,
                       .height = 6,
                       .dx = is_leaf ? 2.0F : 0.0F,
                       .dy = is_leaf ? -1.0F : 0.0F,
                       .precision_xx = 100,
                       .precision_yy = 100});
    }
  PatchSet set = around_pointer(tiles);
  set.is_tiled = true;
  return set;
}

// What comes to move otherwise than the leaf leaves its mean without a step.
TEST(VelocityEstimate, OfThePointedThingATileComesAndGoesWithoutAStep) {
  std::vector<GstHapticPatch> tiles;
  const PatchSet set = leaf_of_tiles(tiles);
  double last = 2;
  for (int hundredths = 200; hundredths < 400; ++hundredths) {
    tiles[9].dx = 0.01F * static_cast<float>(hundredths); // at the border of the leaf
    const double now =
        estimate_velocity(set, Average::pointed, ModelChoice::automatic).velocity_x * kInterval;
    EXPECT_NEAR(now, last, 0.01) << tiles[9].dx;
    last = now;
  }
  EXPECT_NEAR(last, 2, 1e-3);
}

TEST(VelocityEstimate, OfThePointedThingIsThatOfTheTilesThatMoveWithIt) {
  std::vector<GstHapticPatch> tiles;
  const PatchSet set = leaf_of_tiles(tiles);
  const VelocityEstimate found = estimate_velocity(set, Average::pointed, ModelChoice::automatic);
  EXPECT_NEAR(found.velocity_x * kInterval, 2, 1e-3);
  EXPECT_NEAR(found.velocity_y * kInterval, -1, 1e-3);
  EXPECT_EQ(found.points, 9);
  EXPECT_GT(found.confidence, 0.9F);
}

TEST(VelocityEstimate, OfThePointedThingIsThatOfAllTilesWhereThePointerIsFarFromThem) {
  std::vector<GstHapticPatch> tiles;
  PatchSet set = leaf_of_tiles(tiles);
  set.pointer_x += 1000;
  const VelocityEstimate found = estimate_velocity(set, Average::pointed, ModelChoice::automatic);
  EXPECT_NEAR(found.velocity_x * kInterval, 2 * 9 / 25.0, 1e-3);
}

TEST(VelocityEstimate, TheMedianOfAnEvenNumberLiesBetweenTheMiddleTwo) {
  auto patches = patches_of({}, 4);
  for (std::size_t i = 0; i < 4; ++i)
    patches[i].dy = static_cast<float>(i);
  EXPECT_NEAR(estimate(patches, Average::median).velocity_y, 1.5 / kInterval, 1e-3);
}

TEST(VelocityEstimate, TheModelThatWasAskedForIgnoresPatchesOnAnotherObject) {
  auto patches = patches_of({2, -1}, 20, 0.02);
  for (std::size_t i = 0; i < 6; ++i) {
    patches[i].dx = -8;
    patches[i].dy = 5;
  }
  const VelocityEstimate found = estimate(patches, Average::model, ModelChoice::translation);
  EXPECT_NEAR(found.velocity_x * kInterval, 2, 0.03);
  EXPECT_NEAR(found.velocity_y * kInterval, -1, 0.03);
  EXPECT_EQ(found.points, 14);
  EXPECT_FALSE(found.mixture);
}

TEST(VelocityEstimate, TheModelIgnoresFalseMatches) {
  auto patches = patches_of({2, -1}, 20, 0.02);
  for (std::size_t i = 0; i < 6; ++i) {
    patches[i].dx = static_cast<float>(i) - 8;
    patches[i].dy = 5 - 2 * static_cast<float>(i % 3);
  }
  const VelocityEstimate found = estimate(patches, Average::model);
  EXPECT_NEAR(found.velocity_x * kInterval, 2, 0.03);
  EXPECT_NEAR(found.velocity_y * kInterval, -1, 0.03);
  EXPECT_EQ(found.points, 14);
  EXPECT_FALSE(found.mixture);
}

TEST(VelocityEstimate, TheStaticModelNeverMoves) {
  const VelocityEstimate found =
      estimate(patches_of({2, -1}, 20), Average::model, ModelChoice::still);
  EXPECT_EQ(found.velocity_x, 0);
  EXPECT_EQ(found.velocity_y, 0);
  EXPECT_EQ(found.model, MotionModel::still);
}

TEST(VelocityEstimate, ASimilarityTellsSpinAndExpansionAndTheVelocityAtThePointer) {
  // Turns x towards y by 0.05 rad and grows by 2 % a frame, about a centre beside the pointer.
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
  // The frames differ where they should match.
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
    for (const Average average : {Average::model, Average::pointed, Average::mean, Average::median})
      for (const ModelChoice choice : {ModelChoice::automatic, ModelChoice::affine}) {
        const VelocityEstimate found = estimate(patches, average, choice);
        EXPECT_TRUE(std::isfinite(found.velocity_x) && std::isfinite(found.velocity_y) &&
                    std::isfinite(found.spin) && std::isfinite(found.divergence) &&
                    std::isfinite(found.confidence));
      }
  }
}

// Places in a region of 30 px about the pointer, in half of the scenes clustered in a part of it,
// with what a patch of known precision measures there; one patch in ten is a false match.
class Scenes {
public:
  explicit Scenes(unsigned seed) : random_(seed) {}

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double sign() { return between(-1, 1) < 0 ? -1 : 1; }

  std::vector<GstHapticPatch> scene(const Motion &motion, int count, double sigma,
                                    double false_matches = 0.1) {
    std::normal_distribution<double> normal;
    const bool clustered = between(0, 1) < 0.5;
    const double centre_x = between(-9, 9);
    const double centre_y = between(-9, 9);
    std::vector<GstHapticPatch> patches;
    for (int i = 0; i < count; ++i) {
      const double x =
          clustered ? std::clamp(centre_x + 4 * normal(random_), -15.0, 15.0) : between(-15, 15);
      const double y =
          clustered ? std::clamp(centre_y + 4 * normal(random_), -15.0, 15.0) : between(-15, 15);
      double dx = motion.x0 + motion.xx * x + motion.xy * y + sigma * normal(random_);
      double dy = motion.y0 + motion.yx * x + motion.yy * y + sigma * normal(random_);
      if (between(0, 1) < false_matches) {
        dx = between(-8, 8);
        dy = between(-8, 8);
      }
      patches.push_back(patch(x, y, dx, dy, sigma));
    }
    return patches;
  }

  static GstHapticPatch patch(double x, double y, double dx, double dy, double sigma) {
    GstHapticPatch patch{};
    patch.x = static_cast<float>(kPointerX + x);
    patch.y = static_cast<float>(kPointerY + y);
    patch.dx = static_cast<float>(dx);
    patch.dy = static_cast<float>(dy);
    patch.precision_xx = patch.precision_yy = static_cast<float>(1 / (sigma * sigma));
    patch.residual = 2;
    return patch;
  }

  // At its own place in a motion that is a translation.
  GstHapticPatch noisy(const Motion &m, double x, double y, double sigma) {
    std::normal_distribution<double> normal;
    return patch(x, y, m.x0 + sigma * normal(random_), m.y0 + sigma * normal(random_), sigma);
  }

  Motion translation(double slowest, double fastest) {
    const double speed = between(slowest, fastest);
    const double direction = between(0, 2 * std::numbers::pi);
    return {speed * std::cos(direction), speed * std::sin(direction)};
  }

  // Turns by 2 to 6 degrees and grows or shrinks by 1 to 5 %.
  Motion similarity() {
    Motion motion = translation(0, 4);
    const double turn = sign() * between(2, 6) * std::numbers::pi / 180;
    const double size = 1 + sign() * between(0.01, 0.05);
    motion.xx = motion.yy = size * std::cos(turn) - 1;
    motion.yx = size * std::sin(turn);
    motion.xy = -motion.yx;
    return motion;
  }

  // Stretches along a direction by 3 to 9 % and shrinks as much across it.
  Motion affine() {
    Motion motion = translation(0, 4);
    const double stretch = between(0.03, 0.09);
    const double direction = between(0, 2 * std::numbers::pi);
    motion.xx = stretch * std::cos(direction);
    motion.xy = stretch * std::sin(direction);
    motion.yx = motion.xy;
    motion.yy = -motion.xx;
    return motion;
  }

  Motion of(MotionModel model) {
    switch (model) {
    case MotionModel::translation:
      return translation(0.3, 4);
    case MotionModel::similarity:
      return similarity();
    case MotionModel::affine:
      return affine();
    default:
      return {};
    }
  }

private:
  std::mt19937 random_;
};

double error_px(const VelocityEstimate &found, const Motion &truth) {
  return std::hypot(found.velocity_x * kInterval - truth.x0,
                    found.velocity_y * kInterval - truth.y0);
}

constexpr std::array kModels = {MotionModel::still, MotionModel::translation,
                                MotionModel::similarity, MotionModel::affine};
constexpr std::array kFixed = {ModelChoice::still, ModelChoice::translation,
                               ModelChoice::similarity, ModelChoice::affine};

struct Row {
  std::array<double, 4> chosen{}; // share of the scenes
  double error = 0;               // px at the pointer, mean
  std::array<double, 4> fixed_error{};
  double larger = 0;   // share of a larger model than the true one
  double mixtures = 0; // share taken for two motions
};

constexpr int kTrials = 1000;
// The history settles within the first; each has noise, places and false matches of its own.
constexpr int kSettled = 5;

Row row_of(MotionModel truth, int count, double sigma, int frames) {
  Scenes scenes(static_cast<unsigned>(1000 * count + 100 * sigma) + static_cast<unsigned>(truth));
  Row row;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Motion motion = scenes.of(truth);
    std::vector<GstHapticPatch> patches;
    VelocityEstimate found;
    for (int frame = 0; frame < frames; ++frame) {
      patches = scenes.scene(motion, count, sigma);
      found = estimate_velocity({patches, count, kPointerX, kPointerY, kInterval}, Average::model,
                                ModelChoice::automatic, found.history);
    }
    for (std::size_t i = 0; i < kModels.size(); ++i) {
      row.chosen[i] += (found.model == kModels[i]) / double{kTrials};
      row.fixed_error[i] +=
          error_px(estimate(patches, Average::model, kFixed[i]), motion) / kTrials;
    }
    row.larger += (found.model > truth) / double{kTrials};
    row.error += error_px(found, motion) / kTrials;
    row.mixtures += found.mixture / double{kTrials};
  }
  return row;
}

struct Setting {
  int count;
  double sigma;
};

class MotionModels : public ::testing::TestWithParam<Setting> {};

TEST_P(MotionModels, TheSmallestThatExplainsTheSceneIsChosen) {
  const auto [count, sigma] = GetParam();
  for (std::size_t truth = 0; truth < kModels.size(); ++truth) {
    SCOPED_TRACE(motion_model_name(kModels[truth]));
    const Row row = row_of(kModels[truth], count, sigma, kSettled);
    EXPECT_GE(row.chosen[truth], kModels[truth] == MotionModel::still ? 0.99 : 0.95);
    EXPECT_LE(row.larger, 0.03);
    EXPECT_LE(row.mixtures, 0.01);
    const double least = *std::min_element(row.fixed_error.begin(), row.fixed_error.end());
    EXPECT_LE(row.error, 1.05 * least + 0.0005)
        << "px at the pointer, against the best fixed model";
  }
}

TEST_P(MotionModels, TheFirstFrameAloneIsNearlyAsGood) {
  const auto [count, sigma] = GetParam();
  for (std::size_t truth = 0; truth < kModels.size(); ++truth) {
    SCOPED_TRACE(motion_model_name(kModels[truth]));
    const Row row = row_of(kModels[truth], count, sigma, 1);
    const bool scarce = count == 8;
    EXPECT_GE(row.chosen[truth], scarce && sigma > 0.05 ? 0.92 : 0.95);
    EXPECT_LE(row.larger, 0.03);
    const double least = *std::min_element(row.fixed_error.begin(), row.fixed_error.end());
    EXPECT_LE(row.error, (scarce ? 1.10 : 1.05) * least + 0.0035);
  }
}

INSTANTIATE_TEST_SUITE_P(, MotionModels,
                         ::testing::Values(Setting{8, 0.05}, Setting{20, 0.05}, Setting{40, 0.05},
                                           Setting{8, 0.1}, Setting{20, 0.1}, Setting{40, 0.1}),
                         [](const auto &setting) {
                           return std::to_string(setting.param.count) + "PatchesOf" +
                                  std::to_string(std::lround(1000 * setting.param.sigma)) +
                                  "Millipixels";
                         });

// Twelve points of a region move to the right, eight to the left.
std::vector<GstHapticPatch> two_motions() {
  std::vector<GstHapticPatch> patches;
  for (int i = 0; i < 20; ++i) {
    const int column = i % 5;
    const bool right = column < 3;
    patches.push_back(
        Scenes::patch(6 * column - 12, 7 * (i / 5) - 10, right ? 2 : -2, right ? 0.5 : 0, 0.05));
  }
  return patches;
}

// The shares of the points that move to the right have this sum.
std::vector<GstHapticPatch> shared(std::vector<GstHapticPatch> patches, float right) {
  for (GstHapticPatch &patch : patches)
    patch.share = patch.dx > 0 ? right / 12 : (1 - right) / 8;
  return patches;
}

VelocityEstimate estimate_region(const std::vector<GstHapticPatch> &patches) {
  return estimate_velocity({.patches = patches,
                            .candidates = 20,
                            .pointer_x = kPointerX,
                            .pointer_y = kPointerY,
                            .interval = 1,
                            .region_x = kPointerX - 15,
                            .region_y = kPointerY - 15,
                            .region_width = 30,
                            .region_height = 30},
                           Average::model, ModelChoice::automatic);
}

TEST(Shares, WeighTheMotionsOfARegion) {
  for (const float right : {0.2F, 0.5F, 0.8F}) {
    const VelocityEstimate found = estimate_region(shared(two_motions(), right));
    EXPECT_TRUE(found.mixture);
    EXPECT_NEAR(found.velocity_x, 2 * right - 2 * (1 - right), 0.02) << right;
    EXPECT_NEAR(found.velocity_y, 0.5 * right, 0.02) << right;
  }
}

// The tracker has decided which motion each point follows.
TEST(Shares, OfTwoExactDisplacementsAreTheAnswer) {
  auto patches = two_motions();
  for (GstHapticPatch &patch : patches) {
    const bool is_right = patch.dx > 0;
    patch.dx = is_right ? 3 : -1;
    patch.dy = is_right ? 0.5F : 0;
  }
  for (const float right : {0.2F, 0.6F, 0.9F}) {
    const VelocityEstimate found = estimate_region(shared(patches, right));
    EXPECT_TRUE(found.mixture);
    EXPECT_NEAR(found.velocity_x, 3 * right - (1 - right), 1e-5);
    EXPECT_NEAR(found.velocity_y, 0.5F * right, 1e-5);
    EXPECT_EQ(found.points, 20);
    // The less, the more the shares differ from those of the points, 12 of 20.
    EXPECT_NEAR(found.confidence, 0.7 * std::exp(-std::abs(right - 0.6) * std::hypot(4, 0.5) / 0.7),
                1e-3);
  }
}

std::vector<GstHapticPatch> still_patches(float share) {
  auto patches = two_motions();
  for (GstHapticPatch &patch : patches) {
    patch = Scenes::patch(patch.x - kPointerX, patch.y - kPointerY, 0, 0, 0.05);
    patch.share = share;
  }
  return patches;
}

TEST(Shares, OfTwoPointsThatMoveAlikeCount) {
  for (const float share : {0.0F, 0.05F}) {
    auto patches = still_patches(share);
    patches[7].dx = patches[16].dx = 4;
    EXPECT_NEAR(estimate_region(patches).velocity_x, 8 * share, 0.01);
  }
}

TEST(Shares, OfOnePointThatMovesAloneDoNotCount) {
  auto patches = still_patches(0.05F);
  patches[7].dx = 4;
  patches[16].dx = -4;
  EXPECT_EQ(estimate_region(patches).velocity_x, 0);
}

TEST(Shares, OfLessThanASixteenthDoNotCount) {
  auto patches = still_patches(0.05F);
  patches[7].dx = patches[16].dx = 4;
  patches[7].share = patches[16].share = 0.02F;
  EXPECT_EQ(estimate_region(patches).velocity_x, 0);
}

TEST(Shares, ThatDisagreeWithThePlacesOfThePointsTakeConfidence) {
  const float by_place = estimate_region(two_motions()).velocity_x;
  const float agreeing = estimate_region(shared(two_motions(), by_place / 4 + 0.5F)).confidence;
  const float disagreeing = estimate_region(shared(two_motions(), 0.2F)).confidence;
  EXPECT_NEAR(agreeing, 0.7, 0.05); // of every mixture
  EXPECT_LT(disagreeing, 0.1);
}

TEST(Shares, DoNotChangeOneMotion) {
  std::vector<GstHapticPatch> patches;
  for (int i = 0; i < 20; ++i) {
    patches.push_back(Scenes::patch(6 * (i % 5) - 12, 7 * (i / 5) - 10, 2, 1, 0.05));
    patches.back().share = i == 3 ? 0.9F : 0.005F;
  }
  const VelocityEstimate found = estimate_region(patches);
  EXPECT_FLOAT_EQ(found.velocity_x, 2);
  EXPECT_FLOAT_EQ(found.velocity_y, 1);
  EXPECT_FLOAT_EQ(found.confidence, 1);
}

// Twelve that move and eight at rest, half of them hardly known.
TEST(Tiles, MoveTheRegionByTheirMeanWithoutDoubt) {
  for (const float speed : {2.0F, 10.0F}) {
    auto patches = two_motions();
    for (std::size_t i = 0; i < patches.size(); ++i) {
      patches[i].dx = patches[i].dx > 0 ? speed : 0;
      patches[i].dy = 0;
      if (i % 2 == 0) {
        patches[i].precision_xx /= 100;
        patches[i].precision_yy /= 100;
      }
    }
    const VelocityEstimate found =
        estimate_velocity({.patches = patches, .candidates = 20, .interval = 1, .is_tiled = true},
                          Average::model, ModelChoice::automatic);
    EXPECT_FLOAT_EQ(found.velocity_x, speed * 12.0F / 20);
    EXPECT_FLOAT_EQ(found.velocity_y, 0);
    EXPECT_GT(found.confidence, 0.9F) << speed << " px";
  }
}

TEST(VelocityEstimate, RestIsDoubtfulWhereMuchOfTheRegionChanged) {
  std::vector<GstHapticPatch> patches;
  for (int i = 0; i < 20; ++i) {
    patches.push_back(Scenes::patch(6 * (i % 5) - 12, 7 * (i / 5) - 10, 0, 0, 0.05));
    patches.back().residual = i % 4 == 0 ? 14 : 2;
  }
  const VelocityEstimate found = estimate_region(patches);
  EXPECT_EQ(found.model, MotionModel::still);
  EXPECT_NEAR(found.confidence, 0.7, 0.01);
}

struct Mixtures {
  double recognised = 0;           // share
  std::vector<double> errors;      // px against the mean by area, ascending
  std::vector<double> differences; // px between the two motions
};

// Two translations, 2 px or more apart (at 1 px and 0.1 px of noise a shear explains them), left
// and right of a border that leaves `share` of the region to the left one; patches on a grid of
// side x side, or for side 0 twenty anywhere.
Mixtures mixtures(double share, int side, double sigma) {
  Scenes scenes(7);
  Mixtures result;
  int scenes_seen = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const Motion left = scenes.translation(2, 2);
    const Motion right = scenes.translation(0, 3);
    if (std::hypot(left.x0 - right.x0, left.y0 - right.y0) < 2)
      continue;
    std::vector<GstHapticPatch> patches;
    for (int i = 0; i < (side ? side * side : 20); ++i) {
      const double x = side ? (i % side + 0.5) * 30 / side - 15 : scenes.between(-15, 15);
      const double y = side ? (i / side + 0.5) * 30 / side - 15 : scenes.between(-15, 15);
      patches.push_back(scenes.noisy(x + 15 < 30 * share ? left : right, x, y, sigma));
    }
    const VelocityEstimate found =
        estimate_velocity({patches, static_cast<int>(patches.size()), kPointerX, kPointerY,
                           kInterval, kPointerX - 15, kPointerY - 15, 30, 30},
                          Average::model, ModelChoice::automatic);
    ++scenes_seen;
    result.recognised += found.mixture;
    result.differences.push_back(std::hypot(left.x0 - right.x0, left.y0 - right.y0));
    EXPECT_GT(found.confidence, 0);
    if (found.mixture)
      result.errors.push_back(error_px(found, {share * left.x0 + (1 - share) * right.x0,
                                               share * left.y0 + (1 - share) * right.y0}));
  }
  result.recognised /= scenes_seen;
  std::sort(result.errors.begin(), result.errors.end());
  return result;
}

double mean_of(const std::vector<double> &values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

TEST(MotionMixture, TwoMotionsGiveTheirMeanByArea) {
  for (const auto &[share, side] : {std::pair(0.6, 5), std::pair(0.5, 4), std::pair(0.5, 6)})
    for (const double sigma : {0.05, 0.1}) {
      SCOPED_TRACE(::testing::Message() << share << " of " << side << ", " << sigma << " px");
      const Mixtures found = mixtures(share, side, sigma);
      EXPECT_GE(found.recognised, 0.98);
      EXPECT_LE(mean_of(found.errors), 0.05);
      EXPECT_LE(found.errors[found.errors.size() * 95 / 100], 0.1);
    }
}

TEST(MotionMixture, PatchesAnywhereTellTheBorderAsWellAsTheirSpacingAllows) {
  for (const double share : {0.5, 0.6}) {
    const Mixtures found = mixtures(share, 0, 0.05);
    EXPECT_GE(found.recognised, 0.97);
    EXPECT_LE(mean_of(found.errors), 0.045 * mean_of(found.differences));
  }
}

TEST(MotionMixture, AFewFalseMatchesThatAgreeByChanceAreNone) {
  auto patches = patches_of({2, -1}, 8, 0.02);
  patches[0].dx = patches[1].dx = -5;
  const VelocityEstimate found = estimate(patches, Average::model);
  EXPECT_FALSE(found.mixture);
  EXPECT_NEAR(found.velocity_x * kInterval, 2, 0.05);
}

TEST(MotionModelHistory, AModelChangesWhenItIsClearOrOnTheSecondFrame) {
  // Sixteen patches of known precision: a translation costs 10.6 and gains 16 (d/s)^2.
  const auto scene = [](double gain) {
    std::vector<GstHapticPatch> patches;
    const double d = std::sqrt((10.6 + gain) / 16 * (0.1 * 0.1 + 0.02 * 0.02));
    for (int i = 0; i < 16; ++i)
      patches.push_back(Scenes::patch(6 * (i % 4) - 9, 6 * (i / 4) - 9, d, 0, 0.1));
    return patches;
  };
  const auto next = [&](double gain, haptic::ModelHistory history) {
    const auto patches = scene(gain);
    return estimate_velocity({patches, 16, kPointerX, kPointerY, kInterval}, Average::model,
                             ModelChoice::automatic, history);
  };
  EXPECT_EQ(next(1, {}).model, MotionModel::translation);
  const VelocityEstimate first = next(1, {.current = MotionModel::still});
  EXPECT_EQ(first.model, MotionModel::still) << "not clear";
  EXPECT_EQ(first.velocity_x, 0);
  EXPECT_EQ(next(1, first.history).model, MotionModel::translation) << "for the second time";
  EXPECT_EQ(next(1, next(-1, first.history).history).model, MotionModel::still) << "interrupted";
  EXPECT_EQ(next(3, {.current = MotionModel::still}).model, MotionModel::translation) << "clear";
  EXPECT_EQ(next(-1, {.current = MotionModel::translation}).model, MotionModel::translation);
  EXPECT_EQ(next(-3, {.current = MotionModel::translation}).model, MotionModel::still);
}

TEST(MotionModel, OnePatchOfTheWholeRegionIsATranslationWithFullStanding) {
  std::vector<GstHapticPatch> patch{Scenes::patch(0, 0, 2, -1, 0.02)};
  const VelocityEstimate found = estimate(patch, Average::model);
  EXPECT_EQ(found.model, MotionModel::translation);
  EXPECT_EQ(found.confidence, 1);
  EXPECT_NEAR(found.velocity_x * kInterval, 2, 1e-5);
  patch[0].dx = patch[0].dy = 0.01F;
  EXPECT_EQ(estimate(patch, Average::model).model, MotionModel::still);
}

TEST(MotionModel, TwoPatchesAreATranslationToo) {
  const std::vector<GstHapticPatch> agreeing{Scenes::patch(-5, 0, 2, -1, 0.05),
                                             Scenes::patch(5, 0, 2.02, -1, 0.05)};
  const VelocityEstimate found = estimate(agreeing, Average::model);
  EXPECT_EQ(found.model, MotionModel::translation);
  EXPECT_NEAR(found.velocity_x * kInterval, 2.01, 1e-5);
  EXPECT_EQ(found.confidence, 1);
  const std::vector<GstHapticPatch> apart{Scenes::patch(-5, 0, 6, 0, 0.05),
                                          Scenes::patch(5, 0, -6, 0, 0.05)};
  EXPECT_EQ(estimate(apart, Average::model).confidence, 0);
}

TEST(MotionModel, PatchesOnALineAreNoAffineMotion) {
  Scenes scenes(11);
  for (int trial = 0; trial < 200; ++trial) {
    const Motion motion = scenes.affine();
    std::vector<GstHapticPatch> patches;
    for (int i = 0; i < 20; ++i) {
      const double x = scenes.between(-15, 15);
      patches.push_back(
          Scenes::patch(x, 0, motion.x0 + motion.xx * x, motion.y0 + motion.yx * x, 0.05));
    }
    const VelocityEstimate found = estimate(patches, Average::model);
    EXPECT_LE(found.model, MotionModel::similarity);
    EXPECT_NEAR(error_px(found, motion), 0, 0.03);
  }
}

TEST(MotionModel, LeavesThatNoModelExplainsMoveAsTheirMiddleDoes) {
  for (const double scatter : {0.2, 0.5}) {
    Scenes scenes(8);
    double error = 0;
    double error_of_mean = 0;
    constexpr int kScenes = 300;
    for (int trial = 0; trial < kScenes; ++trial) {
      const Motion motion = scenes.translation(1, 4);
      auto patches = scenes.scene(motion, 20, scatter, 0);
      for (auto &patch : patches)
        patch.precision_xx = patch.precision_yy = 1 / (0.05F * 0.05F);
      const VelocityEstimate found = estimate(patches, Average::model);
      EXPECT_NE(found.model, MotionModel::still);
      error += error_px(found, motion) / kScenes;
      error_of_mean += error_px(estimate(patches, Average::mean), motion) / kScenes;
    }
    EXPECT_LT(error, 1.2 * error_of_mean);
  }
}

TEST(MotionModel, ConfidenceFallsWithThePredictedDeviation) {
  const auto confidence = [](float xx, float yy) {
    auto patch = Scenes::patch(0, 0, 2, -1, 1);
    patch.precision_xx = xx;
    patch.precision_yy = yy;
    return estimate({patch}, Average::model).confidence;
  };
  const auto of = [](double sigma) { return static_cast<float>(1 / (sigma * sigma)); };
  EXPECT_EQ(confidence(of(0.09), of(0.09)), 1);
  EXPECT_NEAR(confidence(of(0.3), of(0.3)), 0.5, 0.01);
  EXPECT_EQ(confidence(of(0.51), of(0.51)), 0);
  EXPECT_NEAR(confidence(of(0.02), of(0.29)), 0.52, 0.01) << "the worse direction counts";
  EXPECT_EQ(confidence(of(0.15), of(0.51)), 0);
}

// Of an edge whose normal is at `angle`: along it the patch moves anyhow.
GstHapticPatch edge(Scenes &scenes, const Motion &motion, double angle, double sigma,
                    double precision_along = 0) {
  const double nx = std::cos(angle);
  const double ny = std::sin(angle);
  const double across = motion.x0 * nx + motion.y0 * ny + sigma * scenes.between(-1.7, 1.7);
  const double along = scenes.between(-1, 1);
  GstHapticPatch patch = Scenes::patch(scenes.between(-15, 15), scenes.between(-15, 15),
                                       across * nx - along * ny, across * ny + along * nx, sigma);
  const double p = 1 / (sigma * sigma);
  patch.precision_xx = static_cast<float>(p * nx * nx + precision_along * ny * ny);
  patch.precision_xy = static_cast<float>((p - precision_along) * nx * ny);
  patch.precision_yy = static_cast<float>(p * ny * ny + precision_along * nx * nx);
  return patch;
}

TEST(MotionAperture, AnEdgeIsFeltAcrossItAndSaysSo) {
  Scenes scenes(3);
  for (const int count : {1, 2, 8, 20})
    for (const double precision_along : {0.0, 0.02, 0.2})
      for (int trial = 0; trial < 100; ++trial) {
        const Motion motion = scenes.translation(1, 4);
        // Not so nearly along the motion that the rest is too small to tell from noise.
        const double angle = std::atan2(motion.y0, motion.x0) + scenes.between(-1.2, 1.2);
        std::vector<GstHapticPatch> patches;
        for (int i = 0; i < count; ++i)
          patches.push_back(edge(scenes, motion, angle, 0.02, precision_along));
        const VelocityEstimate found = estimate(patches, Average::model);
        EXPECT_TRUE(found.aperture);
        EXPECT_GT(found.confidence, 0.5);
        const double vx = found.velocity_x * kInterval;
        const double vy = found.velocity_y * kInterval;
        EXPECT_NEAR(-vx * std::sin(angle) + vy * std::cos(angle), 0, 0.05) << "along";
        EXPECT_NEAR((vx - motion.x0) * std::cos(angle) + (vy - motion.y0) * std::sin(angle), 0,
                    0.05)
            << "across";
      }
}

TEST(MotionAperture, EdgesOfDifferentDirectionsTellTheWholeVelocity) {
  Scenes scenes(4);
  for (int trial = 0; trial < 300; ++trial) {
    const Motion motion = scenes.translation(1, 4);
    std::vector<GstHapticPatch> patches;
    for (int i = 0; i < 20; ++i)
      patches.push_back(edge(scenes, motion, scenes.between(0, std::numbers::pi), 0.02));
    const VelocityEstimate found = estimate(patches, Average::model);
    EXPECT_FALSE(found.aperture);
    EXPECT_NEAR(error_px(found, motion), 0, 0.05);
    EXPECT_GT(found.confidence, 0.5);
  }
}

struct Judged {
  float confidence;
  double error; // px
};

// Twenty patches, up to 60 % of them false matches, as precise as 0.01 to 1 px.
std::vector<Judged> judged_scenes() {
  Scenes scenes(5);
  std::vector<Judged> judged;
  for (int trial = 0; trial < 20000; ++trial) {
    const Motion motion = scenes.translation(0.3, 4);
    const double sigma = std::pow(10, scenes.between(-2, 0));
    const VelocityEstimate found =
        estimate(scenes.scene(motion, 20, sigma, scenes.between(0, 0.6)), Average::model);
    judged.push_back({found.confidence, error_px(found, motion)});
  }
  return judged;
}

TEST(MotionConfidence, TheHigherTheFewerErrors) {
  // The last are those of full confidence alone.
  std::array<int, 6> scenes{};
  std::array<int, 6> wrong{};
  for (const Judged &scene : judged_scenes()) {
    const auto bin = static_cast<std::size_t>(5 * scene.confidence);
    ++scenes[bin];
    wrong[bin] += scene.error > 0.15;
  }
  double before = 1;
  for (std::size_t bin = 0; bin < scenes.size(); ++bin) {
    ASSERT_GT(scenes[bin], 200);
    const double share = double(wrong[bin]) / scenes[bin];
    EXPECT_LT(share, before) << bin;
    RecordProperty("wrong" + std::to_string(bin), std::to_string(share));
    before = share;
  }
}

TEST(MotionConfidence, TellsGrossErrorsFromTheRest) {
  auto scenes = judged_scenes();
  std::sort(scenes.begin(), scenes.end(),
            [](const Judged &a, const Judged &b) { return a.confidence < b.confidence; });
  // Area under the curve: how often a gross error has the lower confidence of two; a tie is half.
  double good_below = 0, area = 0, bad = 0;
  for (std::size_t i = 0; i < scenes.size();) {
    double good_here = 0, bad_here = 0;
    const float confidence = scenes[i].confidence;
    for (; i < scenes.size() && scenes[i].confidence == confidence; ++i)
      (scenes[i].error > 0.3 ? bad_here : good_here) += 1;
    area += bad_here * (good_below + good_here / 2);
    good_below += good_here;
    bad += bad_here;
  }
  EXPECT_GE(1 - area / (bad * good_below), 0.95);
}

TEST(MotionMixture, AStationaryMixtureDoesNotFlipFlop) {
  for (const double share : {0.5, 0.6})
    for (const double sigma : {0.05, 0.1})
      for (unsigned seed = 0; seed < 20; ++seed) {
        Scenes scenes(seed);
        const Motion left{2, 0};
        const Motion right{-1, 1};
        const Motion mean{share * left.x0 + (1 - share) * right.x0, (1 - share) * right.y0};
        haptic::ModelHistory history;
        double error = 0;
        VelocityEstimate before;
        constexpr int kFrames = 200;
        for (int frame = 0; frame < kFrames; ++frame) {
          std::vector<GstHapticPatch> patches;
          for (int i = 0; i < 25; ++i) {
            const double x = i % 5 * 6 - 12;
            const double y = i / 5 * 6 - 12;
            patches.push_back(scenes.noisy(x + 15 < 30 * share ? left : right, x, y, sigma));
          }
          const VelocityEstimate found =
              estimate_velocity({patches, 25, kPointerX, kPointerY, kInterval,
                                 kPointerX - 15 - (share == 0.5 ? 3 : 0), kPointerY - 15, 30, 30},
                                Average::model, ModelChoice::automatic, history);
          history = found.history;
          EXPECT_TRUE(found.mixture);
          error += error_px(found, mean) / kFrames;
          if (frame > 0) {
            EXPECT_LE(std::hypot(found.velocity_x - before.velocity_x,
                                 found.velocity_y - before.velocity_y) *
                          kInterval,
                      0.3);
          }
          before = found;
        }
        EXPECT_LE(error, 0.10) << share << ", " << sigma << " px";
      }
}

// The metadata is public: another program writes what it likes.
TEST(MotionModel, APrecisionWithoutAnErrorEllipseCountsAsUnknown) {
  auto patches = patches_of({2, -1}, 20, 3);
  const VelocityEstimate unknown = estimate(patches, Average::model);
  for (GstHapticPatch &patch : patches) {
    patch.precision_xy = 0.5F;
    patch.precision_yy = 1; // one eigenvalue is negative
  }
  const VelocityEstimate found = estimate(patches, Average::model);
  EXPECT_EQ(found.velocity_x, unknown.velocity_x);
  EXPECT_EQ(found.velocity_y, unknown.velocity_y);
  EXPECT_EQ(found.confidence, unknown.confidence);
}

// An edge with rounded numbers: xy^2 is a little more than xx yy.
TEST(MotionModel, ARoundedPrecisionOfAnEdgeIsThatOfTheEdge) {
  auto patches = patches_of({2, 0}, 20);
  for (GstHapticPatch &patch : patches) {
    patch.precision_xx = 100;
    patch.precision_xy = 10.001F;
    patch.precision_yy = 1;
  }
  EXPECT_TRUE(estimate(patches, Average::model).aperture);
}

TEST(MotionModel, APatchThatIsNotANumberIsLeftOut) {
  auto patches = patches_of({2, -1}, 20);
  patches[3].dx = std::numeric_limits<float>::quiet_NaN();
  patches[4].y = std::numeric_limits<float>::infinity();
  patches[5].dy = std::numeric_limits<float>::max();
  patches[6].precision_xy = std::numeric_limits<float>::quiet_NaN();
  const VelocityEstimate found = estimate(patches, Average::model);
  EXPECT_NEAR(found.velocity_x * kInterval, 2, 1e-5);
  EXPECT_EQ(found.points, 17);
}

} // namespace velocity_estimate_test
