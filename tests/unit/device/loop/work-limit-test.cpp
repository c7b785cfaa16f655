// SPDX-License-Identifier: LGPL-2.1-or-later
// The limit of the work, by what the strings really do on a hand that is led round: a film that
// always pushes it on must not do more.
#include "loop-in-hand.hpp"

#include <deque>
#include <gtest/gtest.h>

namespace work_limit_test {

using spidar::Vector3;

struct Round {
  std::string geometry;
  double max_force; // N
  double slew_rate; // N/s
  double speed;     // m/s
  double ahead;     // s, of the film before the hand

  friend void PrintTo(const Round &round, std::ostream *out) {
    *out << round.geometry << ", " << round.max_force << " N, " << round.slew_rate << " N/s, "
         << round.speed << " m/s, film " << round.ahead << " s ahead";
  }
};

class WorkLimit : public ::testing::TestWithParam<Round> {};

TEST_P(WorkLimit, InAnyFiveSecondsTheStringsDoAtMostTwoAndAHalfJoules) {
  constexpr double kRadius = 0.02; // m
  const Round &round = GetParam();
  haptic::LoopSettings settings;
  settings.law_settings = {.max_force = round.max_force, .alpha = 10};
  settings.slew_rate = round.slew_rate;
  settings.damping = 0;
  settings.continuous_force = 0;
  test::LoopInHand held(
      {.geometry = round.geometry, .start = {kRadius, 0, 0}, .settings = settings});
  held.frame = 10 * test::LoopInHand::kMs;
  held.hand().leads = true;
  held.hand().speed = round.speed;

  std::deque<double> done; // J, of each of the last 5000 ticks of 1 ms; what the hand does is none
  double work = 0;
  double before = held.hand().work();
  while (held.time() < 10) {
    const double angle = round.speed / kRadius * held.time();
    const double film = angle + round.speed / kRadius * round.ahead;
    held.film = 5000 * Vector3(-std::sin(film), -std::cos(film), 0); // px/s, y down
    held.hand().goal = kRadius * Vector3(std::cos(angle), std::sin(angle), 0);
    held.tick();
    done.push_back(std::max(held.hand().work() - before, 0.0));
    before = held.hand().work();
    work += done.back();
    if (done.size() > 5000) {
      work -= done.front();
      done.pop_front();
    }
    ASSERT_LE(work, 2.5) << "after " << held.time() << " s";
  }
  EXPECT_GT(work, 0.5); // the film did carry the hand
  EXPECT_EQ(held.loop.statistics().overspeeds, 0U);
}

// While its fault lasts, a device is asked ten times a second, and its strings pull a hand that
// moves by their least tension.
TEST(WorkLimitOfAFaultedDevice, CountsWhatTheStringsDidOnce) {
  test::LoopInHand held({});
  held.hand().leads = true;
  held.wait(0.5);
  held.hand().answers = false;
  for (int i = 0; i < 5; ++i)
    held.tick();
  held.hand().answers = true;
  for (int i = 0; i < 10; ++i) {
    held.lead({0.02, 0.02, 0}, 0.08);
    held.lead({-0.02, -0.02, 0}, 0.08);
  }
  held.lead(Vector3::Zero(), 0.08);
  held.film = {100, 0, 0};
  held.loop.unhold(haptic::kLatches);
  held.wait(0.8);
  EXPECT_NEAR(held.force().x(), 0.5, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Rounds, WorkLimit,
                         testing::Values(Round{"spidar-g6x3r", 5, 100, 0.9, 0.05},
                                         Round{"spidar-g6x3r", 5, 20, 0.3, 0.05},
                                         Round{"spidar-g6x3r", 2.5, 100, 0.9, 0.05},
                                         Round{"spidar-g6x3r", 1, 20, 0.9, 0.05},
                                         Round{"spidar-g6x3l", 5, 1000, 0.9, 0.03},
                                         Round{"spidar-g6x4", 5, 100, 0.9, 0.05},
                                         Round{"spidar-g6x5r", 5, 100, 0.9, 0.05},
                                         Round{test::kArmName, 12, 100, 0.9, 0.05},
                                         Round{test::kArmName, 1, 20, 0.9, 0.05}));

} // namespace work_limit_test
