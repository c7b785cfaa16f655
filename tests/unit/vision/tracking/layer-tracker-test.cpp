// SPDX-License-Identifier: LGPL-2.1-or-later
// What the default of roitracker promises, on drawn films whose motion is known.
#include "../layers/layer-scene.hpp"
#include "counted-allocations.hpp"
#include "instruction-sets.hpp"
#include "plane-source.hpp"
#include "tracking/region-tracker.hpp"
#include "velocity/velocity-estimate.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <numbers>
#include <random>
#include <vector>

namespace layer_tracker_test {

using haptic::Finding;
using haptic::Measurement;
using haptic::Rectangle;
using test::Frame;
using test::PlaneSource;
using test::Shift;

constexpr int kWidth = 240;
constexpr int kHeight = 160;
constexpr Rectangle kRegion{93, 53, 54, 54};
constexpr std::uint64_t kInterval = 1'000'000'000 / 60; // ns

class LayerTrackerTest : public ::testing::Test {
protected:
  LayerTrackerTest() {
    // Half of the leaf lies in the region.
    scene.place = {93, 80};
    scene.radius = 20;
  }

  // Shows a frame, and compares it with the one before.
  Finding show(Frame frame, const Rectangle &region = kRegion) {
    std::swap(earlier, frame_);
    frame_ = std::move(frame);
    region_ = region;
    if (earlier.width == 0)
      return {};
    tracker->set_method(haptic::TrackerMethod::layers, haptic::kUsualPatches);
    tracker->clear_measurement();
    return tracker->compare(PlaneSource(earlier), PlaneSource(frame_),
                            tracker->areas(region, frame_.width, frame_.height), kInterval);
  }

  Frame draw(Shift sky, Shift leaf) const { return scene.draw(kWidth, kHeight, sky, leaf); }

  const Measurement &found() const { return tracker->measurement(); }

  // In px a frame, as velocityavg has it.
  haptic::VelocityEstimate felt() const {
    if ((found().flags & haptic::kStill) != 0)
      return {};
    const auto width = static_cast<float>(region_.width);
    const auto height = static_cast<float>(region_.height);
    return haptic::estimate_velocity({.patches = found().view(),
                                      .candidates = found().candidates,
                                      .pointer_x = static_cast<float>(region_.x) + width / 2,
                                      .pointer_y = static_cast<float>(region_.y) + height / 2,
                                      .interval = 1,
                                      .region_x = static_cast<float>(region_.x),
                                      .region_y = static_cast<float>(region_.y),
                                      .region_width = width,
                                      .region_height = height,
                                      .is_tiled = (found().flags & haptic::kTiled) != 0},
                                     haptic::Average::model, haptic::ModelChoice::automatic);
  }

  // The mean over the region of the motion that the scene has.
  Shift truth(Shift sky, Shift leaf, Shift leaf_place, const Rectangle &region = kRegion) const {
    double covered = 0;
    for (int y = region.y; y < region.y + region.height; ++y)
      for (int x = region.x; x < region.x + region.width; ++x)
        covered += scene.cover(x, y, leaf_place) / (region.width * region.height);
    return {covered * leaf.x + (1 - covered) * sky.x, covered * leaf.y + (1 - covered) * sky.y};
  }

  struct Error {
    double share = 0;        // of the motion
    double largest_step = 0; // px, from one frame to the next
  };
  static constexpr int kFirst = 60; // frame; after a second, for the drift
  static constexpr int kFrames = 180;

  static Shift leaf_at(int i) { return {6 * std::sin(0.12 * i), 2 * std::cos(0.1 * i)}; }

  // A leaf that sways before a drifting sky.
  std::vector<Frame> film_of_leaf() const {
    std::vector<Frame> film;
    for (int i = 0; i < kFrames; ++i)
      film.push_back(draw({0.1 * i, 0}, leaf_at(i)));
    return film;
  }

