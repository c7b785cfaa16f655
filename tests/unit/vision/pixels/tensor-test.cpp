// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pixels/tensor.hpp"

#include <gtest/gtest.h>
#include <random>

namespace tensor_test {

using haptic::Displacement;
using haptic::Tensor;

TEST(Tensor, DisplacementsAddSubtractAndScale) {
  const Displacement a{1, 2};
  const Displacement b{-3, 5};
  EXPECT_EQ((a + b).x, -2);
  EXPECT_EQ((a + b).y, 7);
  EXPECT_EQ((a - b).x, 4);
  EXPECT_EQ((a - b).y, -3);
  EXPECT_EQ((2 * a).y, 4);
  EXPECT_EQ(dot(a, b), 7);
  EXPECT_EQ(norm2(b), 34);
}

TEST(Tensor, SolveInvertsTheTensorWithItsRidge) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> number(-3, 3);
  for (int i = 0; i < 100; ++i) {
    const float a = number(random);
    const float b = number(random);
    const Tensor t{a * a, a * b, b * b}; // only one eigenvalue is not zero
    const float ridge = 0.5F;
    const Displacement right{number(random), number(random)};
    const Displacement d = solve(t, right, ridge);
    EXPECT_NEAR((t.xx + ridge) * d.x + t.xy * d.y, right.x, 1e-4);
    EXPECT_NEAR(t.xy * d.x + (t.yy + ridge) * d.y, right.y, 1e-4);
  }
}

TEST(Tensor, EigenvaluesAreTheExtremesOfTheQuadraticForm) {
  for (const Tensor t : {Tensor{4, 0, 1}, {1, 0, 4}, {3, 2, 3}, {5, -1.5F, 2}, {2, 0, 2}}) {
    const auto [least, most] = eigenvalues(t);
    EXPECT_NEAR(least + most, t.xx + t.yy, 1e-5);
    EXPECT_NEAR(least * most, t.xx * t.yy - t.xy * t.xy, 1e-5);
    const Displacement strong = strong_direction(t);
    EXPECT_NEAR(norm2(strong), 1, 1e-6);
    EXPECT_NEAR(quadratic(t, strong), most, 1e-5);
    EXPECT_NEAR(quadratic(t, {-strong.y, strong.x}), least, 1e-5);
  }
}

TEST(Tensor, TheStrongPartKnowsNothingAcross) {
  const Tensor t{5, -1.5F, 2};
  const Tensor strong = strong_part(t);
  const Displacement along = strong_direction(t);
  EXPECT_NEAR(quadratic(strong, along), eigenvalues(t).most, 1e-5);
  EXPECT_NEAR(quadratic(strong, {-along.y, along.x}), 0, 1e-5);
  EXPECT_NEAR(strong_part(Tensor{}).xx, 0, 1e-6);
}

} // namespace tensor_test
