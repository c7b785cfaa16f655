// SPDX-License-Identifier: LGPL-2.1-or-later
#include "region-tracking.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace fast_tracker_test {

using haptic::Measurement;
using haptic::Patch;
using haptic::Rectangle;
using test::Frame;
using test::Shift;
using test::Texture;

constexpr int kFrame = 140;

class FastTracker : public test::RegionTracking {
protected:
  FastTracker() : RegionTracking(haptic::make_fast_tracker()) {}

  static double error(const Measurement &found, const Shift &truth) {
    const Shift measured = mean(found);
    return std::hypot(measured.x - truth.x, measured.y - truth.y);
  }

  // The texture turned about the middle of the frame, radians.
  static Frame turned(const Texture &texture, double angle) {
    // Bilinear from a frame four times finer, so that the turn is exact to some thousandths.
    constexpr int kFiner = 4;
    Frame fine(kFiner * kFrame, kFiner * kFrame);
    texture.paint_magnified(fine, kFiner);
    Frame frame(kFrame, kFrame);
    const double middle = kFrame / 2.0;
    for (int y = 0; y < kFrame; ++y)
      for (int x = 0; x < kFrame; ++x) {
        const double rx = x + 0.5 - middle;
        const double ry = y + 0.5 - middle;
        const double sx = std::cos(angle) * rx + std::sin(angle) * ry + middle;
        const double sy = -std::sin(angle) * rx + std::cos(angle) * ry + middle;
        const double fx = std::clamp(sx * kFiner - 0.5, 0.0, fine.width - 1.001);
        const double fy = std::clamp(sy * kFiner - 0.5, 0.0, fine.height - 1.001);
        const int ix = static_cast<int>(fx);
        const int iy = static_cast<int>(fy);
        const double u = fx - ix;
        const double v = fy - iy;
        frame.at(x, y) = static_cast<std::uint8_t>(
            std::lround((1 - v) * ((1 - u) * fine.at(ix, iy) + u * fine.at(ix + 1, iy)) +
                        v * ((1 - u) * fine.at(ix, iy + 1) + u * fine.at(ix + 1, iy + 1))));
      }
    return frame;
  }
};

TEST_F(FastTracker, OneTranslationIsOnePatchWithinAHundredthOfAPixelInTheMean) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> component(-3, 3);
  double errors = 0;
  constexpr int kCases = 60;
  for (int i = 0; i < kCases; ++i) {
    const Texture texture(static_cast<unsigned>(random()), 4, 45);
    const Shift truth{component(random), component(random)};
    Frame before = texture.frame(kFrame, kFrame, {});
    Frame after = texture.frame(kFrame, kFrame, truth);
    add_noise(before, 1.5, random);
    add_noise(after, 1.5, random);
    const Measurement &found = track(before, after);
    ASSERT_GT(found.count, 0);
    errors += error(found, truth);
  }
  EXPECT_LT(errors / kCases, 0.010);
}

TEST_F(FastTracker, TheBorderOfAClippedAreaHasNoWeight) {
  double errors = 0;
  constexpr int kCases = 20;
  for (int i = 0; i < kCases; ++i) {
    const Texture texture(static_cast<unsigned>(i), 4, 45);
    const Shift truth{0.3 * (i % 7) - 1, 0.37 * (i % 5) - 0.8};
    // Below a border that moves with the texture, the sky is too bright for the camera.
    const auto before_sky = [&](const Shift &shift) {
      Frame frame = texture.frame(kFrame, kFrame, shift);
      for (int y = 0; y < kFrame; ++y)
        for (int x = 0; x < kFrame; ++x) {
          const double sky = std::clamp(y - (kFrame / 2.0 - 3 + shift.y) + 0.5, 0.0, 1.0);
          frame.at(x, y) = static_cast<std::uint8_t>(
              std::min(255.0, frame.at(x, y) + sky * (300 - frame.at(x, y))));
        }
      return frame;
    };
    Frame before = before_sky({});
    Frame after = before_sky(truth);
    const Measurement &found = track(before, after);
    ASSERT_EQ(found.count, 1);
    errors += error(found, truth);
  }
  EXPECT_LT(errors / kCases, 0.03);
}