  // In the region of each frame.
  Error error_of_leaf(const std::vector<Frame> &film,
                      const std::function<Rectangle(int)> &region_at) {
    tracker = std::make_unique<haptic::RegionTracker>();
    frame_ = {};
    double error = 0;
    double speed = 0;
    Error found;
    Shift before;
    for (int i = 0; i < kFrames; ++i) {
      show(film[static_cast<std::size_t>(i)], region_at(i));
      if (i < kFirst)
        continue;
      const Shift leaf{leaf_at(i).x - leaf_at(i - 1).x, leaf_at(i).y - leaf_at(i - 1).y};
      const Shift is = truth({0.1, 0}, leaf, leaf_at(i), region_at(i));
      const Shift now{static_cast<double>(felt().velocity_x) - is.x,
                      static_cast<double>(felt().velocity_y) - is.y};
      error += std::hypot(now.x, now.y);
      speed += std::hypot(is.x, is.y);
      if (i > kFirst)
        found.largest_step =
            std::max(found.largest_step, std::hypot(now.x - before.x, now.y - before.y));
      before = now;
    }
    found.share = error / speed;
    return found;
  }

  void expect_error(const Error &most, const std::vector<Frame> &film,
                    const std::function<Rectangle(int)> &region_at) {
    const Error error = error_of_leaf(film, region_at);
    EXPECT_LT(error.share, most.share);
    EXPECT_LT(error.largest_step, most.largest_step);
  }

  // px a frame; of a texture without borders that sways, seen with noise.
  double error_of_sway(double contrast, double noise, double reach) {
    constexpr unsigned kTextures = 6;
    std::mt19937 random(11);
    double error = 0;
    int looked_at = 0;
    for (unsigned seed = 1; seed <= kTextures; ++seed) {
      tracker = std::make_unique<haptic::RegionTracker>();
      frame_ = {};
      const test::Texture texture(seed, 4, contrast);
      const auto place = [&](int i) {
        return Shift{reach * std::sin(0.2 * i), -0.6 * reach * std::sin(0.2 * i)};
      };
      for (int i = 0; i < 40; ++i) {
        Frame frame = texture.frame(kWidth, kHeight, place(i));
        test::add_noise(frame, noise, random);
        show(std::move(frame));
        if (i < 20)
          continue;
        error += std::hypot(static_cast<double>(felt().velocity_x) - place(i).x + place(i - 1).x,
                            static_cast<double>(felt().velocity_y) - place(i).y + place(i - 1).y);
        ++looked_at;
      }
    }
    return error / looked_at;
  }

