// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patches/clipped-pixels.hpp"

#include <gtest/gtest.h>

namespace clipped_pixels_test {

TEST(ClippedPixels, AKeptPixelOfMeanGreyLevelHasItsWeight) {
  constexpr int kSide = 40;
  constexpr int kClipped = 24; // first row
  constexpr std::uint8_t kStripes[] = {60, 100, 140, 100};
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      pixels.push_back(y < kClipped ? kStripes[x % 4] : 255);
  const haptic::LumaView view{pixels.data(), kSide, kSide, kSide};
  haptic::Plane plane;
  haptic::smooth(view, plane);
  haptic::Template patch;
  patch.x = 8;
  patch.y = 14;
  haptic::prepare_templates(plane, {&patch, 1});
  haptic::ClippedPixels clipped;
  clipped.find(view, {4, 4, 30, 30});
  clipped.mask(patch);

  ASSERT_EQ(patch.seen, 48); // six rows of eight; half of them have the mean grey level
  haptic::Fit fit;
  haptic::fit_templates(plane, {&patch, 1}, {}, {&fit, 1});
  EXPECT_NEAR(fit.correlation, 1, 1e-4);
  EXPECT_NEAR(fit.residual, 0, 0.1);
}

} // namespace clipped_pixels_test
