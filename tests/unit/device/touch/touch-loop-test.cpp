// SPDX-License-Identifier: LGPL-2.1-or-later
// Hands that touch surfaces through the whole loop: what they feel stays within the slew rate,
// gives them no energy that the surface does not have, and shows them an edge.
#include "touched-surface.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <gtest/gtest.h>
#include <random>
#include <utility>
#include <vector>

namespace touch_loop_test {

using haptic::ReliefField;
using spidar::Vector3;
using test::kTick;
using test::TouchLoop;

class Hands : public ::testing::TestWithParam<test::HandModel> {};
INSTANTIATE_TEST_SUITE_P(Touch, Hands,
                         testing::Values(test::kLying, test::kLight, test::kStiff,
                                         test::kLyingOnArm, test::kLightOnArm, test::kStiffOnArm),
                         [](const auto &of) { return of.param.name; });

// 5 mm up or down with each frame, on half of them at once.
TEST_P(Hands, ASurfaceThatJumpsKeepsTheSlewRateAndGivesNoMoreThanItsOwnWork) {
  std::mt19937 random(7);
  double height = 0;
  const double stiffness = GetParam().stiffest();
  const double slew_rate = GetParam().slew_rate();
  ReliefField from = test::relief_of(test::flat(0), stiffness, 0.3, 8);
  ReliefField to = from;
  TouchLoop loop(GetParam(), {0, 0, 0.001});
  for (int frame = 0; frame < 300; ++frame) {
    height += (random() % 2 ? 0.005 : -0.005) * (std::abs(height) < 0.015 ? 1 : 0);
    height = std::clamp(height, -0.0125, 0.0125);
    from = to;
    to = test::relief_of(test::flat(height), stiffness, 0.3, 8);
    for (int ms = 0; ms < 33; ++ms) {
      const Vector3 force = loop.force;
      loop.tick({from, to, frame % 2 ? 1 : ms / 33.0, test::kHalf}, {0, 0, -0.004});
      ASSERT_LE(loop.force.norm() - force.norm(), slew_rate * kTick + 1e-12);
      ASSERT_LE((loop.force - force).norm(), 5 * slew_rate * kTick)
          << "what the hand has not put in goes";
    }
  }
  EXPECT_LE(loop.work, loop.surface_work);
}

// Sums of waves of 4 to 30 mm, with walls in some of them.
test::Shape random_shape(std::mt19937 &random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  struct Wave {
    double x, y, phase, size;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < 4; ++i) {
    const double length = 0.017 + 0.013 * uniform(random);
    const double angle = 3.2 * uniform(random);
    waves.push_back({2 * std::numbers::pi / length * std::cos(angle),
                     2 * std::numbers::pi / length * std::sin(angle), 3.2 * uniform(random),
                     0.08 * length});
  }
  const double wall = random() % 3 ? 0 : 0.004;
  return [=](double x, double y) {
    double height = x + y > 0.003 ? wall : 0;
    for (const Wave &wave : waves)
      height += wave.size * std::sin(wave.x * x + wave.y * y + wave.phase);
    return height;
  };
}

// The box around the places and the forces of a hand in some time.
class Extents {
public:
  void add(const TouchLoop &loop) {
    place_.extend(loop.position);
    force_.extend(Eigen::Matrix<double, 1, 1>(loop.force.norm()));
  }
  double moved() const { return place_.sizes().norm(); }   // m
  double changed() const { return force_.sizes().norm(); } // N

private:
  Eigen::AlignedBox3d place_;
  Eigen::AlignedBox1d force_;
};

// A hand that swings faster than the slew rate can follow may gain what the spring holds under the
// full force, F² / 2 k; none gains more with time.
void expect_neither_gain_nor_tremble(const test::HandModel &hand, unsigned seed) {
  constexpr int kTicks = 340'000;
  constexpr int kLed = 300;            // ms
  constexpr int kLooked = 200;         // ms
  constexpr double kMostChange = 0.05; // N
  constexpr int kLongest = 30'000;     // ms; a hand without friction slides on for some seconds
  const int touch = kLed + hand.swings + kLooked;
  const double stiffest = hand.stiffest();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  ReliefField relief;
  for (int n = 0; n < kTicks / touch; ++n) {
    // One number after another: a compiler may compute the arguments of a call in any order.
    if (n % 8 == 0) {
      const double friction = n % 3 ? 0.4 + 0.4 * uniform(random) : 0;
      const double stiffness = stiffest * (0.625 + 0.375 * uniform(random));
      relief = test::relief_of(random_shape(random), stiffness, friction);
    }
    const auto surface = test::surface_of(relief);
    Vector3 from(0, 0, 0.02);
    from.y() = 0.02 * uniform(random);
    from.x() = 0.02 * uniform(random);
    Vector3 aim;
    aim.z() = -0.004 - 0.01 * uniform(random);
    aim.y() = 0.02 * uniform(random);
    aim.x() = 0.02 * uniform(random);
    TouchLoop loop(hand, from);
    int ms = 0;
    for (; ms < touch - kLooked; ++ms)
      loop.tick(surface, from + std::min(1.0 * ms / kLed, 1.0) * (aim - from));
    // A hand that slides on feels the shape of the surface.
    Extents last;
    do {
      last = {};
      for (const int end = ms + kLooked; ms < end; ++ms) {
        loop.tick(surface, aim);
        last.add(loop);
      }
    } while (last.moved() > kMostChange / stiffest && last.changed() > kMostChange &&
             ms < kLongest);
    ASSERT_LE(last.changed(), kMostChange) << "touch " << n;
    // While it touches the arm, the hand uses some of what the flicker of its place may cost.
    const double of_touch = hand.device == &test::kArm ? 1e-3 * ms * test::kArm.flicker : 1e-6; // J
    const double most_work = hand.swings > 1000 ? 1 / (2 * stiffest) : of_touch;                // J
    ASSERT_LE(loop.work, most_work) << "touch " << n;
  }
}

// At the other seeds, hands on the arm once felt a force that went on and off.
TEST_P(Hands, NeitherGainEnergyNorTrembleOnRandomSurfaces) {
  if (const char *seed = std::getenv("FEELING_WIND_SEED"))
    return expect_neither_gain_nor_tremble(GetParam(), static_cast<unsigned>(std::atoi(seed)));
  for (const unsigned seed : {11, 14, 18, 19, 20}) {
    SCOPED_TRACE(seed);
    expect_neither_gain_nor_tremble(GetParam(), seed);
  }
}

// An explorer presses with 0.15 N, moves to the right, and takes the place where the force first
// differs by 0.08 N from what it was: more than hands need.
class Explorers : public ::testing::TestWithParam<std::pair<test::HandModel, test::HandModel>> {};
INSTANTIATE_TEST_SUITE_P(Touch, Explorers,
                         testing::Values(std::pair(test::kStiff, test::kLight),
                                         std::pair(test::kStiffOnArm, test::kLightOnArm)),
                         [](const auto &of) { return of.param.first.name; });

TEST_P(Explorers, FindAStepOfTwoMillimetresWithinOneByTheForceAlone) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  constexpr int kTrials = 100;
  constexpr int kMs = 1000;
  int found = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const double edge = 0.01 * uniform(random);
    const double step = trial % 2 ? 0.002 : -0.002;
    const test::HandModel &hand = trial % 4 < 2 ? GetParam().first : GetParam().second;
    const double stiffness = hand.stiffest() * (0.75 + 0.25 * uniform(random));
    const ReliefField relief =
        test::relief_of([&](double x, double) { return x < edge ? 0 : step; }, stiffness, 0.2);
    const double press = 0.15 / hand.stiffness + 0.15 / stiffness; // m
    TouchLoop loop(hand, {-0.02, 0, 0.001});
    Vector3 usual = Vector3::Zero();
    double place = 1;
    for (int ms = -500; ms < kMs && place == 1; ++ms) {
      loop.tick(test::surface_of(relief), {-0.02 + 0.04 * std::max(ms, 0) / kMs, 0, -press});
      if (ms >= 50 && ms < 150)
        usual += loop.force / 100;
      if (ms >= 150 && (loop.force - usual).norm() > 0.08)
        place = loop.position.x();
    }
    found += std::abs(place - edge) < 0.001;
  }
  EXPECT_GE(found, 95);
}

} // namespace touch_loop_test
