// SPDX-License-Identifier: LGPL-2.1-or-later
// The model of haptic-track compare on reliefs: identity, and growth with each kind of change.
#include "depth-scene.hpp"
#include "felt/felt-file.hpp"
#include "felt/touch-signal.hpp"
#include "field-code/field-codec.hpp"
#include "forms/klv.hpp"
#include "part-file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <unistd.h>
#include <vector>

namespace touch_signal_test {

using haptic::Comparison;
using haptic::contact_force;
using haptic::FeltSurface;
using haptic::Force;
using haptic::ReliefCell;
using haptic::ReliefField;
using haptic::SignalPair;
using haptic::TimedPlace;
using test::DepthScene;

constexpr int kFrames = 150;
constexpr int kPlaces = 3;
constexpr double kMaxForce = 1; // N

using Surfaces = std::vector<FeltSurface>;
using Change = std::function<void(ReliefCell &)>;

std::uint64_t time_of(int frame) {
  return static_cast<std::uint64_t>(frame) * DepthScene::kInterval;
}

// The moving scene at three places of its middle row, changed.
std::vector<Surfaces> scene(const Change &change, int delay = 0) {
  std::vector<Surfaces> places(kPlaces);
  for (int i = 0; i < kFrames; ++i) {
    ReliefField relief = DepthScene::relief(i - delay, 32);
    for (ReliefCell &cell : relief.cells)
      change(cell);
    for (int place = 0; place < kPlaces; ++place)
      places[static_cast<std::size_t>(place)].push_back(
          haptic::felt_surface(relief, (place + 0.5) / kPlaces, 0.5, time_of(i)));
  }
  return places;
}

Comparison compare(const std::vector<Surfaces> &a, const std::vector<Surfaces> &b) {
  const double shift = haptic::best_shift(kPlaces, [&](std::size_t place) {
    return SignalPair(haptic::height_signal(a[place]), haptic::height_signal(b[place]));
  });
  return haptic::compare_at(shift, kPlaces, [&](std::size_t place) {
    return haptic::touch_signals(a[place], b[place], kMaxForce, shift);
  });
}

const auto kAsItIs = [](ReliefCell &) {};

double share_with(const Change &change, int delay = 0) {
  return compare(scene(kAsItIs), scene(change, delay)).all.distinguishable;
}

Change scaled(float factor) {
  return [factor](ReliefCell &cell) { cell.height *= factor; };
}

Change raised(float metres) {
  return [metres](ReliefCell &cell) { cell.height += metres; };
}

Change noisy(float metres) {
  auto random = std::make_shared<std::mt19937>(7);
  return [metres, random](ReliefCell &cell) {
    cell.height += metres * std::normal_distribution<float>()(*random);
  };
}

ReliefField slope(float rise) {
  ReliefField relief;
  relief.frame_width = 16;
  relief.frame_height = 16;
  relief.columns = 16;
  relief.rows = 16;
  for (int i = 0; i < 256; ++i)
    relief.cells.push_back({rise * 0.05F * (static_cast<float>(i % 16) - 7.5F) / 16, 100, 0, 1});
  return relief;
}

TEST(TouchSignal, AReliefAndItselfAreTheSame) {
  const Comparison result = compare(scene(kAsItIs), scene(kAsItIs));
  EXPECT_EQ(result.all.distinguishable, 0);
  EXPECT_EQ(result.all.force_rms, 0);
  EXPECT_EQ(result.shift, 0);
  EXPECT_GT(result.all.felt, 0.9) << "on all but steep edges";
}

TEST(TouchSignal, ItDoesNotMatterWhichIsTheFirst) {
  const auto a = scene(kAsItIs);
  const auto b = scene(scaled(1.02F));
  EXPECT_EQ(compare(a, b).all.distinguishable, compare(b, a).all.distinguishable);
}

TEST(TouchSignal, TheShareGrowsWithNoise) {
  EXPECT_EQ(share_with(noisy(1e-5F)), 0) << "0.01 mm are 2 mN";
  const double little = share_with(noisy(5e-5F));
  const double more = share_with(noisy(4e-4F));
  EXPECT_LT(little, more);
  EXPECT_GT(more, 0.2);
}

TEST(TouchSignal, TheShareGrowsWithTheScaleOfTheHeights) {
  const double little = share_with(scaled(1.004F));
  const double more = share_with(scaled(1.009F));
  const double most = share_with(scaled(1.3F));
  EXPECT_LT(little, more);
  EXPECT_LT(more, most);
  EXPECT_GT(most, 0.9);
}

// 0.2 N at 1 mm: the least difference, 30 mN, is 0.15 mm.
TEST(TouchSignal, AStepIsToldFromTheLeastForceOn) {
  EXPECT_EQ(share_with(raised(1.4e-4F)), 0);
  EXPECT_GT(share_with(raised(1.8e-4F)), 0.7) << "where it is not steep";
}

TEST(TouchSignal, ADelayIsFoundAndFeltFrom45MillisecondsOn) {
  const auto a = scene(kAsItIs);
  const Comparison one = compare(a, scene(kAsItIs, 1));
  EXPECT_NEAR(one.shift, 0.0333, 0.002);
  EXPECT_LT(one.all.distinguishable, 0.01);
  const Comparison ten = compare(a, scene(kAsItIs, 10));
  EXPECT_NEAR(ten.shift, 0.3333, 0.002);
  EXPECT_GT(ten.all.distinguishable, 0.9);
}

TEST(TouchSignal, StiffnessIsFelt) {
  const auto softer = [](ReliefCell &cell) { cell.stiffness = 100; };
  EXPECT_GT(share_with(softer), 0.8) << "where it is not steep";
  const auto harder = [](ReliefCell &cell) { cell.stiffness = 1000; };
  EXPECT_EQ(share_with(harder), 0) << "hapticsink holds 200 N/m at most";
}

TEST(TouchSignal, WhereOneHasNoSurfaceTheOtherIsFelt) {
  EXPECT_GT(share_with([](ReliefCell &cell) { cell = {}; }), 0.9);
}

TEST(TouchSignal, TheForceIsTheDepthAlongTheNormalTimesTheStiffness) {
  const FeltSurface flat = haptic::felt_surface(slope(0), 0.5, 0.5, 0);
  EXPECT_EQ(contact_force(flat, -0.002, kMaxForce), (Force{0, 0, 0.2F}));
  EXPECT_EQ(contact_force(flat, 0.002, kMaxForce), Force{}) << "above the surface";
  EXPECT_EQ(contact_force(flat, -0.02, kMaxForce), (Force{0, 0, 1})) << "the most";
  // A slope of 45 degrees that rises to the right pushes to the left.
  const FeltSurface slant = haptic::felt_surface(slope(1), 0.5, 0.5, 0);
  EXPECT_NEAR(slant.slope_x, 1, 1e-5);
  EXPECT_NEAR(slant.slope_y, 0, 1e-6);
  const Force force = contact_force(slant, -0.002, kMaxForce);
  EXPECT_NEAR(std::hypot(force.x, force.z), 100 * 0.002 / std::numbers::sqrt2, 1e-5);
  EXPECT_NEAR(force.x, -force.z, 1e-6);
  EXPECT_EQ(haptic::felt_surface(slope(0), 0.5, 0.5, 0).stiffness, 100);
}

TEST(TouchSignal, AHandThatMovesFeelsTheSurfaceWhereItIs) {
  // From the left to the right within the time between two reliefs, 1 mm beneath the plane.
  std::vector<TimedPlace> path;
  for (int i = 0; i <= 100; ++i)
    path.push_back({0.001 * i, 0.01F * static_cast<float>(i), 0.5F, -0.04F});
  const std::string file = testing::TempDir() + "touch-" + std::to_string(getpid()) + ".klv";
  haptic::ReliefEncoder encoder;
  std::vector<std::uint8_t> track;
  for (const std::uint64_t time : {0, 100'000'000})
    std::ranges::copy(haptic::write_klv(haptic::CodedField{encoder.push(slope(0.1F)).value(), time,
                                                           100'000'000, haptic::FieldKind::relief}),
                      std::back_inserter(track));
  haptic::write_bytes(file, track);
  haptic::FeltFile felt(file);
  std::filesystem::remove(file);
  felt.feel({{}, path}, {.max_force = kMaxForce}, {});
  const haptic::ForceSignal signal = felt.signal(0);
  ASSERT_EQ(signal.forces.size(), 101U);
  for (int ms = 0; ms <= 100; ms += 10) {
    const double x = 0.05 * (std::min(std::max(ms / 100.0, 0.5 / 16), 15.5 / 16) - 0.5);
    const double depth = std::max(0.1 * x + 0.001, 0.0);
    EXPECT_NEAR(signal.at(ms).z, 100 * depth / 1.01, 6e-3) << ms;
  }
}

TEST(TouchSignal, NoLineLeadsIntoAnotherScene) {
  FeltSurface before{.time = 0, .exists = true, .height = 0};
  FeltSurface after{.time = 0.1, .exists = true, .begins = true, .height = 0.01F};
  EXPECT_EQ(haptic::interpolated(before, after, 0.9).height, 0);
  EXPECT_EQ(haptic::interpolated(before, after, 1).height, 0.01F);
  after.begins = false;
  EXPECT_NEAR(haptic::interpolated(before, after, 0.9).height, 0.009, 1e-6);
}

} // namespace touch_signal_test
