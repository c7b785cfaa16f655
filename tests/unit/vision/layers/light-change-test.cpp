// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/light-change.hpp"

#include "layer-scene.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace light_change_test {

using haptic::LayerFrame;
using haptic::LightChange;
using test::kCropSide;
using test::kCropSize;

LayerFrame drawn(const test::LayerScene &scene, test::Shift sky, test::Shift leaf, double light) {
  test::Frame frame = scene.draw(kCropSide, kCropSide, sky, leaf);
  for (std::uint8_t &pixel : frame.pixels)
    pixel = static_cast<std::uint8_t>(std::lround(pixel * light));
  LayerFrame loaded;
  haptic::load_luma(test::view_of(frame), kCropSize, loaded);
  return loaded;
}

// rms over the pixels, grey levels
double difference(const LayerFrame &one, const LayerFrame &other) {
  double sum = 0;
  for (int y = 0; y < kCropSide; ++y)
    for (int x = 0; x < kCropSide; ++x) {
      const double of_pixel = one.luma.at(x, y) - other.luma.at(x, y);
      sum += of_pixel * of_pixel;
    }
  return std::sqrt(sum) / kCropSide;
}

constexpr double kRounding = 0.5; // grey levels, of two roundings and a factor

TEST(LightChange, WhatIsBrighterByOneFactorBecomesAsItWas) {
  const test::LayerScene scene;
  const LayerFrame first = drawn(scene, {}, {}, 1);
  LayerFrame before = first;
  LightChange light;
  for (const double factor : {0.98, 0.96, 0.97, 0.9}) {
    LayerFrame frame = drawn(scene, {}, {}, factor);
    light.take_out(before.mean, true, kCropSize, frame);
    EXPECT_LT(difference(frame, first), kRounding) << factor;
    before = frame;
  }
}

TEST(LightChange, ALeafThatMovesMeanwhileChangesNothingElse) {
  const test::LayerScene scene;
  const LayerFrame before = drawn(scene, {}, {}, 1);
  const LayerFrame moved = drawn(scene, {}, {3, 1}, 1);
  LayerFrame frame = moved;
  LightChange light;
  light.take_out(before.mean, true, kCropSize, frame);
  EXPECT_EQ(difference(frame, moved), 0);
  LayerFrame darker = drawn(scene, {}, {3, 1}, 0.97);
  light.take_out(before.mean, true, kCropSize, darker);
  EXPECT_LT(difference(darker, moved), kRounding);
}

TEST(LightChange, APanKeepsTheFactorThatWasFoundBefore) {
  const test::LayerScene scene;
  LightChange light;
  LayerFrame frame = drawn(scene, {}, {}, 0.95);
  light.take_out(drawn(scene, {}, {}, 1).mean, true, kCropSize, frame);
  LayerFrame panned = drawn(scene, {9, 4}, {9, 4}, 0.95);
  light.take_out(frame.mean, false, kCropSize, panned);
  EXPECT_LT(difference(panned, drawn(scene, {9, 4}, {9, 4}, 1)), kRounding);
}

TEST(LightChange, ACutToBlackAndBackIsNoLight) {
  const test::LayerScene scene;
  const LayerFrame first = drawn(scene, {}, {}, 1);
  LightChange light;
  LayerFrame before = first;
  for (const double factor : {0.9, 0.0, 0.0, 1.0, 1.0}) {
    LayerFrame frame = drawn(scene, {}, {}, factor);
    light.take_out(before.mean, true, kCropSize, frame);
    before = frame;
  }
  EXPECT_EQ(difference(before, first), 0);
}

TEST(LightChange, AFadeToBlackIsNotMadeBrightAgain) {
  const test::LayerScene scene;
  LightChange light;
  LayerFrame before = drawn(scene, {}, {}, 1);
  LayerFrame frame = before;
  for (double factor = 0.9; factor > 0.2; factor *= 0.9) {
    frame = drawn(scene, {}, {}, factor);
    light.take_out(before.mean, true, kCropSize, frame);
    before = frame;
  }
  const LayerFrame dark = drawn(scene, {}, {}, 0.2059); // 0.9 to the power of 15
  EXPECT_LT(frame.mean.at(1, 1), 2.01F * dark.mean.at(1, 1));
}

TEST(LightChange, TheContrastComesBackWhileTheLightStays) {
  const test::LayerScene scene;
  const LayerFrame dark = drawn(scene, {}, {}, 0.6);
  LayerFrame before = drawn(scene, {}, {}, 1);
  LayerFrame frame = before;
  LightChange light;
  for (int n = 0; n < 60 * 60; ++n) { // a minute
    frame = dark;
    light.take_out(before.mean, true, kCropSize, frame);
    EXPECT_LT(difference(frame, before), kRounding);
    before = frame;
  }
  EXPECT_NEAR(frame.mean.at(1, 1), dark.mean.at(1, 1), 0.15 * dark.mean.at(1, 1));
}

} // namespace light_change_test
