// SPDX-License-Identifier: LGPL-2.1-or-later
// One test for each way in which trackers fail (tracker and average over its patches), with the
// bound that the default must keep. Of one pair of frames the default says what method=fast does.
// Errors are end-point errors of the velocity of the region in pixels per frame, means over random
// scenes unless said otherwise.
#include "methods/methods.hpp"
#include "results/statistics.hpp"
#include "scenes/h264.hpp"
#include "scenes/scenes.hpp"
#include "tracking/region.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <iostream>
#include <limits>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <sys/mman.h>
#include <unistd.h>

namespace {

using namespace lab;

constexpr int kSide = 30;
constexpr int kCases = 120;
const cv::Size kFrame(352, 288);
constexpr double kDegree = std::numbers::pi / 180;
constexpr const char *kNoH264 =
    "gstreamer1.0-plugins-ugly (x264enc) or gstreamer1.0-libav (avdec_h264) is not installed";

// The force in mN that a velocity gives by the paper's law: 1 N at most, half of it at 100 px/s, 30
// frames a second.
cv::Point2d force(Vector velocity) {
  const double length = std::hypot(velocity.x, velocity.y);
  return length > 0 ? velocity * (2000 / std::numbers::pi * std::atan(0.3 * length) / length)
                    : Vector();
}

struct Shot {
  Reading reading;
  Vector truth;
  double bound = 0; // Cramer-Rao, px; 0: not asked for
  bool is_unseen = false;