// A texture without noise, as a codec leaves it, which stands still for `rest` frames and then
// moves on by `step` px.
class FastTrackerAfterRest : public FastTracker {
protected:
  int patches_after(double contrast, double step, int rest, int steps) {
    const Texture texture(5, 12, contrast);
    Frame before = texture.frame(kFrame, kFrame, {});
    for (int i = 0; i < rest; ++i) {
      // The frames are not the same, or nobody would look.
      Frame after = before;
      after.at(kFrame / 2, kFrame / 2) ^= 1;
      track(before, after);
      before = after;
    }
    int count = 0;
    for (int i = 1; i <= steps; ++i) {
      Frame after = texture.frame(kFrame, kFrame, {0, i * step});
      count = track(before, after).count;
      before = after;
    }
    return count;
  }
  static constexpr double kFaint = 6;  // grey levels: a sky
  static constexpr double kClear = 35; // leaves
};

// A key frame moves a sky by what it moved since the one before.
TEST_F(FastTrackerAfterRest, ASmallSuddenChangeIsNotMeasured) {
  EXPECT_EQ(patches_after(kFaint, 3, 12, 1), 0);
}

TEST_F(FastTrackerAfterRest, ASmallChangeThatGoesOnIsMeasuredFromTheSecondFrame) {
  EXPECT_GT(patches_after(kFaint, 3, 12, 2), 0);
}

TEST_F(FastTrackerAfterRest, ALargeSuddenChangeIsMeasuredAtOnce) {
  EXPECT_GT(patches_after(kClear, 3, 12, 1), 0);
}

TEST_F(FastTrackerAfterRest, ASmallChangeAfterAFewFramesIsMeasured) {
  EXPECT_GT(patches_after(kFaint, 3, 4, 1), 0);
}

// A frame of an interlaced film: the odd lines are half a frame later.
Frame woven(const Texture &texture, const Shift &motion, double time, int side) {
  Frame frame = texture.frame(side, side, {time * motion.x, time * motion.y});
  Frame later = texture.frame(side, side, {(time + 0.5) * motion.x, (time + 0.5) * motion.y});
  for (int y = 1; y < side; y += 2)
    for (int x = 0; x < side; ++x)
      frame.at(x, y) = later.at(x, y);
  return frame;
}

TEST_F(FastTracker, TheFieldsOfAnInterlacedFrameAreTrackedApart) {
  double errors = 0;
  constexpr int kCases = 30;
  for (int i = 0; i < kCases; ++i) {
    const Texture texture(static_cast<unsigned>(i), 3, 45);
    const Shift truth{i % 2 ? 2.5 : -2.5, 0.4 * (i % 13) - 2.4};
    Frame before = woven(texture, truth, 0, kFrame);
    Frame after = woven(texture, truth, 1, kFrame);
    const Measurement &found = track(before, after);
    ASSERT_GT(found.count, 0);
    EXPECT_LE(found.count, haptic::kUsualPatches);
    errors += error(found, truth);
  }
  EXPECT_LT(errors / kCases, 0.012); // 0.018 as one frame
}

TEST_F(FastTracker, TheFieldsOfALargeRegionAreTrackedApartToo) {
  constexpr int kLargeFrame = 400;
  double errors = 0;
  constexpr int kCases = 16;
  for (int i = 0; i < kCases; ++i) {
    const Texture texture(static_cast<unsigned>(i), 6, 45);
    const Shift truth{i % 2 ? 20.0 : -20.0, 3.0 * (i % 13) - 18};
    Frame before = woven(texture, truth, 0, kLargeFrame);
    Frame after = woven(texture, truth, 1, kLargeFrame);
    for (const int side : {164, 300}) {
      const int corner = (kLargeFrame - side) / 2;
      const Measurement &found = track(before, after, {corner, corner, side, side});
      ASSERT_GT(found.count, 0);
      EXPECT_LE(found.count, haptic::kUsualPatches);
      errors += error(found, truth);
    }
  }
  EXPECT_LT(errors / (2 * kCases), 0.012); // as one frame, some are not found
}

TEST_F(FastTracker, WhatIsOnlyBlackAndWhiteIsFollowed) {
  const auto square = [](int left) {
    Frame frame(kFrame, kFrame, 0);
    for (int y = 62; y < 78; ++y)
      for (int x = left; x < left + 16; ++x)
        frame.at(x, y) = 255;
    return frame;
  };
  Frame before = square(60);
  Frame after = square(62);
  const Measurement &found = track(before, after);
  ASSERT_GT(found.count, 0);
  EXPECT_LT(error(found, {2, 0}), 0.05);
}

