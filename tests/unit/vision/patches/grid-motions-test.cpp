// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-frames.hpp"
#include "patches/grid-motions.hpp"

#include <array>
#include <gtest/gtest.h>

namespace grid_motions_test {

using haptic::Alignment;
using haptic::BentMotion;
using haptic::Displacement;
using haptic::PatchGrid;
using haptic::Plane;

// Patches of a texture with these displacements, which all fit.
class GridMotions : public ::testing::Test {
protected:
  GridMotions() {
    haptic::smooth(test::view_of(test::Texture(1).frame(100, 100, {})), plane_);
    grid_.cover(plane_, {20, 20, 45, 45}, 3, 3, 8, true);
  }
  void move(const BentMotion &motion) {
    for (std::size_t i = 0; i < aligned_.size(); ++i) {
      aligned_[i].displacement = motion.at(haptic::middle_of(grid_.patches[i]));
      aligned_[i].fit.inside = true;
      aligned_[i].fit.correlation = 1;
    }
  }
  std::optional<BentMotion> found(float most) {
    return haptic::find_bent_motion(grid_.view(), aligned_, most);
  }

  Plane plane_;
  PatchGrid grid_;
  std::array<Alignment, 9> aligned_;
  const BentMotion turn_{{40, 40}, {1.5F, -0.5F}, {0.01F, -0.08F, 0.08F, 0.01F}};
};

TEST_F(GridMotions, AnAffineMotionIsFoundFromItsPatches) {
  move(turn_);
  const auto motion = found(0.3F);
  ASSERT_TRUE(motion);
  EXPECT_TRUE(motion->is_bent());
  for (const Displacement place : {Displacement{40, 40}, {22, 61}, {60, 30}}) {
    EXPECT_NEAR(motion->at(place).x, turn_.at(place).x, 0.05);
    EXPECT_NEAR(motion->at(place).y, turn_.at(place).y, 0.05);
  }
}

TEST_F(GridMotions, AShiftIsNotBent) {
  move({{}, {2, 1}, {}});
  const auto motion = found(0.3F);
  ASSERT_TRUE(motion);
  EXPECT_FALSE(motion->is_bent());
}

TEST_F(GridMotions, APatchThatContradictsLeavesNoMotion) {
  move(turn_);
  aligned_[4].displacement += {2, 0};
  EXPECT_FALSE(found(1));
}

TEST_F(GridMotions, WithoutTrustThereIsNone) {
  move(turn_);
  for (std::size_t i = 0; i < 4; ++i)
    aligned_[i].fit.correlation = 0.3F;
  EXPECT_FALSE(found(1));
}

TEST_F(GridMotions, TheSamePlaceMovesAlikeInAFinerPlane) {
  const BentMotion finer = turn_.finer(2);
  // The middle of a pixel is the corner of its four parts.
  const Displacement moved = finer.at({2 * 30 + 0.5F, 2 * 50 + 0.5F});
  EXPECT_FLOAT_EQ(moved.x, 2 * turn_.at({30, 50}).x);
  EXPECT_FLOAT_EQ(moved.y, 2 * turn_.at({30, 50}).y);
}

TEST(CommonestDisplacement, IsTheMeanOfMostPatchesThatFit) {
  std::array<GstHapticPatch, 7> patches{};
  for (std::size_t i = 0; i < patches.size(); ++i) {
    patches[i].dx = i < 4 ? 2 : -3;
    patches[i].dy = i % 2 == 0 ? 0.1F : -0.1F;
  }
  const auto first = haptic::commonest_of(patches, {});
  ASSERT_TRUE(first);
  EXPECT_NEAR(first->x, 2, 1e-5);
  EXPECT_NEAR(first->y, 0, 1e-5);
  const auto second = haptic::commonest_of(patches, first);
  ASSERT_TRUE(second);
  EXPECT_NEAR(second->x, -3, 1e-5);
  for (std::size_t i = 0; i < 4; ++i)
    patches[i].residual = 10;
  EXPECT_NEAR(haptic::commonest_of(patches, {})->x, -3, 1e-5);
  for (GstHapticPatch &patch : patches)
    patch.dx = 2;
  EXPECT_FALSE(haptic::commonest_of(patches, Displacement{2, 0}));
}

} // namespace grid_motions_test
