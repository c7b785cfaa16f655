// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-frames.hpp"
#include "patches/block-translation.hpp"
#include "patches/texture-period.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <random>

namespace block_translation_test {

using haptic::Displacement;
using haptic::Plane;
using haptic::Translation;
using test::Frame;
using test::Texture;

constexpr int kSide = 80;
constexpr float kNoise = 1.5F * 1.5F;

Frame painted(const auto &grey) {
  Frame frame(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      frame.at(x, y) = static_cast<std::uint8_t>(std::lround(128 + grey(x, y)));
  return frame;
}

// Waves of this period along x and along y, moved along x.
Frame lattice(double period, double shift) {
  const double number = 2 * std::numbers::pi / period;
  return painted([&](int x, int y) {
    return 40 * std::sin(number * (x - shift)) + 40 * std::sin(number * y);
  });
}

class BlockTranslation : public ::testing::Test {
protected:
  void set(const Frame &before, const Frame &after) {
    haptic::smooth(test::view_of(before), earlier);
    haptic::smooth(test::view_of(after), later);
    grid->cover(earlier, {24, 24, 32, 32}, 4, 4, 8, true);
  }
  Translation translate(Displacement start = {}) {
    return haptic::translate_blocks(later, grid->view(), start, 10, kNoise, true);
  }

  std::unique_ptr<haptic::PatchGrid> grid = std::make_unique<haptic::PatchGrid>();
  Plane earlier;
  Plane later;
};

TEST_F(BlockTranslation, FindsTheTranslationOfAllBlocks) {
  std::mt19937 random(1);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Texture texture(seed);
    Frame before = texture.frame(kSide, kSide, {});
    Frame after = texture.frame(kSide, kSide, {0.9, -0.6});
    test::add_noise(before, 1.5, random);
    test::add_noise(after, 1.5, random);
    set(before, after);
    const Translation whole = translate();
    EXPECT_NEAR(whole.displacement.x, 0.9, 0.05) << seed;
    EXPECT_NEAR(whole.displacement.y, -0.6, 0.05) << seed;
    EXPECT_EQ(whole.pixels, 16 * 64);
    EXPECT_FALSE(whole.one_direction);
    EXPECT_TRUE(haptic::explains(whole, 8, kNoise)) << seed;
    EXPECT_TRUE(haptic::is_precise(whole));
    EXPECT_FALSE(haptic::is_still(whole, kNoise));
  }
}

TEST_F(BlockTranslation, NoiseAloneIsStill) {
  std::mt19937 random(2);
  int moving = 0;
  for (int i = 0; i < 100; ++i) {
    Frame before = Texture(3).frame(kSide, kSide, {});
    Frame after = before;
    test::add_noise(before, 1.5, random);
    test::add_noise(after, 1.5, random);
    set(before, after);
    moving += !haptic::is_still(translate(), kNoise);
  }
  EXPECT_LE(moving, 2);
}

TEST_F(BlockTranslation, TwoMotionsAreNotExplained) {
  const Texture left(4);
  const Texture right(5);
  Frame before = left.frame(kSide, kSide, {});
  Frame after = left.frame(kSide, kSide, {1, 0});
  right.paint(before, {}, kSide / 2);
  right.paint(after, {-1, 0.5}, kSide / 2);
  set(before, after);
  EXPECT_FALSE(haptic::explains(translate(), 8, kNoise));
}

TEST_F(BlockTranslation, EdgesOfOneDirectionGiveTheMotionAcrossThem) {
  const auto stripes = [](double shift) {
    return painted([&](int x, int) {
      return 40 * std::sin(0.7 * (x - shift)) + 20 * std::sin(0.23 * (x - shift) + 1);
    });
  };
  set(stripes(0), stripes(0.8));
  const Translation whole = translate({0, 3});
  EXPECT_TRUE(whole.one_direction);
  EXPECT_NEAR(whole.displacement.x, 0.8, 0.05);
  EXPECT_NEAR(whole.displacement.y, 0, 0.05); // the start along the edges is dropped
  const haptic::Patch patch = haptic::patch_of({24, 24, 32, 32}, whole);
  EXPECT_GT(patch.precision_xx, 100);
  EXPECT_LT(patch.precision_yy, 1e-3F * patch.precision_xx);
  EXPECT_EQ(patch.x, 40);
  EXPECT_EQ(patch.width, 32);
}

TEST_F(BlockTranslation, BlocksOutsideTheFrameDoNotCount) {
  const Frame frame = Texture(6).frame(kSide, kSide, {});
  set(frame, frame);
  grid->cover(earlier, {46, 24, 32, 32}, 4, 4, 8, false);
  const Translation whole = haptic::translate_blocks(later, grid->view(), {6, 0}, 0, kNoise, false);
  EXPECT_EQ(whole.pixels, 12 * 64); // the last of four columns is beyond the border
}

TEST_F(BlockTranslation, APeriodIsThatOfTheOneFrequencyInTheTexture) {
  for (const double period : {6.0, 9.0, 13.0}) {
    const Frame frame = lattice(period, 0);
    set(frame, frame);
    EXPECT_NEAR(haptic::texture_period(earlier, grid->view(), 20), period, 0.1 * period);
    EXPECT_EQ(haptic::texture_period(earlier, grid->view(), static_cast<float>(period) - 2), 0);
  }
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Frame frame = Texture(seed).frame(kSide, kSide, {});
    set(frame, frame);
    EXPECT_EQ(haptic::texture_period(earlier, grid->view(), 20), 0) << seed;
  }
}

TEST_F(BlockTranslation, ARepeatingTextureFollowsTheMotionBefore) {
  set(lattice(9, 0), lattice(9, 1));
  const auto resolve = [&](Displacement last, Translation &whole) {
    return haptic::resolve_period(earlier, later, grid->view(), 20, last, kNoise, whole);
  };
  Translation whole = translate({10, 0}); // a period too far
  EXPECT_NEAR(whole.displacement.x, 10, 0.2);
  EXPECT_TRUE(resolve({0.5F, 0}, whole));
  EXPECT_NEAR(whole.displacement.x, 1, 0.2);
  // Almost half a period: it may as well have moved the other way.
  set(lattice(9, 0), lattice(9, 4));
  whole = translate();
  EXPECT_FALSE(resolve({}, whole));
}

TEST_F(BlockTranslation, ATextureThatDoesNotRepeatIsLeftAlone) {
  set(Texture(7).frame(kSide, kSide, {}), Texture(7).frame(kSide, kSide, {2, 1}));
  Translation whole = translate({1.5F, 1});
  const Displacement before = whole.displacement;
  EXPECT_TRUE(haptic::resolve_period(earlier, later, grid->view(), 20, {-9, 9}, kNoise, whole));
  EXPECT_EQ(whole.displacement.x, before.x);
  EXPECT_EQ(whole.displacement.y, before.y);
}

} // namespace block_translation_test