TEST_F(FastTracker, EverySixteenthOfAPixelHasTheSameSmallBias) {
  for (int step = 0; step < 16; ++step) {
    const Shift truth{1 + step / 16.0, -step / 16.0};
    Shift sum;
    constexpr unsigned kTextures = 12;
    for (unsigned seed = 1; seed <= kTextures; ++seed) {
      const Texture texture(seed);
      Frame before = texture.frame(kFrame, kFrame, {});
      Frame after = texture.frame(kFrame, kFrame, truth);
      const Measurement &found = track(before, after);
      ASSERT_GT(found.count, 0);
      const Shift measured = mean(found);
      sum.x += (measured.x - truth.x) / kTextures;
      sum.y += (measured.y - truth.y) / kTextures;
    }
    EXPECT_LT(std::hypot(sum.x, sum.y), 0.005) << step;
  }
}

TEST_F(FastTracker, HoldsUpToSixteenPixels) {
  int gross = 0;
  const int cases =
      test::for_large_displacements(kFrame, [&](Frame &before, Frame &after, Shift truth) {
        const Measurement &found = track(before, after);
        gross += found.count == 0 || error(found, truth) > 0.5;
      });
  EXPECT_LE(gross, cases / 100);
}

TEST_F(FastTracker, ALargeRegionReachesFurther) {
  for (const int side : {60, 120, 240}) {
    tracker->reset();
    const Texture texture(15, side / 8.0);
    const Shift truth{side * 0.28, side * -0.2};
    Frame before = texture.frame(4 * side, 4 * side, {});
    Frame after = texture.frame(4 * side, 4 * side, truth);
    const Rectangle region{side + side / 2, side + side / 2, side, side};
    const Measurement &found = track(before, after, region);
    ASSERT_GT(found.count, 0) << side;
    EXPECT_LT(error(found, truth), 0.05) << side;
  }
}

// Half the pixels have a quarter of the noise: a fainter motion is seen.
TEST_F(FastTracker, AReducedRegionShowsFainterMotion) {
  constexpr int kLargeFrame = 400;
  constexpr int kLarge = 200;
  const Texture texture(2, 16, 3);
  Frame before = texture.frame(kLargeFrame, kLargeFrame, {});
  Frame after = texture.frame(kLargeFrame, kLargeFrame, {1, -0.6});
  const Measurement &found = track(before, after, {100, 100, kLarge, kLarge});
  ASSERT_GT(found.count, 0);
  EXPECT_LT(error(found, {1, -0.6}), 0.1);
}

// Of a noisy small region the tracker learned a noise and a motion that the large one does not
// have.
TEST_F(FastTracker, ALargerRegionBeginsAnew) {
  constexpr int kLargeFrame = 400;
  constexpr int kLarge = 200;
  const Rectangle large{100, 100, kLarge, kLarge};
  const Texture texture(3, 16, 6);
  Frame before = texture.frame(kLargeFrame, kLargeFrame, {});
  Frame after = texture.frame(kLargeFrame, kLargeFrame, {1, -0.6});
  const Measurement fresh = track(before, after, large);
  std::mt19937 random(5);
  for (int i = 0; i < 20; ++i) {
    Frame noisy = before;
    Frame noisy_again = before;
    add_noise(noisy, 8, random);
    add_noise(noisy_again, 8, random);
    track(noisy, noisy_again);
  }
  const Measurement &found = track(before, after, large);
  EXPECT_EQ(found.flags, fresh.flags);
  ASSERT_EQ(found.count, fresh.count);
  EXPECT_EQ(mean(found).x, mean(fresh).x);
  EXPECT_EQ(mean(found).y, mean(fresh).y);
}