  bool is_measured() const { return reading.confidence > 0; }
  double error() const { return cv::norm(reading.velocity - truth); }
};

Reading look(Method &method, const cv::Mat &previous, const cv::Mat &current,
             bool continues = false, int side = kSide) {
  return method.measure({previous, current, {0.5, 0.5}, side, continues});
}

template <typename Make>
std::vector<Shot> pairs_of(const Make &make, std::uint64_t seed, int cases = kCases,
                           int side = kSide, bool with_bound = false) {
  Random random(seed);
  std::vector<Shot> shots;
  for (int i = 0; i < cases; ++i) {
    const Movie movie = make(random);
    const auto [previous, current] = expose_pair(movie, random);
    shots.push_back(
        {look(*make_default(), embed(previous, kFrame), embed(current, kFrame), false, side),
         movie.velocity, with_bound ? cramer_rao_bound(movie.light(0), side, movie.noise) : 0,
         movie.is_unseen});
  }
  return shots;
}

std::vector<Shot> pairs(const std::string &scene, std::uint64_t seed = 1, int cases = kCases) {
  return pairs_of(scene_named(hard_scenes(kSide), scene).make, seed, cases);
}

// What is around the scene in a stream. embed() mirrors it, which is the motion of no camera; that
// does not matter to pairs, of which only the crop is read.
enum class Surroundings {
  none, // it fills the frame, which is kWindow wide
  rest,
};

// One tracker for a whole video; the first frame gives no measurement.
std::vector<Shot> stream(const Movie &movie, int frames, Random &random,
                         Surroundings surroundings = Surroundings::none) {
  const auto method = make_default();
  std::vector<Shot> shots;
  cv::Mat first;
  const auto frame_at = [&](int time) {
    cv::Mat scene = expose(movie, time, random);
    if (surroundings == Surroundings::none)
      return scene;
    if (first.empty())
      first = embed(scene, kFrame);
    cv::Mat frame = first.clone();
    scene.copyTo(frame(
        {(frame.cols - scene.cols) / 2, (frame.rows - scene.rows) / 2, scene.cols, scene.rows}));
    return frame;
  };
  cv::Mat previous = frame_at(0);
  for (int i = 1; i < frames; ++i) {
    const cv::Mat current = frame_at(i);
    shots.push_back({look(*method, previous, current, i > 1), movie.velocity});
    previous = current;
  }
  return shots;
}

double mean_error(const std::vector<Shot> &shots) {
  double sum = 0;
  int measured = 0;
  for (const Shot &shot : shots)
    if (shot.is_measured()) {
      sum += shot.error();
      ++measured;
    }
  return measured > 0 ? sum / measured : std::numeric_limits<double>::infinity();
}

double share(const std::vector<Shot> &shots, const std::function<bool(const Shot &)> &is) {
  return static_cast<double>(std::ranges::count_if(shots, is)) / static_cast<double>(shots.size());
}

// A target that is not reached yet, and what is: that gates, so that it gets no worse. docs/lab.md
// lists them with the reason.
struct Unreached {
  double target;
  double reached;
};

// Silence is no accuracy: nearly all must have been measured.
void expect_accurate(const std::vector<Shot> &shots, double bound) {
  const double error = mean_error(shots);
  std::cout << "mean error " << error << " px, bound " << bound << " px\n"; // for docs/lab.md
  EXPECT_GE(share(shots, &Shot::is_measured), 0.95);
  EXPECT_LE(error, bound);
}

void expect_accurate(const std::vector<Shot> &shots, const Unreached &bound) {
  const double error = mean_error(shots);
  EXPECT_GT(error, bound.target) << "reached: let the target gate, and say so in docs/lab.md";
  expect_accurate(shots, bound.reached);
}

double rms_ripple(const std::vector<Shot> &shots) {
  Vector sum;
  double squares = 0;
  for (const Shot &shot : shots)
    sum += force(shot.reading.velocity);
  const Vector mean = sum / static_cast<double>(shots.size());
  for (const Shot &shot : shots) {
    const Vector off = force(shot.reading.velocity) - mean;
    squares += off.dot(off);
  }
  return std::sqrt(squares / static_cast<double>(shots.size()));
}

// What does not move

class StillScene : public ::testing::TestWithParam<double> {};

TEST_P(StillScene, FeelsStillWhateverTheNoise) {
  constexpr int kScenes = 8;
  constexpr int kFrames = 60;
  constexpr int kLearning = 20; // frames from which it learns how noisy the camera is
  Random random(2);
  int false_motions = 0;
  int twice = 0;
  int looked_at = 0;
  for (int scene = 0; scene < kScenes; ++scene) {
    Movie movie = translation(random, {});
    movie.noise = GetParam();
    const cv::Mat1f light = movie.light(0);
    movie.light = [=](double) { return light.clone(); };
    bool before = false;
    const auto shots = stream(movie, kFrames, random);
    for (std::size_t i = kLearning; i < shots.size(); ++i) {
      const bool moves = cv::norm(force(shots[i].reading.velocity)) > 1;
      false_motions += moves;
      twice += moves && before;
      before = moves;
      ++looked_at;
    }
  }
  EXPECT_LE(false_motions, looked_at / 100);
  EXPECT_LE(twice, looked_at / 1000);
}

INSTANTIATE_TEST_SUITE_P(Noise, StillScene, ::testing::Values(1.5, 5, 10), [](const auto &test) {
  return "Sigma" + std::to_string(static_cast<int>(10 * test.param)) + "Tenths";
});

TEST(Stability, ABlankWallIsSilent) {
  const auto shots = pairs("textureless");
  EXPECT_GE(share(shots, [](const Shot &s) { return s.reading.confidence < 0.1; }), 0.99);
  for (const Shot &shot : shots)
    if (shot.is_measured()) {
      EXPECT_LE(cv::norm(force(shot.reading.velocity)), 5);
    }
}

TEST(Stability, AJpegOfAStillSceneIsStill) {
  const auto shots = pairs("jpeg still");
  EXPECT_GE(share(shots, [](const Shot &s) { return cv::norm(s.reading.velocity) == 0; }), 0.99);
}

TEST(Stability, AnH264VideoOfAStillSceneIsStill) {
  if (!has_h264())
    GTEST_SKIP() << kNoH264;
  const auto shots = pairs("h264 still");
  EXPECT_GE(share(shots, [](const Shot &s) { return cv::norm(s.reading.velocity) == 0; }), 0.99);
}

TEST(Stability, APointerThatMovesOverAFrameThatDoesNotFeelsNothing) {
  Random random(3);
  for (int scene = 0; scene < 10; ++scene) {
    const cv::Mat frame = embed(expose(translation(random, {}), 0, random), kFrame);
    const auto method = make_default();
    Vector pointer(0.5, 0.5);
    for (int i = 0; i < 40; ++i) {
      // 2000 px/s is 67 px from frame to frame; every eighth time it jumps anywhere.
      const Vector step = on_circle(random, random.uniform(0, 67));
      pointer += Vector(step.x / kFrame.width, step.y / kFrame.height);
      if (i % 8 == 7)
        pointer = {random.uniform(0, 1), random.uniform(0, 1)};
      pointer.x = std::clamp(pointer.x, 0.0, 1.0);
      pointer.y = std::clamp(pointer.y, 0.0, 1.0);
      const int side = 16 + static_cast<int>(random.index(60));
      const Reading reading = method->measure({frame, frame, pointer, side, i > 0});
      EXPECT_EQ(reading.velocity, Vector());
    }
  }
}

// Accuracy

TEST(Stability, ATranslationIsRightToAHundredthOfAPixel) {
  expect_accurate(pairs_of([](Random &r) { return uniform_translation(r, 3); }, 4), 0.010);
}

TEST(Stability, ALargeRegionIsRightToFourThousandths) {
  constexpr int kLarge = 100;
  constexpr int kWide = 256;
  expect_accurate(pairs_of(
                      [](Random &r) {
                        const Vector velocity(r.uniform(-3, 3), r.uniform(-3, 3));
                        return translation(r, velocity, 1, kWide);
                      },
                      5, 40, kLarge),
                  0.004);
}

TEST(Stability, NoSixteenthOfAPixelIsPreferred) {
  for (int phase = 0; phase < 16; ++phase) {
    const Vector truth(1 + phase / 16.0, -phase / 16.0);
    const auto shots = pairs_of([&](Random &r) { return translation(r, truth); }, 6, 60);
    Vector bias;
    for (const Shot &shot : shots)
      bias += (shot.reading.velocity - truth) / static_cast<double>(shots.size());
    EXPECT_LE(cv::norm(bias), 0.005) << phase << " sixteenths";
  }
}

TEST(Stability, LowContrastIsNearTheBoundOrRejected) {
  const auto shots =
      pairs_of(scene_named(hard_scenes(kSide), "low contrast").make, 1, kCases, kSide, true);
  double bound = 0;
  double errors = 0;
  for (const Shot &shot : shots)
    if (shot.reading.confidence >= 0.3) {
      errors += shot.error();
      bound += shot.bound;
    }
  EXPECT_LE(errors, 1.3 * bound);
}

TEST(Stability, StrongNoiseOnMotion) {
  expect_accurate(pairs("noise 10"), Unreached{.target = 0.02, .reached = 0.028});
}

TEST(Stability, ALargerGainOrOffsetMovesNothing) {
  for (const char *scene : {"gain 0.7", "gain 1.2", "gain 1.4", "offset -40", "offset +40"}) {
    SCOPED_TRACE(scene);
    expect_accurate(pairs(scene), 0.015);
  }
}

TEST(Stability, FlickerOfLampsIsNotFelt) {
  Random random(7);
  for (const double speed : {0.0, 2.0}) {
    for (int scene = 0; scene < 6; ++scene) {
      Movie movie = translation(random, on_circle(random, speed), 0.8);
      const auto steady = movie.light;
      const double phase = random.uniform(0, 2 * std::numbers::pi);
      movie.light = [=](double time) {
        // 100 Hz seen 30 times a second.
        const double gain = 1 + 0.1 * std::sin(2 * std::numbers::pi * 100 / 30 * time + phase);
        return cv::Mat1f(cv::Mat(gain * steady(time)));
      };
      // Few at a time: the texture goes only so far.
      EXPECT_LE(rms_ripple(stream(movie, 12, random)), 3) << speed << " px, scene " << scene;
    }
  }
}

TEST(Stability, AShadowOnMovingLeavesChangesNothing) {
  expect_accurate(pairs("standing shadow"), 0.05);
}

TEST(Stability, AShadowThatMovesIsNoMotion) {
  expect_accurate(pairs("moving shadow"), 0.05);
}

TEST(Stability, LeavesBeforeAWhiteSky) {
  expect_accurate(pairs("saturated sky"), 0.03);
}

TEST(Stability, MotionBlur) {
  expect_accurate(pairs("motion blur"), 0.03);
}

TEST(Stability, AJpegThatMoves) {
  expect_accurate(pairs("jpeg moving"), 0.02);
}

TEST(Stability, AnH264VideoThatMoves) {
  if (!has_h264())
    GTEST_SKIP() << kNoH264;
  expect_accurate(pairs(kRoundedMotion, 1, 40), Unreached{.target = 0.02, .reached = 0.15});
}

TEST(Stability, WhatH264RoundsInOneFrameItMakesGoodInTheNext) {
  if (!has_h264())
    GTEST_SKIP() << kNoH264;
  constexpr int kFrames = 14;
  constexpr int kSettling = 4; // frames after the key frame
  Random random(22);
  std::vector<double> drifts;
  for (int scene = 0; scene < 16; ++scene) {
    const Movie movie = uniform_translation(random, 2);
    std::vector<cv::Mat> clip;
    for (int time = 0; time < kFrames; ++time)
      clip.push_back(expose(movie, time, random));
    clip = through_h264(clip, 40);
    const auto method = make_default();
    Vector sum;
    for (std::size_t i = kSettling + 1; i < clip.size(); ++i)
      sum += look(*method, clip[i - 1], clip[i], i > kSettling + 1).velocity - movie.velocity;
    drifts.push_back(cv::norm(sum) / (kFrames - kSettling - 1));
  }
  std::cout << "error of the mean over nine frames " << mean(drifts) << " px\n";
  EXPECT_LE(mean(drifts), 0.025);
}

TEST(Stability, CombedLinesOfAnInterlacedFrame) {
  expect_accurate(pairs("interlaced"), 0.05);
}

TEST(Stability, RollingShutter) {
  expect_accurate(pairs("rolling shutter"), 0.03);
}

// Range

TEST(Stability, SixteenPixelsAreHeld) {
  std::vector<Shot> shots;
  for (const char *scene : {"displacement 8", "displacement 12", "displacement 16"}) {
    const auto some = pairs(scene);
    shots.insert(shots.end(), some.begin(), some.end());
  }
  EXPECT_GE(share(shots, &Shot::is_measured), 0.95);
  EXPECT_LE(share(shots, [](const Shot &s) { return s.is_measured() && s.error() > 0.5; }), 0.01);
}

TEST(Stability, WhatIsTooFastIsLostAndNotGuessed) {
  for (const double distance : {24.0, 32.0}) {
    const auto shots = pairs_of(
        [&](Random &r) {
          const Vector velocity = on_circle(r, distance);
          return translation(r, velocity);
        },
        8);
    EXPECT_GE(
        share(shots, [](const Shot &s) { return s.reading.confidence < 0.2 || s.error() <= 0.5; }),
        0.99)
        << distance << " px";
  }
}

TEST(Stability, ASceneCutIsNotFelt) {
  const auto shots = pairs("scene cut", 9, 400);
  EXPECT_GE(share(shots,
                  [](const Shot &s) {
                    return s.reading.confidence < 0.2 || cv::norm(force(s.reading.velocity)) <= 30;
                  }),
            0.995);
}

TEST(Stability, WavesThatCouldHaveMovedEitherWayAreDoubted) {
  EXPECT_GE(share(pairs("periodic"), [](const Shot &s) { return s.reading.confidence < 0.2; }),
            0.95);
}

TEST(Stability, WavesThatSpeedUpAreFollowed) {
  Random random(10);
  const Movie still = scene_named(hard_scenes(kSide), "periodic").make(random);
  const auto method = make_default();
  double place = 0;
  cv::Mat previous = embed(expose(still, 0, random), kFrame);
  for (const double shift : {1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0}) {
    place += shift / still.velocity.x;
    const cv::Mat current = embed(expose(still, place, random), kFrame);
    const Reading reading = look(*method, previous, current, place * still.velocity.x > 1);
    EXPECT_LE(cv::norm(reading.velocity - Vector(shift, 0)), 0.1) << shift;
    previous = current;
  }
}

TEST(Stability, OfBarsOnlyTheMotionAcrossThemIsFelt) {
  Random random(11);
  const Scene grating = scene_named(hard_scenes(kSide), "aperture");
  std::vector<double> across;
  std::vector<double> along;
  for (int i = 0; i < kCases; ++i) {
    const Movie movie = grating.make(random);
    const cv::Mat previous = embed(expose(movie, 0, random), kFrame);
    const Reading reading =
        look(*make_default(), previous, embed(expose(movie, 1, random), kFrame));
    if (reading.confidence <= 0)
      continue;
    const Vector normal = movie.velocity / cv::norm(movie.velocity);
    across.push_back(std::abs((reading.velocity - movie.velocity).dot(normal)));
    along.push_back(std::abs(reading.velocity.cross(normal)));
  }
  EXPECT_GE(across.size(), 0.9 * kCases);
  EXPECT_LE(mean(across), 0.05);
  EXPECT_LE(mean(along), 0.05);
}

// Motions that are more than a translation

TEST(Stability, ATurnAboutThePointerIsNoTranslation) {
  Random random(12);
  const Scene scene = scene_named(hard_scenes(kSide), "rotation");
  std::vector<double> spins;
  const auto shots = pairs_of(scene.make, 12);
  for (const Shot &shot : shots)
    if (shot.is_measured())
      spins.push_back(std::abs(shot.reading.spin - 5 * kDegree));
  expect_accurate(shots, 0.03);
  EXPECT_LE(mean(spins), 0.2 * kDegree);
}

TEST(Stability, AZoomAboutThePointerIsNoTranslation) {
  std::vector<double> off;
  const auto shots = pairs("zoom");
  for (const Shot &shot : shots)
    if (shot.is_measured())
      off.push_back(std::abs(shot.reading.divergence - 0.05));
  expect_accurate(shots, 0.03);
  EXPECT_LE(mean(off), 0.2 * kDegree); // as much as a turn may be off, in radians
}

TEST(Stability, ALeafThatIsSqueezedOrBends) {
  expect_accurate(pairs("affine"), 0.05);
  expect_accurate(pairs("curl"), Unreached{.target = 0.05, .reached = 0.055});
}

TEST(Stability, TheShakeOfTheCameraIsFeltWithTheWind) {
  // The region alone cannot tell one from the other.
  expect_accurate(pairs("camera shake", 1, 40), 0.03);
}

TEST(Stability, OfTwoMotionsTheMeanByAreaIsFelt) {
  expect_accurate(pairs("two motions"), 0.10);
}

TEST(Stability, TwoMotionsDoNotTakeTurns) {
  Random random(13);
  const Scene scene = scene_named(hard_scenes(kSide), "two motions");
  for (int i = 0; i < 20; ++i) {
    const auto shots = stream(scene.make(random), 10, random, Surroundings::rest);
    for (std::size_t k = 1; k < shots.size(); ++k)
      EXPECT_LE(cv::norm(force(shots[k].reading.velocity) - force(shots[k - 1].reading.velocity)),
                60)
          << "scene " << i << ", frame " << k;
  }
}

TEST(Stability, ASmallThingThatMovesCountsByItsArea) {
  const auto shots = pairs("mover");
  expect_accurate(shots, 0.15);
}

TEST(Stability, NoneOfAThousandMoversIsStillWithAConfidenceAboveNineTenths) {
  constexpr int kMovers = 1000;
  const auto make = scene_named(hard_scenes(kSide), "mover").make;
  Random random(23);
  for (int i = 0; i < kMovers; ++i) {
    const auto [previous, current] = expose_pair(make(random), random);
    const Reading reading = look(*make_default(), embed(previous, kFrame), embed(current, kFrame));
    EXPECT_FALSE(reading.confidence > 0.9 && reading.velocity == Vector()) << "mover " << i;
  }
}

TEST(Stability, AReflectionDoesNotHideWhatIsBehindIt) {
  expect_accurate(pairs("overlay"), Unreached{.target = 0.12, .reached = 0.195});
}

// Time, place and size

TEST(Stability, UnevenTimeStampsDoNotChangeTheVelocity) {
  Random random(14);
  constexpr double kSpeed = 100; // px/s
  const Movie movie = translation(random, {1, 0});
  const auto tracker = haptic::make_layer_tracker();
  haptic::Measurement measurement;
  for (int i = 0; i < 40; ++i) {
    const double interval = random.uniform(0.005, 0.1);
    cv::Mat previous = expose(movie, 0, random);
    cv::Mat current = expose(movie, kSpeed * interval, random);
    const haptic::Rectangle region{(kWindow - kSide) / 2, (kWindow - kSide) / 2, kSide, kSide};
    const auto crop = haptic::crop_around(region, tracker->margin(kSide), kWindow, kWindow);
    const auto view = [&](const cv::Mat &frame) {
      return haptic::LumaView{frame.ptr(crop.y) + crop.x, crop.width, crop.height,
                              static_cast<std::ptrdiff_t>(frame.step)};
    };
    tracker->measure({.previous = view(previous),
                      .current = view(current),
                      .crop = crop,
                      .region = region,
                      .seconds = static_cast<float>(interval)},
                     measurement);
    const auto estimate =
        haptic::estimate_velocity({.patches = measurement.view(),
                                   .candidates = measurement.candidates,
                                   .pointer_x = kWindow / 2.0F,
                                   .pointer_y = kWindow / 2.0F,
                                   .interval = interval},
                                  haptic::Average::model, haptic::ModelChoice::automatic);
    EXPECT_NEAR(estimate.velocity_x, kSpeed, 0.02 * kSpeed) << interval << " s";
  }
}

TEST(Stability, APointerThatMovesWithTheVideoRunningDisturbsLittle) {
  Random random(15);
  std::vector<Shot> pursued;
  std::vector<Shot> fresh;
  for (int scene = 0; scene < 40; ++scene) {
    const Movie movie = uniform_translation(random, 2);
    const auto method = make_default();
    const Vector direction = on_circle(random, 1);
    cv::Mat previous = embed(expose(movie, 0, random), kFrame);
    for (int i = 1; i < 6; ++i) {
      const cv::Mat current = embed(expose(movie, i, random), kFrame);
      // 2000 px/s, to and fro so that it stays in what was rendered.
      const double way = 2000.0 / 30 * (i % 2 ? 0.5 : -0.5);
      const Task task{
          previous,
          current,
          {0.5 + direction.x * way / kFrame.width, 0.5 + direction.y * way / kFrame.height},
          kSide,
          i > 1};
      pursued.push_back({method->measure(task), movie.velocity});
      Task anew = task;
      anew.continues = false;
      fresh.push_back({make_default()->measure(anew), movie.velocity});
      previous = current;
    }
  }
  EXPECT_LE(mean_error(pursued), 1.10 * mean_error(fresh));
}

TEST(Stability, AtABorderTheErrorAtMostDoubles) {
  std::vector<Shot> centre;
  std::vector<Shot> border;
  Random random(16);
  for (int i = 0; i < kCases; ++i) {
    const Movie movie = uniform_translation(random, 3);
    const cv::Mat previous = expose(movie, 0, random);
    const cv::Mat current = expose(movie, 1, random);
    const auto at = [&](Vector pointer) {
      return Shot{make_default()->measure({previous, current, pointer, kSide, false}),
                  movie.velocity};
    };
    const std::array<Vector, 6> places = {Vector{0, 0.5}, {1, 0.5},     {0.5, 0},
                                          {0.5, 1},       {0.04, 0.04}, {0.97, 0.96}};
    centre.push_back(at({0.5, 0.5}));
    border.push_back(at(places[static_cast<std::size_t>(i) % places.size()]));
  }
  // The targets are 0.95 and 2, see docs/lab.md.
  EXPECT_GE(share(border, &Shot::is_measured), 0.92);
  EXPECT_LE(mean_error(border), 2.5 * mean_error(centre));
}

TEST(Stability, ARegionThatGrowsAndShrinksGivesNoJolt) {
  Random random(17);
  for (int scene = 0; scene < 10; ++scene) {
    const Movie movie = uniform_translation(random, 2);
    const auto method = make_default();
    cv::Mat previous = embed(expose(movie, 0, random), kFrame);
    const std::array<int, 7> sides = {30, 30, 34, 60, 58, 12, 30};
    for (std::size_t i = 0; i < sides.size(); ++i) {
      const cv::Mat current = embed(expose(movie, static_cast<double>(i + 1), random), kFrame);
      const Reading reading = look(*method, previous, current, i > 0, sides[i]);
      if (reading.confidence > 0) {
        EXPECT_LE(cv::norm(force(reading.velocity) - force(movie.velocity)), 30)
            << sides[i] << " px, scene " << scene;
      }
      previous = current;
    }
  }
}

// Pixels between pages that nobody may touch.
class GuardedCrop {
public:
  enum class Against { before, behind };

