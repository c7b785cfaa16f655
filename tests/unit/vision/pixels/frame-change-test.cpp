// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-frames.hpp"
#include "pixels/frame-change.hpp"

#include <gtest/gtest.h>
#include <random>

namespace frame_change_test {

using haptic::Change;
using test::Frame;
using test::Texture;

constexpr int kSide = 30;
constexpr float kNoise = 1.5F * 1.5F;

haptic::ChangeFinding find(const Frame &before, const Frame &after) {
  return haptic::find_change(test::view_of(before), test::view_of(after), kNoise);
}

Frame noisy(Frame frame, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  test::add_noise(frame, sigma, random);
  return frame;
}

TEST(FrameChange, EqualPixelsAreNoChange) {
  const Frame frame = Texture(1).frame(kSide, kSide, {});
  const auto [change, energy] = find(frame, frame);
  EXPECT_EQ(change, Change::none);
  EXPECT_EQ(energy, 0);
}

TEST(FrameChange, NoiseOnTextureIsNoChange) {
  const Frame scene = Texture(2).frame(kSide, kSide, {});
  int changes = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const auto [change, energy] =
        find(noisy(scene, 1.5, 2 * seed), noisy(scene, 1.5, 2 * seed + 1));
    changes += change != Change::none;
    EXPECT_NEAR(energy, 2 * kNoise, 0.3 * 2 * kNoise); // the noise of both frames
  }
  EXPECT_LE(changes, 2);
}

TEST(FrameChange, NoiseOnABlankWallCouldHideAMotion) {
  const Frame wall(kSide, kSide, 120);
  for (unsigned seed = 0; seed < 50; ++seed)
    EXPECT_EQ(find(noisy(wall, 1.5, 2 * seed), noisy(wall, 1.5, 2 * seed + 1)).change,
              Change::unseen);
}

TEST(FrameChange, AFractionOfAPixelIsAChange) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Texture texture(seed);
    const Frame before = noisy(texture.frame(kSide, kSide, {}), 1.5, seed);
    const Frame after = noisy(texture.frame(kSide, kSide, {0.2, -0.1}), 1.5, seed + 100);
    EXPECT_EQ(find(before, after).change, Change::some) << seed;
  }
}

TEST(FrameChange, AMotionBelowTheNoiseIsSeenInTheGradients) {
  // Low contrast: the differences are as small as those of noise, but they follow the gradients.
  const Texture texture(3, 5, 12);
  const Frame before = noisy(texture.frame(kSide, kSide, {}), 0.7, 1);
  const Frame after = noisy(texture.frame(kSide, kSide, {0.3, 0}), 0.7, 2);
  const auto [change, energy] = find(before, after);
  EXPECT_EQ(change, Change::some);
  EXPECT_LT(energy, 2 * 1.3F * kNoise);
}

TEST(FrameChange, AnOffsetOfAllPixelsHasNoEnergy) {
  const Frame before = Texture(4, 5, 20).frame(kSide, kSide, {});
  Frame after = before;
  for (auto &pixel : after.pixels)
    pixel = static_cast<std::uint8_t>(pixel + 3);
  EXPECT_NEAR(find(before, after).energy, 0, 1e-3);
}

TEST(FrameChange, MoreThanTheNoiseIsAChange) {
  const Frame scene = Texture(5).frame(kSide, kSide, {});
  EXPECT_EQ(find(noisy(scene, 3, 1), noisy(scene, 3, 2)).change, Change::some);
}

TEST(Combing, IsSeenWhereEveryOtherRowHasMoved) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    Frame woven = Texture(seed, 3, 45).frame(kSide, kSide, {});
    const Frame whole = noisy(woven, 1.5, seed);
    Frame later = Texture(seed, 3, 45).frame(kSide, kSide, {3, 0});
    for (int y = 1; y < kSide; y += 2)
      for (int x = 0; x < kSide; ++x)
        woven.at(x, y) = later.at(x, y);
    EXPECT_TRUE(haptic::is_combed(test::view_of(noisy(woven, 1.5, seed)), kNoise)) << seed;
    EXPECT_FALSE(haptic::is_combed(test::view_of(whole), kNoise)) << seed;
  }
}

TEST(Combing, IsSeenInAnAreaOfAnySize) {
  Frame combed(1600, 1600);
  for (int y = 1; y < combed.height; y += 2)
    for (int x = 0; x < combed.width; ++x)
      combed.at(x, y) = 255;
  EXPECT_TRUE(haptic::is_combed(test::view_of(combed), kNoise));
}

TEST(Combing, IsNotSeenInNoise) {
  for (unsigned seed = 0; seed < 50; ++seed)
    EXPECT_FALSE(
        haptic::is_combed(test::view_of(noisy(Frame(kSide, kSide, 120), 1, seed)), kNoise));
}

} // namespace frame_change_test