// A bad fit of the whole region does not show that it stands still.
TEST_F(FastTracker, ASmallThingThatMovesOverAStillGroundIsNotStill) {
  constexpr int kThing = kSide / 2;
  std::mt19937 random(21);
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  int still = 0;
  for (unsigned seed = 1; seed <= 150; ++seed) {
    tracker->reset();
    const double direction = angle(random);
    const Shift shift{3 * std::cos(direction), 3 * std::sin(direction)};
    Frame before = Texture(seed, 3, 60).frame(kFrame, kFrame, {});
    Frame after = before;
    const Texture thing(seed + 1000, 3, 60);
    const auto cover = [&](Frame &frame, Shift place) {
      Frame all = thing.frame(kFrame, kFrame, place);
      const int left = (kFrame - kThing) / 2 + static_cast<int>(std::lround(place.x));
      const int top = (kFrame - kThing) / 2 + static_cast<int>(std::lround(place.y));
      for (int y = top; y < top + kThing; ++y)
        for (int x = left; x < left + kThing; ++x)
          frame.at(x, y) = all.at(x, y);
    };
    cover(before, {});
    cover(after, shift);
    add_noise(before, 1.5, random);
    add_noise(after, 1.5, random);
    still += (track(before, after).flags & haptic::kStill) != 0;
  }
  EXPECT_EQ(still, 0);
}

// Counting patches is right to a patch, counting pixels to a few pixels.
TEST_F(FastTracker, OfTwoMotionsEachCountsByItsPixels) {
  constexpr Rectangle kRegion{(kFrame - kSide) / 2, (kFrame - kSide) / 2, kSide, kSide};
  const Shift left{2, 0.5};
  const Shift right{-2, -0.5};
  std::mt19937 random(31);
  double errors = 0;
  int cases = 0;
  for (const int width : {8, 11, 15, 19, 22}) // px of the region on the left
    for (unsigned seed = 1; seed <= 12; ++seed) {
      tracker->reset();
      const auto frame_at = [&](double time) {
        Frame frame = Texture(seed, 3, 55).frame(kFrame, kFrame, {left.x * time, left.y * time});
        const Texture other(seed + 500, 3, 55);
        other.paint(frame, {right.x * time, right.y * time}, kRegion.x + width);
        add_noise(frame, 1.5, random);
        return frame;
      };
      Frame before = frame_at(0);
      Frame after = frame_at(1);
      const auto found = test::estimate(track(before, after, kRegion), kRegion);
      const double share = static_cast<double>(width) / kSide;
      errors += std::hypot(
          static_cast<double>(found.velocity_x) - share * left.x - (1 - share) * right.x,
          static_cast<double>(found.velocity_y) - share * left.y - (1 - share) * right.y);
      ++cases;
    }
  EXPECT_LT(errors / cases, 0.12);
}

TEST_F(FastTracker, ANoisyCameraThatMovesIsLearned) {
  constexpr double kSigma = 5;
  std::mt19937 random(41);
  int grids = 0;
  double errors = 0;
  int measured = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    tracker->reset();
    const Texture texture(seed, 4, 45);
    const Shift step{1.3, -0.7};
    const auto frame_at = [&](int i) {
      Frame frame = texture.frame(kFrame, kFrame, {step.x * i, step.y * i});
      add_noise(frame, kSigma, random);
      return frame;
    };
    Frame before = frame_at(0);
    for (int i = 1; i <= 30; ++i) {
      Frame after = frame_at(i);
      const Rectangle region{(kFrame - kSide) / 2, (kFrame - kSide) / 2, kSide, kSide};
      auto pair = test::crop_pair(before, after, region, *tracker);
      pair.continues = i > 1;
      tracker->measure(pair, measurement);
      if (i > 10) {
        grids += measurement.count != 1;
        errors += error(measurement, step);
        ++measured;
      }
      before = after;
    }
  }
  EXPECT_LE(grids, measured / 10);
  EXPECT_LE(errors / measured, 0.03);
}

TEST_F(FastTracker, NoiseOnAStillSceneIsStillWhateverItsStrength) {
  for (const double sigma : {0.0, 1.5, 5.0, 10.0}) {
    tracker->reset();
    std::mt19937 random(3);
    int false_motions = 0;
    const Texture texture(4);
    const Frame scene = texture.frame(kFrame, kFrame, {});
    Frame before = scene;
    add_noise(before, sigma, random);
    constexpr int kFrames = 200;
    constexpr int kLearning = 20; // the noise is learned from the first frames
    for (int i = 0; i < kFrames; ++i) {
      Frame after = scene;
      add_noise(after, sigma, random);
      const Measurement &found = track(before, after);
      if (i >= kLearning)
        false_motions += !(found.flags & haptic::kStill);
      before = after;
    }
    EXPECT_LE(false_motions, (kFrames - kLearning) / 100) << sigma;
  }
}

