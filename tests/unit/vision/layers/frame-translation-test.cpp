// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/frame-translation.hpp"

#include "plane-source.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <memory>
#include <utility>
#include <vector>

namespace frame_translation_test {

using haptic::FrameMotion;
using test::Frame;
using test::PlaneSource;
using test::Shift;

constexpr int kWidth = 320;
constexpr int kHeight = 180;

void expect_pan(const FrameMotion &found, double x, double y, double tolerance) {
  EXPECT_NEAR(found.displacement.x, x, tolerance);
  EXPECT_NEAR(found.displacement.y, y, tolerance);
  EXPECT_GT(found.certainty, 0.9F);
}

class FrameTranslationTest : public ::testing::Test {
protected:
  FrameMotion follow(const Frame &earlier, const Frame &later, haptic::Displacement other = {}) {
    const PlaneSource before(earlier);
    const PlaneSource after(later);
    return translation->follow({before, after, kWidth, kHeight}, 1.0F / 60, 0, other);
  }

  // After some frames of a camera that pans by so much in each.
  FrameMotion pan(Shift by, int frames = 6, haptic::Displacement other = {}) {
    FrameMotion found;
    for (int i = 0; i + 1 < frames; ++i)
      found = follow(scene.frame(kWidth, kHeight, {by.x * i, by.y * i}),
                     scene.frame(kWidth, kHeight, {by.x * (i + 1), by.y * (i + 1)}), other);
    return found;
  }

  test::Texture scene{5, 8};
  std::unique_ptr<haptic::FrameTranslation> translation =
      std::make_unique<haptic::FrameTranslation>();
};

TEST_F(FrameTranslationTest, ACameraThatPansMovesTheFrame) {
  expect_pan(pan({1.3, -0.4}), 1.3, -0.4, 0.03);
}

TEST_F(FrameTranslationTest, AFastPanIsFoundFromTheMotionOfARegion) {
  expect_pan(pan({11, 3}, 6, {11.5F, 2.5F}), 11, 3, 0.05);
}

// A coder lets the soft parts of a pan stand.
TEST_F(FrameTranslationTest, PartsThatStandDoNotSlowThePanThatMostOfTheFrameShows) {
  const test::Texture soft{9, 24};
  FrameMotion found;
  for (int i = 0; i < 30; ++i) {
    const auto draw = [&](double x) {
      Frame frame = scene.frame(kWidth, kHeight, {x, 0});
      soft.paint(frame, {}, 0, kWidth * 2 / 5);
      return frame;
    };
    found = follow(draw(0.9 * i), draw(0.9 * (i + 1)));
  }
  expect_pan(found, 0.9, 0, 0.03);
}

// A third of the frame moves the other way; what says more is the frame.
TEST_F(FrameTranslationTest, ThingsThatMoveAlikeDoNotKeepThePanFromBeingFound) {
  const test::Texture things{6, 8};
  FrameMotion found;
  double camera = 0;
  for (int i = 0; i < 150; ++i) {
    const auto draw = [&](double x, double by) {
      Frame frame = scene.frame(kWidth, kHeight, {x, 0});
      things.paint(frame, {by, 0}, 110, 210);
      return frame;
    };
    const double pan = i < 30 ? 0 : -2;
    found = follow(draw(camera, 2.0 * i), draw(camera + pan, 2.0 * (i + 1)));
    camera += pan;
  }
  expect_pan(found, -2, 0, 0.05);
}

// Textured squares before a blank sky, displaced by whole pixels.
Frame squares(const std::vector<std::pair<int, int>> &corners, int moved) {
  constexpr int kSide = 44;
  const Frame texture = test::Texture(6, 8).frame(kWidth, kHeight, {});
  Frame frame(kWidth, kHeight, 128);
  for (const auto &[x, y] : corners)
    for (int row = y; row < y + kSide; ++row)
      std::copy_n(&texture.pixels[static_cast<std::size_t>(row * kWidth + x)], kSide,
                  &frame.pixels[static_cast<std::size_t>(row * kWidth + x + moved)]);
  return frame;
}

TEST_F(FrameTranslationTest, APanOverAPictureThatShowsLittleIsBelievedInTime) {
  const std::vector<std::pair<int, int>> corners = {{20, 20}, {210, 30}, {120, 120}};
  FrameMotion found;
  for (int i = 0; i < 30; ++i)
    found = follow(squares(corners, i), squares(corners, i + 1));
  expect_pan(found, 1, 0, 0.05);
}

TEST_F(FrameTranslationTest, OneThingBeforeABlankSkyNeverMovesTheFrame) {
  for (int i = 0; i < 90; ++i)
    EXPECT_LT(follow(squares({{20, 60}}, 2 * i), squares({{20, 60}}, 2 * i + 2)).certainty, 0.1F)
        << "frame " << i;
}

TEST_F(FrameTranslationTest, AThingThatMovesDoesNotMoveTheFrame) {
  FrameMotion found;
  for (int i = 0; i < 6; ++i) {
    const auto draw = [&](double x) {
      Frame frame = scene.frame(kWidth, kHeight, {});
      test::Texture(6, 8).paint(frame, {x, 0}, 100, 200);
      return frame;
    };
    found = follow(draw(2.0 * i), draw(2.0 * i + 2));
  }
  EXPECT_LT(found.certainty, 0.1F);
}

TEST_F(FrameTranslationTest, ACameraAtRestDoesNotMoveTheFrame) {
  const FrameMotion found = pan({});
  EXPECT_EQ(found.certainty, 0);
  EXPECT_TRUE(found.is_unchanged);
}

TEST_F(FrameTranslationTest, ACameraThatStopsIsAtRestWithinASecond) {
  pan({1.3, -0.4});
  FrameMotion found;
  for (int i = 0; i < 60; ++i)
    found = pan({}, 2);
  EXPECT_EQ(found.certainty, 0);
}

// The parts that rest do not speak for a pan of 30 px, and no step leads from there to rest.
TEST_F(FrameTranslationTest, AFastPanThatStopsIsForgottenInATenthOfASecond) {
  EXPECT_EQ(pan({30, 0}, 60, {30, 0}).certainty, 1);
  FrameMotion found;
  for (int i = 0; i < 8; ++i) { // of a camera with noise
    const Frame earlier = scene.frame(kWidth, kHeight, {1770, 0});
    Frame later = earlier;
    for (std::size_t at = static_cast<std::size_t>(i) % 3; at < later.pixels.size(); at += 3)
      ++later.pixels[at];
    found = follow(earlier, later);
  }
  EXPECT_LT(found.certainty, 0.1F);
}

TEST_F(FrameTranslationTest, APanIsForgottenAfterACutToWhatNoTranslationExplains) {
  EXPECT_EQ(pan({1.3, -0.4}, 90).certainty, 1);
  FrameMotion found;
  for (unsigned i = 0; i < 20; ++i)
    found = follow(test::Texture(10 + i, 3).frame(kWidth, kHeight, {}),
                   test::Texture(11 + i, 3).frame(kWidth, kHeight, {}));
  EXPECT_LT(found.certainty, 0.1F);
}

TEST_F(FrameTranslationTest, AFrameSmallerThanAPatchShowsNothing) {
  for (const int side : {2, 9, 10}) {
    const Frame earlier = scene.frame(side, side, {});
    const Frame later = scene.frame(side, side, {1, 0});
    const PlaneSource before(earlier);
    const PlaneSource after(later);
    EXPECT_EQ(translation->follow({before, after, side, side}, 1.0F / 60, 0, {}).certainty, 0);
  }
}

} // namespace frame_translation_test