  GuardedCrop(const cv::Mat &pixels, Against side)
      : page_(static_cast<std::size_t>(sysconf(_SC_PAGESIZE))),
        size_(page_ * (2 * static_cast<std::size_t>(pixels.rows) + 1)),
        memory_(static_cast<std::uint8_t *>(
            mmap(nullptr, size_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))) {
    const auto width = static_cast<std::size_t>(pixels.cols);
    const std::size_t offset = side == Against::before ? 0 : page_ - width;
    for (int y = 0; y < pixels.rows; ++y) {
      std::uint8_t *row = memory_ + page_ * (2 * static_cast<std::size_t>(y) + 1);
      EXPECT_EQ(mprotect(row, page_, PROT_READ | PROT_WRITE), 0);
      std::copy_n(pixels.ptr(y), width, row + offset);
      EXPECT_EQ(mprotect(row, page_, PROT_READ), 0);
    }
    view = {memory_ + page_ + offset, pixels.cols, pixels.rows,
            static_cast<std::ptrdiff_t>(2 * page_)};
  }
  ~GuardedCrop() { munmap(memory_, size_); }
  GuardedCrop(const GuardedCrop &) = delete;
  GuardedCrop &operator=(const GuardedCrop &) = delete;

  haptic::LumaView view;

private:
  std::size_t page_;
  std::size_t size_;
  std::uint8_t *memory_;
};

TEST(Stability, NothingOutsideTheCropIsRead) {
  Random random(18);
  const auto scenes = hard_scenes(kSide);
  for (const char *scene : {"still noise 1.5", "motion blur", "rotation", "scene cut", "aperture"})
    for (const int side : {13, 30, 45}) {
      const auto tracker = haptic::make_layer_tracker();
      const haptic::Rectangle region{(kWindow - side) / 2, (kWindow - side) / 2, side, side};
      const auto crop = haptic::crop_around(region, tracker->margin(side), kWindow, kWindow);
      const Movie movie = scene_named(scenes, scene).make(random);
      const cv::Rect rect(crop.x, crop.y, crop.width, crop.height);
      const cv::Mat previous = expose(movie, 0, random)(rect);
      const cv::Mat current = expose(movie, 1, random)(rect);
      for (const auto against : {GuardedCrop::Against::before, GuardedCrop::Against::behind}) {
        const GuardedCrop first(previous, against);
        const GuardedCrop second(current, against);
        // To and fro, until the layers speak.
        for (int i = 0; i < 6; ++i) {
          haptic::Measurement measurement;
          tracker->measure({.previous = i % 2 == 0 ? first.view : second.view,
                            .current = i % 2 == 0 ? second.view : first.view,
                            .crop = crop,
                            .region = region,
                            .continues = i > 0,
                            .seconds = 1.0F / 30},
                           measurement);
          EXPECT_LE(measurement.count, haptic::kMaxPatches); // it is still alive
        }
      }
    }
}

TEST(Stability, NumbersThatAreNotFiniteNeverComeOut) {
  constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(), -1e30F, 0};
  Random random(19);
  for (int i = 0; i < 2000; ++i) {
    std::array<haptic::Patch, 12> patches;
    for (auto &patch : patches) {
      std::array<float, 10> numbers;
      for (float &number : numbers)
        number = random.index(8) == 0 ? kBad[random.index(std::size(kBad))]
                                      : static_cast<float>(random.uniform(-40, 40));
      patch = {numbers[0], numbers[1], numbers[2], numbers[3], numbers[4],
               numbers[5], numbers[6], numbers[7], numbers[8], numbers[9]};
    }
    for (const double interval : {1.0 / 30, 0.0, -0.1, 1e-300}) {
      const auto e =
          haptic::estimate_velocity({.patches = patches, .candidates = 12, .interval = interval},
                                    haptic::Average::model, haptic::ModelChoice::automatic);
      for (const float number : {e.velocity_x, e.velocity_y, e.spin, e.divergence, e.confidence})
        EXPECT_TRUE(std::isfinite(number));
    }
  }
}