TEST_F(FastTracker, ABlankWallGivesNoPatches) {
  std::mt19937 random(8);
  for (int i = 0; i < 100; ++i) {
    Frame before(kFrame, kFrame, 120);
    Frame after(kFrame, kFrame, 120);
    add_noise(before, 1.5, random);
    add_noise(after, 1.5, random);
    const Measurement &found = track(before, after);
    EXPECT_EQ(found.count, 0);
    EXPECT_EQ(found.flags, 0U);
  }
}

// A ramp that moves looks like one at rest in another light.
TEST_F(FastTracker, OfASmoothRampNothingIsKnown) {
  const auto ramp = [](int offset) {
    Frame frame(kFrame, kFrame);
    for (int y = 0; y < kFrame; ++y)
      for (int x = 0; x < kFrame; ++x)
        frame.at(x, y) = static_cast<std::uint8_t>(x + offset);
    return frame;
  };
  Frame before = ramp(40);
  Frame after = ramp(37);
  const Measurement &found = track(before, after);
  EXPECT_EQ(found.count, 0);
  EXPECT_EQ(found.flags, 0U);
}

TEST_F(FastTracker, AnotherSceneIsNoMotion) {
  std::mt19937 random(9);
  int patches = 0;
  int cuts = 0;
  constexpr int kCuts = 100;
  for (unsigned seed = 0; seed < kCuts; ++seed) {
    Frame before = Texture(2 * seed).frame(kFrame, kFrame, {});
    Frame after = Texture(2 * seed + 1).frame(kFrame, kFrame, {});
    add_noise(before, 1.5, random);
    add_noise(after, 1.5, random);
    tracker->reset();
    const Measurement &found = track(before, after);
    patches += found.count > 0;
    cuts += (found.flags & haptic::kCut) != 0;
  }
  EXPECT_LE(patches, kCuts / 100);
  EXPECT_GE(cuts, kCuts / 2);
}

TEST_F(FastTracker, ChangesOfGainAndOffsetDoNotMoveAnything) {
  std::mt19937 random(10);
  std::uniform_real_distribution<double> component(-3, 3);
  constexpr int kCases = 30;
  struct {
    double gain, offset;
  } const changes[] = {{0.7, 0}, {1.4, -40}, {1.2, 20}, {1, 40}, {1, -40}};
  for (const auto &change : changes) {
    double errors = 0;
    for (int i = 0; i < kCases; ++i) {
      const Texture texture(static_cast<unsigned>(random()), 5, 20);
      const Shift truth{component(random), component(random)};
      Frame before = texture.frame(kFrame, kFrame, {});
      Frame after = texture.frame(kFrame, kFrame, truth);
      for (auto &pixel : after.pixels)
        pixel = static_cast<std::uint8_t>(
            std::clamp(std::lround(change.gain * (pixel - 128) + 128 + change.offset), 0L, 255L));
      add_noise(before, 0.5, random);
      add_noise(after, 0.5, random);
      const Measurement &found = track(before, after);
      ASSERT_GT(found.count, 0);
      errors += error(found, truth);
    }
    EXPECT_LT(errors / kCases, 0.015) << change.gain << " " << change.offset;
  }
}

TEST_F(FastTracker, StripesGiveOnlyTheMotionAcrossThem) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> turn(0, std::numbers::pi);
  std::uniform_real_distribution<double> distance(-1.5, 1.5);
  for (int i = 0; i < 40; ++i) {
    const double direction = turn(random);
    const double moved = distance(random);
    const auto paint = [&](double shift) {
      Frame frame(kFrame, kFrame);
      for (int y = 0; y < kFrame; ++y)
        for (int x = 0; x < kFrame; ++x) {
          const double along = x * std::cos(direction) + y * std::sin(direction) - shift;
          frame.at(x, y) = static_cast<std::uint8_t>(
              std::lround(128 + 40 * std::sin(0.7 * along) + 20 * std::sin(0.23 * along + 1)));
        }
      add_noise(frame, 1.5, random);
      return frame;
    };
    Frame before = paint(0);
    Frame after = paint(moved);
    const Measurement &found = track(before, after);
    if (found.count == 0) {
      EXPECT_LT(std::abs(moved), 0.05); // lost in the noise
      continue;
    }
    ASSERT_EQ(found.count, 1);
    const Shift measured = mean(found);
    const double normal = measured.x * std::cos(direction) + measured.y * std::sin(direction);
    const double tangential = -measured.x * std::sin(direction) + measured.y * std::cos(direction);
    EXPECT_NEAR(normal, moved, 0.05);
    EXPECT_NEAR(tangential, 0, 0.05);
    const Patch &patch = found.patches[0];
    const double determinant = static_cast<double>(patch.precision_xx) * patch.precision_yy -
                               static_cast<double>(patch.precision_xy) * patch.precision_xy;
    EXPECT_LT(determinant, 1e-3 * patch.precision_xx * patch.precision_yy +
                               1e-3 * patch.precision_xx * patch.precision_xx +
                               1e-3 * patch.precision_yy * patch.precision_yy);
  }
}

