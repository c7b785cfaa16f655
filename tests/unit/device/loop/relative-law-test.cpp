// SPDX-License-Identifier: LGPL-2.1-or-later
// The laws that know the hand's motion, in closed loop over a still frame: what a tap begins must
// come to rest.
#include "loop-in-hand.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <ostream>

namespace relative_law_test {

using spidar::Vector3;
using test::Hand;

struct Case {
  const char *geometry;
  const char *law;
  double alpha;     // s/px
  double max_force; // N
  double rate;      // Hz
  double late = 0;  // ms, of one tick in ten

  friend void PrintTo(const Case &c, std::ostream *out) {
    *out << c.geometry << ", " << c.law << ", alpha " << c.alpha << ", " << c.max_force << " N, "
         << c.rate << " Hz, late by up to " << c.late << " ms";
  }
};

haptic::LoopSettings settings_of(const Case &c) {
  haptic::LoopSettings settings;
  while (haptic::force_laws()[settings.law].name != std::string(c.law))
    ++settings.law;
  settings.law_settings.alpha = c.alpha;
  settings.law_settings.max_force = c.max_force;
  settings.continuous_force = 0;
  return settings;
}

// Peak to peak along the tap, N.
double unrest(test::LoopInHand &held, double seconds) {
  double least = held.force().x();
  double most = least;
  for (const double end = held.time() + seconds; held.time() < end;) {
    held.tick();
    least = std::min(least, held.force().x());
    most = std::max(most, held.force().x());
  }
  return most - least;
}

class RelativeLaw : public ::testing::TestWithParam<Case> {};

TEST_P(RelativeLaw, OverAStillFrameATapOnALightHandComesToRest) {
  constexpr double kTap = 0.02; // s
  for (const Hand &hand : {Hand{0.1, 0.5, 0}, Hand{0.1, 0.5, 20}, Hand{0.1, 0.5, 300},
                           Hand{1, 0.5, 0}, Hand{1, 8, 300}})
    for (const double impulse : {0.01, 0.08}) { // N·s; 0.1 lets go of the lightest hand
      SCOPED_TRACE(testing::Message() << hand.mass << " kg, " << hand.damping << " N·s/m, "
                                      << hand.stiffness << " N/m, " << impulse << " N·s");
      test::LoopInHand held({.geometry = GetParam().geometry,
                             .hand = hand,
                             .start = {0.004, -0.002, 0.001}, // m
                             .pace = {.rate = GetParam().rate, .late = GetParam().late},
                             .settings = settings_of(GetParam())});
      held.wait(0.3);
      held.hand().push.x() = impulse / kTap;
      EXPECT_GT(unrest(held, kTap), 0.003); // N: the law is at work; 0.5 N·s/m of 10 mm/s at least
      held.hand().push.setZero();
      held.wait(4);
      EXPECT_LE(unrest(held, 2), 0.05);
      EXPECT_EQ(held.loop.statistics().overspeeds, 0U); // nor is that because the grip was let go
    }
}

INSTANTIATE_TEST_SUITE_P(Cases, RelativeLaw,
                         testing::Values(Case{"spidar-g6x3r", "drag", 0.01, 1, 1000},
                                         Case{"spidar-g6x3r", "drag", 0.04, 5, 1000},
                                         Case{"spidar-g6x3r", "drag", 0.04, 5, 2000},
                                         Case{"spidar-g6x3r", "drag", 0.04, 5, 500},
                                         Case{"spidar-g6x3r", "drag", 0.04, 5, 1000, 10},
                                         Case{"spidar-g6x4", "drag", 0.04, 5, 1000},
                                         Case{"spidar-g6x5r", "drag", 0.04, 5, 1000},
                                         Case{"spidar-g6x3r", "inertial", 0.04, 1, 1000},
                                         Case{"spidar-g6x3r", "inertial", 0.04, 5, 1000},
                                         Case{"spidar-g6x3r", "inertial", 0.04, 5, 1000, 10},
                                         Case{"spidar-g6x4", "inertial", 0.01, 5, 1000},
                                         Case{"spidar-g6x4", "inertial", 0.04, 5, 1000},
                                         Case{"spidar-g6x5r", "inertial", 0.04, 5, 1000},
                                         Case{test::kArmName, "drag", 0.01, 1, 1000},
                                         Case{test::kArmName, "drag", 0.04, 12, 1000},
                                         Case{test::kArmName, "drag", 0.04, 12, 1000, 10},
                                         Case{test::kArmName, "inertial", 0.04, 12, 1000},
                                         Case{test::kArmName, "inertial", 0.04, 12, 500}));

} // namespace relative_law_test