// Whether it knows

Judged answers_to_all_scenes(std::uint64_t seed, int cases) {
  Judged answers;
  for (const Scene &scene : hard_scenes(kSide)) {
    if (scene.name == kRoundedMotion)
      continue;
    for (const Shot &shot : pairs_of(scene.make, seed++, cases))
      answers.add(shot.reading.confidence, shot.error(), shot.is_unseen);
  }
  return answers;
}

TEST(Stability, MoreConfidenceMeansFewerErrors) {
  constexpr int kCasesOfASeed = 16; // of each scene: about 560 answers
  Judged answers;
  for (const std::uint64_t seed : {20, 120, 220, 320, 420}) {
    const Judged some = answers_to_all_scenes(seed, kCasesOfASeed);
    std::cout << "seed " << seed << ": area under the ROC " << some.area() << "\n";
    EXPECT_GE(some.area(), 0.965) << "seed " << seed;
    answers.add(some);
  }

  constexpr int kBins = 5;
  constexpr int kEnough = 20; // answers in a bin, fewer say nothing
  double before = 1;
  int compared = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    int count = 0;
    int wrong = 0;
    for (std::size_t i = 0; i < answers.errors.size(); ++i)
      if (std::min(kBins - 1, static_cast<int>(kBins * answers.confidences[i])) == bin) {
        ++count;
        wrong += answers.errors[i] > 0.15;
      }
    if (count < kEnough)
      continue;
    const double rate = static_cast<double>(wrong) / count;
    EXPECT_LE(rate, before) << "bin " << bin;
    before = rate;
    ++compared;
  }
  EXPECT_GE(compared, 2);
}