TEST_F(FastTracker, ATurnIsMeasuredByAGridOfPatches) {
  constexpr double kDegree = std::numbers::pi / 180;
  constexpr double kAngle = 5 * kDegree;
  constexpr unsigned kTextures = 8;
  double errors = 0;
  for (unsigned seed = 21; seed < 21 + kTextures; ++seed) {
    const Texture texture(seed);
    Frame before = turned(texture, 0);
    Frame after = turned(texture, kAngle);
    tracker->reset();
    const Measurement &found = track(before, after);
    ASSERT_GT(found.count, 15);
    // About the centre the motions of the patches cancel; the turn is in their differences.
    const Shift of_all = mean(found);
    EXPECT_LT(std::hypot(of_all.x, of_all.y), 0.1) << seed;
    double turn = 0;
    double spread = 0;
    for (const Patch &patch : found.view()) {
      const double rx = patch.x - kFrame / 2.0;
      const double ry = patch.y - kFrame / 2.0;
      turn += rx * patch.dy - ry * patch.dx;
      spread += rx * rx + ry * ry;
    }
    errors += std::abs(turn / spread - std::sin(kAngle)) / kTextures;
  }
  EXPECT_LT(errors, 0.3 * kDegree);
}

TEST_F(FastTracker, FollowsTheObjectInTheRegionAndNotItsNeighbour) {
  const Texture left(11);
  const Texture right(12);
  Frame before(240, kFrame);
  Frame after(240, kFrame);
  left.paint(before, {}, 0, 120);
  right.paint(before, {}, 120, 240);
  left.paint(after, {-3, 1}, 0, 120);
  right.paint(after, {4, -2}, 120, 240);
  EXPECT_LT(error(track(before, after, {80, 55, kSide, kSide}), {-3, 1}), 0.05);
  EXPECT_LT(error(track(before, after, {130, 55, kSide, kSide}), {4, -2}), 0.05);
}

TEST_F(FastTracker, AFrameThatFollowsOnTheLastOneGivesTheSameAnswer) {
  const Texture texture(14);
  std::vector<Frame> frames;
  for (int i = 0; i < 6; ++i)
    frames.push_back(texture.frame(kFrame, kFrame, {1.3 * i, -0.7 * i}));
  const Rectangle region{55, 55, kSide, kSide};
  const Rectangle crop = haptic::crop_around(region, tracker->margin(kSide), kFrame, kFrame);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    tracker->measure(
        {test::view(frames[i - 1], crop), test::view(frames[i], crop), crop, region, i > 1},
        measurement);
    const Shift with_memory = mean(measurement);
    auto fresh = haptic::make_fast_tracker();
    Measurement anew;
    fresh->measure({test::view(frames[i - 1], crop), test::view(frames[i], crop), crop, region},
                   anew);
    EXPECT_NEAR(with_memory.x, mean(anew).x, 0.002);
    EXPECT_NEAR(with_memory.y, mean(anew).y, 0.002);
  }
}

TEST_F(FastTracker, AfterARegionTooNarrowToMeasureNoOlderFrameIsCompared) {
  const Texture texture(14);
  std::vector<Frame> frames;
  for (int i = 0; i < 4; ++i)
    frames.push_back(texture.frame(kFrame, kFrame, {1.3 * i, -0.7 * i}));
  const Rectangle region{55, 55, kSide, kSide};
  const Rectangle crop = haptic::crop_around(region, tracker->margin(kSide), kFrame, kFrame);
  const Rectangle strip{0, 55, 4, kSide}; // the pointer beyond a border for one frame
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const bool is_strip = i == 2;
    const Rectangle &at = is_strip ? strip : crop;
    tracker->measure({test::view(frames[i - 1], at), test::view(frames[i], at), at,
                      is_strip ? strip : region, i > 1},
                     measurement);
    EXPECT_EQ(measurement.count > 0, !is_strip);
  }
  EXPECT_NEAR(mean(measurement).x, 1.3, 0.1);
  EXPECT_NEAR(mean(measurement).y, -0.7, 0.1);
}