  test::LayerScene scene;
  std::unique_ptr<haptic::RegionTracker> tracker = std::make_unique<haptic::RegionTracker>();
  Frame earlier;
  Frame frame_;
  Rectangle region_;
};

// The windows of other methods carry the leaf's motion into the sky.
TEST_F(LayerTrackerTest, ALeafBeforeADriftingSkyIsFeltByTheAreaThatItCovers) {
  EXPECT_LT(error_of_leaf(film_of_leaf(), [](int) { return kRegion; }).share, 0.1);
}

// The hand stays, but for a pixel or two.
TEST_F(LayerTrackerTest, AHandThatTremblesFeelsTheLeafAsOneThatRests) {
  EXPECT_LT(error_of_leaf(film_of_leaf(),
                          [](int i) {
                            return Rectangle{kRegion.x + i % 3 - 1, kRegion.y + i / 2 % 3 - 1,
                                             kRegion.width, kRegion.height};
                          })
                .share,
            0.1);
}

// Between two pixels an interpolated frame has less noise, so that a sky fits the motion of a leaf
// better than its own rest. When that passed for a motion of the sky, the error was 0.5 and 0.6 px.
TEST_F(LayerTrackerTest, NoiseDoesNotMakeASkyFollowALeaf) {
  std::vector<Frame> film = film_of_leaf();
  std::mt19937 random(5);
  for (Frame &frame : film)
    test::add_noise(frame, 1, random);
  for (const int left : {42, 66, 83})
    expect_error({0.2, 0.06}, film, [left](int) {
      return Rectangle{left, kRegion.y + 24, kRegion.width, kRegion.height};
    });
}

// What is known of a place stays known while the hand goes on. A hand that rests at a place of the
// way has an error of up to 0.1 of the motion, and steps of up to 0.05 px. A fast one leaves a
// place before its drift is known: up to 0.13. With layers that began anew, it was 0.6 to 2.6 and
// 0.7 px.
TEST_F(LayerTrackerTest, AHandThatMovesFeelsTheLeafAsOneThatRests) {
  const std::vector<Frame> film = film_of_leaf();
  constexpr Error kMost{0.14, 0.06};
  constexpr double kRadius = 24; // px, of the way around the leaf
  const auto around_leaf = [](double angle) {
    return Rectangle{static_cast<int>(std::lround(66 - kRadius * std::cos(angle))),
                     static_cast<int>(std::lround(53 + kRadius * std::sin(angle))), kRegion.width,
                     kRegion.height};
  };
  for (const double speed : {20.0, 60.0, 200.0}) { // px/s
    SCOPED_TRACE(speed);
    expect_error(kMost, film, [&](int i) {
      return around_leaf(speed / 60 / kRadius * std::max(0, i - kFirst));
    });
  }
  for (const double step : {5.0, 10.0, 20.0, 30.0}) { // px, six times a second
    SCOPED_TRACE(step);
    expect_error(kMost, film, [&](int i) {
      return around_leaf(2 * std::asin(step / 2 / kRadius) * std::max(0, (i - kFirst) / 10));
    });
  }
}

// A hand that is pushed in makes the region larger.
TEST_F(LayerTrackerTest, ARegionThatChangesItsSizeFeelsTheLeafAsBefore) {
  expect_error({0.1, 0.04}, film_of_leaf(), [](int i) {
    const int side = 50 + i / 15 % 2 * 8;
    return Rectangle{73 - side / 2, 80 - side / 2, side, side};
  });
}

// At rest, up to 0.18 and 0.13 px.
TEST_F(LayerTrackerTest, AHandThatMovesAtABorderFeelsTheLeafAsOneThatRests) {
  scene.place = {26, 80};
  expect_error({0.18, 0.13}, film_of_leaf(), [](int i) {
    const double x = 22 - 16 * std::cos(0.02 * std::max(0, i - kFirst));
    return haptic::region_at(x / kWidth, 0.5, kRegion.width, kWidth, kHeight);
  });
}

// What the layers see goes on by whole cells, which end beside the border of the frame. What was
// read beyond them was no number.
TEST_F(LayerTrackerTest, AtEachBorderATileMovesAsTheFrameDoes) {
  constexpr Shift kBy{0.6, -0.4};
  constexpr int kRight = kWidth - kRegion.width;
  constexpr int kBottom = kHeight - kRegion.height;
  const test::Texture texture(5);
  std::vector<Frame> film;
  for (int i = 0; i < 96; ++i)
    film.push_back(texture.frame(kWidth, kHeight, {kBy.x * i, kBy.y * i}));
  for (const auto &[right, down] : {std::pair{1, 1}, {-1, 1}, {1, -1}, {-1, -1}})
    for (int from = 0; from < haptic::kCellSide; ++from) {
      tracker = std::make_unique<haptic::RegionTracker>();
      frame_ = {};
      for (int i = 0; i < std::ssize(film); ++i) {
        show(film[static_cast<std::size_t>(i)],
             {std::clamp(kRight / 2 + right * (from + i), 0, kRight),
              std::clamp(kBottom / 2 + down * (from + i), 0, kBottom), kRegion.width,
              kRegion.height});
        if (i == 0)
          continue;
        EXPECT_GT(found().count, 0);
        for (const haptic::Patch &tile : found().view()) {
          EXPECT_NEAR(tile.dx, kBy.x, 0.05) << right << ' ' << down << ' ' << from + i;
          EXPECT_NEAR(tile.dy, kBy.y, 0.05) << right << ' ' << down << ' ' << from + i;
        }
      }
    }
}

// The layers see the frame reduced.
TEST_F(LayerTrackerTest, AHandWithALargeRegionFeelsTheLeafAsOneThatRests) {
  scene.place = {120, 80};
  scene.radius = 26;
  expect_error({0.05, 0.02}, film_of_leaf(), [](int i) {
    return Rectangle{76 + static_cast<int>(std::lround(16 * std::sin(0.05 * i))),
                     36 + static_cast<int>(std::lround(12 * std::cos(0.07 * i))), 88, 88};
  });
}

// One translation explains all: nothing remembered may disturb it.
TEST_F(LayerTrackerTest, WhatMovesAsOneIsRightToAHundredthOfAPixel) {
  EXPECT_LT(error_of_sway(45, 1.5, 5), 0.01);
}

TEST_F(LayerTrackerTest, WhatHardlyShowsIsFollowedAndNotTakenForASky) {
  EXPECT_LT(error_of_sway(6, 1.5, 5), 0.1);
}

TEST_F(LayerTrackerTest, TheFieldsOfAnInterlacedFrameAreMeasuredApart) {
  const test::Texture texture(3, 4);
  constexpr Shift kBy{2.5, -1.4};
  for (int i = 0; i < 12; ++i) {
    Frame frame = texture.frame(kWidth, kHeight, {kBy.x * i, kBy.y * i});
    const Frame later = texture.frame(kWidth, kHeight, {kBy.x * (i + 0.5), kBy.y * (i + 0.5)});
    for (int y = 1; y < kHeight; y += 2)
      std::copy_n(&later.pixels[static_cast<std::size_t>(y * kWidth)], kWidth, &frame.at(0, y));
    show(std::move(frame));
    if (i > 0) {
      EXPECT_NEAR(felt().velocity_x, kBy.x, 0.05) << i;
      EXPECT_NEAR(felt().velocity_y, kBy.y, 0.05) << i;
    }
  }
}

TEST_F(LayerTrackerTest, APointerThatMovesOverAMovingSceneIsRightAtOnce) {
  const test::Texture texture(7);
  for (int i = 0; i < 12; ++i) {
    show(texture.frame(kWidth, kHeight, {1.3 * i, -0.7 * i}),
         {kRegion.x + 40 * (i % 2), kRegion.y + 3 * i, kRegion.width, kRegion.height});
    if (i > 0) {
      EXPECT_NEAR(felt().velocity_x, 1.3, 0.02) << i;
      EXPECT_NEAR(felt().velocity_y, -0.7, 0.02) << i;
    }
  }
}

// The lamp of a scene at rest, but for the leaf.
TEST_F(LayerTrackerTest, AChangeOfLightIsNoMotion) {
  const auto leaf_at = [](int i) { return Shift{6 * std::sin(0.12 * i), 2 * std::cos(0.1 * i)}; };
  std::mt19937 random(5);
  std::uniform_real_distribution<double> rounding(0, 1);
  double error = 0;
  double speed = 0;
  for (int i = 0; i < 90; ++i) {
    Frame frame = draw({}, leaf_at(i));
    const double light = 0.95 + 0.05 * std::cos(2 * std::numbers::pi * i / 60);
    for (std::uint8_t &pixel : frame.pixels) // a camera's noise: else whole areas are rounded alike
      pixel = static_cast<std::uint8_t>(light * pixel + rounding(random));
    show(std::move(frame));
    if (i < 30)
      continue;
    const Shift leaf{leaf_at(i).x - leaf_at(i - 1).x, leaf_at(i).y - leaf_at(i - 1).y};
    const Shift is = truth({}, leaf, leaf_at(i));
    error += std::hypot(static_cast<double>(felt().velocity_x) - is.x,
                        static_cast<double>(felt().velocity_y) - is.y);
    speed += std::hypot(is.x, is.y);
  }
  EXPECT_LT(error / speed, 0.25);
}

// Between its blades a meadow is flat, and as bright as they are on average. Waves run through it.
TEST_F(LayerTrackerTest, TheFlatPartsOfAMeadowMoveWithIt) {
  constexpr int kBladesFrom = 105; // grey levels of the texture that says where they are
  constexpr int kBand = 8;         // px, that sways as one
  const test::Texture blades(3, 4);
  const test::Texture tufts(9, 24);
  const auto sway = [](int left, int i) { return 4 * std::sin(0.1 * i - 0.03 * left); };
  double product = 0;
  double square = 0;
  for (int i = 0; i < 120; ++i) {
    Frame frame(kWidth, kHeight);
    Frame is_tuft(kWidth, kHeight);
    for (int left = 0; left < kWidth; left += kBand) {
      blades.paint(frame, {sway(left, i), 0}, left, left + kBand);
      tufts.paint(is_tuft, {sway(left, i), 0}, left, left + kBand);
    }
    for (std::size_t at = 0; at < frame.pixels.size(); ++at)
      if (is_tuft.pixels[at] < kBladesFrom)
        frame.pixels[at] = 128;
    show(std::move(frame));
    if (i < 60)
      continue;
    double is = 0;
    for (int x = kRegion.x; x < kRegion.x + kRegion.width; ++x)
      is += (sway(x / kBand * kBand, i) - sway(x / kBand * kBand, i - 1)) / kRegion.width;
    product += is * static_cast<double>(felt().velocity_x);
    square += is * is;
  }
  EXPECT_NEAR(product / square, 1, 0.15);
}

// Both parts of the region are full of texture, and slide against each other. Without the passage
// from the ladder to the layers, the largest steps were 0.028 and 0.096 px a frame.
TEST_F(LayerTrackerTest, ANewPlaceWithTwoMotionsIsFeltWithoutAStep) {
  struct Part {
    int tenths;  // of the region, on the left
    double most; // px a frame
  };
  for (const auto &[tenths, most] : {Part{5, 0.02}, Part{2, 0.05}}) {
    const int border = kRegion.x + kRegion.width * tenths / 10;
    double largest = 0;
    for (unsigned seed = 0; seed < 8; ++seed) {
      tracker = std::make_unique<haptic::RegionTracker>();
      frame_ = {};
      const test::Texture left(2 * seed + 1, 4);
      const test::Texture right(2 * seed + 2, 4);
      double before = 0;
      for (int i = 0; i < 24; ++i) {
        Frame frame(kWidth, kHeight);
        left.paint(frame, {0, 1.0 * i}, 0, border);
        right.paint(frame, {0, -1.0 * i}, border, kWidth);
        show(std::move(frame));
        const haptic::VelocityEstimate now = felt();
        if (i > 0) {
          EXPECT_GT(now.confidence, 0);
        }
        if (i > 1)
          largest = std::max(largest, std::abs(static_cast<double>(now.velocity_y) - before));
        before = static_cast<double>(now.velocity_y);
      }
    }
    EXPECT_LT(largest, most) << tenths << " tenths";
  }
}

TEST_F(LayerTrackerTest, TheTilesCoverTheRegionEvenly) {
  for (int i = 0; i < 20; ++i)
    show(draw({0.1 * i, 0}, {0.7 * i, 0.2 * i}));
  ASSERT_EQ(found().count, 16);
  float area = 0;
  for (const haptic::Patch &patch : found().view()) {
    area += patch.width * patch.height;
    EXPECT_GT(patch.x - patch.width / 2, kRegion.x - 0.01F);
    EXPECT_LT(patch.x + patch.width / 2, kRegion.x + kRegion.width + 0.01F);
  }
  EXPECT_NEAR(area, kRegion.width * kRegion.height, 1);
  EXPECT_GT(felt().confidence, 0.9F);
}

// A sky above textured land. Nothing in the region tells a sky that moves from one at rest.
TEST_F(LayerTrackerTest, AScenePannedByTheCameraMovesAsAWhole) {
  const test::Texture land(3, 6);
  for (const Shift by : {Shift{0.5, 0}, Shift{2, -1}, Shift{7, 3}}) {
    tracker = std::make_unique<haptic::RegionTracker>();
    frame_ = {};
    for (int i = 0; i < 16; ++i) {
      Frame frame = draw({by.x * i, by.y * i}, {by.x * i, by.y * i});
      const Frame ground = land.frame(kWidth, kHeight, {by.x * i, by.y * i});
      for (int y = 70 + static_cast<int>(by.y * i); y < kHeight; ++y)
        std::copy_n(&ground.pixels[static_cast<std::size_t>(y * kWidth)], kWidth, &frame.at(0, y));
      show(std::move(frame));
    }
    EXPECT_NEAR(felt().velocity_x, by.x, 0.02 + 0.02 * by.x);
    EXPECT_NEAR(felt().velocity_y, by.y, 0.02 + 0.02 * by.x);
  }
}

TEST_F(LayerTrackerTest, TwoFramesAreEnough) {
  show(test::Texture(8).frame(kWidth, kHeight, {}));
  show(test::Texture(8).frame(kWidth, kHeight, {2, -1}));
  EXPECT_NEAR(felt().velocity_x, 2, 0.1);
  EXPECT_NEAR(felt().velocity_y, -1, 0.1);
}

TEST_F(LayerTrackerTest, NoiseOfACameraAtRestIsStill) {
  for (const double sigma : {0.5, 2.0, 5.0, 10.0}) {
    tracker = std::make_unique<haptic::RegionTracker>();
    frame_ = {};
    std::mt19937 random(4);
    const test::Texture scene_at_rest(7);
    int moved = 0;
    for (int i = 0; i < 80; ++i) {
      Frame frame = scene_at_rest.frame(kWidth, kHeight, {});
      test::add_noise(frame, sigma, random);
      const Finding finding = show(std::move(frame));
      moved += i >= 20 && (finding.flags & haptic::kMotionStill) == 0;
    }
    EXPECT_LE(moved, 2) << sigma;
  }
}

TEST_F(LayerTrackerTest, AWallWithoutTextureShowsNothing) {
  std::mt19937 random(5);
  for (int i = 0; i < 20; ++i) {
    Frame frame(kWidth, kHeight, 128);
    test::add_noise(frame, 1, random);
    show(std::move(frame));
    EXPECT_EQ(found().count, 0);
  }
}

TEST_F(LayerTrackerTest, OfASlopeInOneDirectionNothingIsKnown) {
  for (int i = 0; i < 40; ++i) {
    Frame frame(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      std::fill_n(&frame.at(0, y), kWidth, static_cast<std::uint8_t>(60 + y / 2 + i / 10));
    show(std::move(frame));
    EXPECT_EQ(found().count, 0);
  }
}

TEST_F(LayerTrackerTest, ACutIsNoMotion) {
  for (int i = 0; i < 10; ++i)
    show(test::Texture(8).frame(kWidth, kHeight, {0.5 * i, 0}));
  const Finding cut = show(test::Texture(9).frame(kWidth, kHeight, {}));
  EXPECT_TRUE(cut.flags & haptic::kMotionCut);
  EXPECT_EQ(found().count, 0);
  for (int i = 1; i < 4; ++i)
    show(test::Texture(9).frame(kWidth, kHeight, {0.5 * i, 0}));
  EXPECT_NEAR(felt().velocity_x, 0.5, 0.05) << "the new scene is measured at once";
}

TEST_F(LayerTrackerTest, APointerThatMovesOverAStillSceneFeelsNothing) {
  const Frame still = draw({}, {});
  for (int i = 0; i < 6; ++i) {
    show(still, {kRegion.x + 3 * i, kRegion.y + i, kRegion.width, kRegion.height});
    for (const haptic::Patch &patch : found().view())
      EXPECT_EQ(std::hypot(patch.dx, patch.dy), 0);
  }
}

TEST_F(LayerTrackerTest, ALargeRegionIsMeasuredInAReducedFrame) {
  constexpr Rectangle kLarge{20, 10, 200, 140};
  for (int i = 0; i < 10; ++i)
    show(test::Texture(8, 12).frame(kWidth, kHeight, {1.5 * i, -0.7 * i}), kLarge);
  EXPECT_NEAR(felt().velocity_x, 1.5, 0.06);
  EXPECT_NEAR(felt().velocity_y, -0.7, 0.06);
}

// Walks, leaps and sizes of a hand, in frames of any shape, over textures, things, noise and cuts.
TEST_F(LayerTrackerTest, WhateverAHandDoesATileIsAFiniteMotionWithinItsRegion) {
  constexpr int kFilms = 30;
  constexpr int kFramesOfFilm = 30;
  std::mt19937 random(23);
  const auto below = [&](int count) {
    return static_cast<int>(random() % static_cast<unsigned>(count));
  };
  const auto share = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
  for (int film = 0; film < kFilms; ++film) {
    tracker = std::make_unique<haptic::RegionTracker>();
    frame_ = {};
    const int width = haptic::kSmallestRegion + below(film % 10 == 0 ? 600 : 120);
    const int height = haptic::kSmallestRegion + below(120);
    scene.place = {share() * width, share() * height};
    Shift pointer{share(), share()};
    const Shift walk{0.04 * share() - 0.02, 0.04 * share() - 0.02};
    const Shift by{8 * share() - 4, 8 * share() - 4};
    int side = haptic::kSmallestRegion + below(60);
    for (int i = 0; i < kFramesOfFilm; ++i) {
      Frame frame = scene.draw(width, height, {0.1 * i, 0}, {by.x * i, by.y * i});
      if (film % 3 == 0)
        test::add_noise(frame, 20 * share(), random);
      if (below(30) == 0)
        frame = Frame(width, height, static_cast<std::uint8_t>(below(2) * below(256)));
      if (below(30) == 0)
        side = haptic::kSmallestRegion + below(120);
      pointer = below(30) == 0 ? Shift{share(), share()}
                               : Shift{std::clamp(pointer.x + walk.x, -0.1, 1.1),
                                       std::clamp(pointer.y + walk.y, -0.1, 1.1)};
      const Rectangle region = haptic::region_at(pointer.x, pointer.y, side, width, height);
      if (!haptic::is_measurable(region)) {
        tracker->skip();
        continue;
      }
      show(std::move(frame), region);
      for (const haptic::Patch &patch : found().view()) {
        EXPECT_TRUE(std::isfinite(patch.dx + patch.dy + patch.precision_xx + patch.precision_xy +
                                  patch.precision_yy + patch.residual + patch.share));
        const bool is_tile = (found().flags & haptic::kTiled) != 0;
        const Rectangle within = is_tile ? region : Rectangle{0, 0, width, height};
        EXPECT_GE(patch.x, static_cast<float>(within.x));
        EXPECT_GE(patch.y, static_cast<float>(within.y));
        EXPECT_LE(patch.x, static_cast<float>(within.x + within.width));
        EXPECT_LE(patch.y, static_cast<float>(within.y + within.height));
      }
    }
  }
}

TEST_F(LayerTrackerTest, TakesNoMemoryAfterTheFirstFrameOfASize) {
  std::vector<Frame> film;
  for (int i = 0; i < 12; ++i)
    film.push_back(draw({0.1 * i, 0}, {0.9 * i, 0.3 * i}));
  const auto shown = [&](std::size_t i) {
    tracker->compare(PlaneSource(film[i - 1]), PlaneSource(film[i]),
                     tracker->areas(kRegion, kWidth, kHeight), kInterval);
  };
  tracker->set_method(haptic::TrackerMethod::layers, haptic::kUsualPatches);
  shown(1);
  shown(2);
  const long before = test::allocations;
  for (std::size_t i = 3; i < film.size(); ++i)
    shown(i);
  EXPECT_EQ(test::allocations, before);
}

TEST_F(LayerTrackerTest, EachInstructionSetFindsTheSame) {
  std::vector<Shift> means;
  test::for_instruction_sets([&](const char *) {
    tracker = std::make_unique<haptic::RegionTracker>();
    frame_ = {};
    for (int i = 0; i < 20; ++i)
      show(draw({0.1 * i, 0}, {0.9 * i, 0.3 * i}));
    means.push_back({felt().velocity_x, felt().velocity_y});
  });
  for (const Shift &one : means) {
    EXPECT_NEAR(one.x, means[0].x, 1e-3);
    EXPECT_NEAR(one.y, means[0].y, 1e-3);
  }
}

// The rest of the frame tells how far it moved, and it is seen to do so over some frames.
TEST_F(LayerTrackerTest, AnOutOfFocusPartOfAPanIsAsSureAsTheFrame) {
  constexpr Rectangle kSoft{20, 53, 54, 54};
  const test::Texture sharp(3);
  std::mt19937 random(1);
  for (int i = 0; i < kFirst + 30; ++i) {
    Frame frame(kWidth, kHeight);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        frame.at(x, y) = static_cast<std::uint8_t>(
            std::lround(120 + 20 * std::sin((x - i) / 50.0) + 12 * std::sin(y / 40.0)));
    sharp.paint(frame, {1.0 * i, 0}, 100);
    test::add_noise(frame, 1, random);
    show(std::move(frame), kSoft);
    if (i < kFirst)
      continue;
    EXPECT_GT(felt().confidence, 0.5F) << i;
    EXPECT_NEAR(felt().velocity_x, 1, 0.1) << i;
    EXPECT_NEAR(felt().velocity_y, 0, 0.1) << i;
  }
}

} // namespace layer_tracker_test