TEST(Stability, TheSmallestModelThatExplainsTheFrameIsChosen) {
  using haptic::MotionModel;
  const auto signed_uniform = [](Random &r, double from, double to) {
    return r.uniform(from, to) * (r.uniform(-1, 1) < 0 ? -1 : 1);
  };
  const auto scenes = hard_scenes(kSide);
  const struct {
    MotionModel model;
    double least;   // the target is 0.95 (still 0.99), see docs/lab.md
    double overfit; // the target is 0.03
    std::function<Movie(Random &)> make;
  } rows[] = {
      {MotionModel::still, 0.99, 0.03, scene_named(scenes, "still noise 1.5").make},
      {MotionModel::translation, 0.95, 0.03,
       [&](Random &r) {
         const double x = signed_uniform(r, 0.3, 4);
         return translation(r, {x, signed_uniform(r, 0.3, 4)});
       }},
      {MotionModel::similarity, 0.95, 0.03, scene_named(scenes, "rotation").make},
      {MotionModel::affine, 0.93, 0.03, scene_named(scenes, "affine").make},
  };
  for (const auto &row : rows) {
    int right = 0;
    int larger = 0;
    for (const Shot &shot : pairs_of(row.make, 21)) {
      right += shot.reading.model == row.model;
      larger += shot.reading.model > row.model;
    }
    std::cout << haptic::motion_model_name(row.model) << ": right " << right << ", larger "
              << larger << " of " << kCases << "\n";
    EXPECT_GE(right, row.least * kCases) << haptic::motion_model_name(row.model);
    EXPECT_LE(larger, row.overfit * kCases) << haptic::motion_model_name(row.model) << ", over-fit";
  }
}

} // namespace