TEST_F(FastTracker, KeepsToTheMaximumOfPoints) {
  const Texture texture(10);
  Frame before = turned(texture, 0);
  Frame after = turned(texture, 0.08);
  for (const int most : {1, 5, 20, haptic::kMaxPatches}) {
    tracker->set_max_points(most);
    const Measurement &found = track(before, after);
    EXPECT_LE(found.count, most);
  }
}

// A patch of a large region is one of many, before it is decided that two motions explain all.
TEST_F(FastTracker, KeepsToTheMaximumOfPointsWhereTwoThingsMove) {
  constexpr int kLarge = 400;
  const Texture left(21);
  const Texture right(22);
  const auto halves = [&](double time) {
    Frame frame = left.frame(kLarge, kLarge, {1.7 * time, -0.6 * time});
    right.paint(frame, {-1.9 * time, 0.9 * time}, kLarge / 2);
    return frame;
  };
  Frame before = halves(0);
  Frame after = halves(1);
  for (const int side : {30, 60, 160})
    for (const int most : {2, 5, 20, haptic::kMaxPatches}) {
      tracker->set_max_points(most);
      const int corner = (kLarge - side) / 2;
      const Measurement &found = track(before, after, {corner, corner, side, side});
      ASSERT_GT(found.count, 0) << side;
      EXPECT_LE(found.count, most) << side;
      EXPECT_LE(found.count, found.candidates) << side;
      float share = 0;
      for (const Patch &patch : found.view())
        share += patch.share;
      if (most >= 20) {
        EXPECT_NEAR(share, 1, 1e-3) << side; // each pixel follows one of the two
      }
    }
}

TEST_F(FastTracker, WorksInTheSmallestFrameThatCanBeMeasured) {
  const Texture texture(13);
  for (int side = haptic::kSmallestRegion; side < 90; ++side) {
    Frame before = texture.frame(side, side, {});
    Frame after = texture.frame(side, side, {0.5, 0.25});
    const int width = std::min(side, kSide);
    for (const Patch &patch : track(before, after, {0, 0, width, width}).view()) {
      EXPECT_TRUE(std::isfinite(patch.dx) && std::isfinite(patch.dy));
      EXPECT_TRUE(std::isfinite(patch.precision_xx) && std::isfinite(patch.residual));
    }
  }
}

TEST_F(FastTracker, RandomPixelsAndShapesGiveFiniteNumbers) {
  std::mt19937 random(17);
  for (int i = 0; i < 300; ++i) {
    const int width = 12 + static_cast<int>(random() % (i % 10 == 0 ? 1200 : 200));
    const int height = 12 + static_cast<int>(random() % 200);
    Frame before(width, height);
    Frame after(width, height);
    for (auto *frame : {&before, &after})
      for (auto &pixel : frame->pixels)
        pixel = static_cast<std::uint8_t>(random() % (1 + random() % 256));
    const int w = 12 + static_cast<int>(random() % static_cast<unsigned>(width - 11));
    const int h = 12 + static_cast<int>(random() % static_cast<unsigned>(height - 11));
    const Rectangle region{static_cast<int>(random() % static_cast<unsigned>(width - w + 1)),
                           static_cast<int>(random() % static_cast<unsigned>(height - h + 1)), w,
                           h};
    haptic::CropPair pair = test::crop_pair(before, after, region, *tracker);
    pair.continues = i % 3 == 0;
    tracker->measure(pair, measurement);
    EXPECT_LE(measurement.count, haptic::kMaxPatches);
    for (const Patch &patch : measurement.view()) {
      EXPECT_TRUE(std::isfinite(patch.dx) && std::isfinite(patch.dy));
      EXPECT_TRUE(std::isfinite(patch.precision_xx) && std::isfinite(patch.residual));
    }
  }
}

} // namespace fast_tracker_test
