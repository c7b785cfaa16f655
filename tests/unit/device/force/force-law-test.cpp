// SPDX-License-Identifier: LGPL-2.1-or-later
#include "force/force-law.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>

namespace force_law_test {

using haptic::LawSettings;
using haptic::Motion;
using haptic::MotionSample;
using spidar::Vector3;

Vector3 felt(const char *name, double vx, double vy, const LawSettings &settings = {}) {
  for (const auto &law : haptic::force_laws())
    if (std::string(law.name) == name)
      return law.make()->wrench({.velocity = {vx, vy}}, {}, settings, 0.001).force;
  ADD_FAILURE() << "no law " << name;
  return Vector3::Zero();
}

// The paper's equation 5.
double equation5(double v, const LawSettings &s = {}) {
  return 2 * s.max_force / std::numbers::pi * std::atan(s.alpha * v);
}

MotionSample seen(double vx, double vy, std::uint32_t width = 352) {
  MotionSample sample;
  sample.velocity_x = static_cast<float>(vx);
  sample.velocity_y = static_cast<float>(vy);
  sample.confidence = 1;
  sample.frame_width = width;
  sample.frame_height = width * 3 / 4;
  return sample;
}

TEST(ForceLaws, TheFirstIsTheOneThatThePaperMeans) {
  EXPECT_STREQ(haptic::force_laws().front().name, "arctan");
}

TEST(ArctanLaw, IsEquation5OfTheSpeed) {
  for (double v : {1e-6, 0.01, 3.0, 20.0, 100.0, 400.0, 1e5})
    EXPECT_NEAR(felt("arctan", v, 0).x(), equation5(v), 1e-15 + 1e-12 * equation5(v)) << v;
  EXPECT_NEAR(felt("arctan", 100, 0).x(), 0.5, 1e-12);
}

TEST(ArctanLaw, IsOdd) {
  for (double v : {0.001, 7.0, 250.0}) {
    EXPECT_EQ(felt("arctan", v, 2 * v), -felt("arctan", -v, -2 * v));
    EXPECT_EQ(felt("arctan-axis", v, 2 * v), -felt("arctan-axis", -v, -2 * v));
  }
  EXPECT_TRUE(felt("arctan", 0, 0).isZero(0));
  EXPECT_TRUE(felt("arctan-axis", 0, 0).isZero(0));
}

TEST(ArctanLaw, NeverExceedsTheMaximumForce) {
  for (double v : {1.0, 1e3, 1e6, 1e12})
    EXPECT_LE(felt("arctan", v, -v, {.max_force = 2.5}).norm(), 2.5) << v;
}

TEST(ArctanLaw, TurnsWithTheMotion) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(0, 2 * std::numbers::pi);
  std::uniform_real_distribution<double> exponent(-3, 4);
  for (int i = 0; i < 1000; ++i) {
    const double v = std::pow(10, exponent(random));
    const double a = angle(random);
    const Vector3 force = felt("arctan", v * std::cos(a), v * std::sin(a));
    const Vector3 expected(equation5(v) * std::cos(a), -equation5(v) * std::sin(a), 0);
    ASSERT_LE((force - expected).norm(), 1e-12) << v << " px/s at " << a;
  }
}

TEST(ArctanLaw, PushesUpWhenTheFrameMovesUp) {
  for (const char *law : {"arctan", "arctan-axis"}) {
    EXPECT_GT(felt(law, 0, -50).y(), 0) << law;
    EXPECT_LT(felt(law, 0, 50).y(), 0) << law;
    EXPECT_GT(felt(law, 50, 0).x(), 0) << law;
  }
}

TEST(ArctanAxisLaw, IsEquation5OfEachAxisAsPrinted) {
  const Vector3 force = felt("arctan-axis", 300, -20);
  EXPECT_NEAR(force.x(), equation5(300), 1e-12);
  EXPECT_NEAR(force.y(), equation5(20), 1e-12);
  EXPECT_EQ(force.z(), 0);
}

TEST(MotionScale, TheSameVisibleMotionMeansTheSameInEveryFrame) {
  const Motion cif = haptic::scale_motion(seen(100, -50, 352), 352);
  EXPECT_NEAR(cif.velocity.x, 100, 1e-9);
  for (const std::uint32_t width : {1280U, 1920U, 3840U}) {
    const double larger = width / 352.0;
    const Motion same = haptic::scale_motion(seen(100 * larger, -50 * larger, width), 352);
    EXPECT_NEAR(same.velocity.x, cif.velocity.x, 1e-4);
    EXPECT_NEAR(same.velocity.y, cif.velocity.y, 1e-4);
  }
}

TEST(MotionScale, ReferenceWidthZeroKeepsThePixelsOfTheFrame) {
  EXPECT_EQ(haptic::scale_motion(seen(545, 0, 1920), 0).velocity.x, 545);
}

TEST(MotionScale, VerticalMotionIsCountedInPixelWidths) {
  MotionSample sample = seen(0, 120);
  sample.pixel_aspect_n = 12; // a pixel is 12 wide and 11 high
  sample.pixel_aspect_d = 11;
  EXPECT_NEAR(haptic::scale_motion(sample, 352).velocity.y, 110, 1e-9);
}

double kept(double vx, double vy = 0) {
  return haptic::MotionConditioner().step({.velocity = {vx, vy}}, 0, 0.001).velocity.x;
}

TEST(Deadband, StandstillIsFreeOfNoiseAndMotionIsLeftAsItIs) {
  EXPECT_EQ(kept(2, -2), 0);
  EXPECT_EQ(kept(3), 0);
  EXPECT_NEAR(kept(4.5), 3, 1e-9);
  EXPECT_EQ(kept(6), 6);
  EXPECT_EQ(kept(20), 20);
}

TEST(Deadband, HasNoStep) {
  double before = 0;
  for (double v = 0; v < 10; v += 0.001) {
    const double now = kept(v);
    ASSERT_GE(now, before);
    ASSERT_LE(now - before, 0.003);
    before = now;
  }
}

TEST(Deadband, AMotionThatTurnsRoundDoesNotStandStill) {
  haptic::MotionConditioner deadband;
  for (double v = 100; v > -100; v -= 1) // in 0.2 s
    ASSERT_EQ(deadband.step({.velocity = {v, 0}}, 0, 0.001).velocity.x, v);
}

TEST(Deadband, NoiseAfterAMotionIsSilentWithinHalfASecond) {
  haptic::MotionConditioner deadband;
  deadband.step({.velocity = {300, 0}}, 0, 0.001);
  Motion motion;
  for (int i = 0; i < 500; ++i)
    motion = deadband.step({.velocity = {2, 0}}, 0, 0.001);
  EXPECT_EQ(motion.velocity.x, 0);
}

TEST(MotionScale, AnImpossibleSpeedIsNotPlausible) {
  EXPECT_TRUE(haptic::is_plausible(seen(5000, -5000, 7680)));
  EXPECT_FALSE(haptic::is_plausible(seen(1e30, 0)));
  EXPECT_FALSE(haptic::is_plausible(seen(std::nan(""), 0)));
}

TEST(MotionScale, ASampleWithoutAFrameIsHarmless) {
  EXPECT_EQ(haptic::scale_motion({}, 352).velocity.x, 0);
}

// ---- the other laws -----------------------------------------------------------------------------

std::unique_ptr<haptic::ForceLaw> law(const std::string &name) {
  for (const auto &info : haptic::force_laws())
    if (name == info.name)
      return info.make();
  return nullptr;
}

Motion motion(double vx, double vy = 0) {
  return {.velocity = {vx, vy}};
}

constexpr double kTick = 0.001; // s

TEST(EveryLaw, IsOddAndTurnsWithTheMotion) {
  for (const char *name : {"arctan", "linear", "drag", "inertial"}) {
    for (double angle = 0.1; angle < 6.3; angle += 0.3) {
      const auto straight = law(name)->wrench(motion(120, 0), {30, 0}, {}, kTick).force;
      const Vector3 turned = law(name)
                                 ->wrench(motion(120 * std::cos(angle), 120 * std::sin(angle)),
                                          {30 * std::cos(angle), 30 * std::sin(angle)}, {}, kTick)
                                 .force;
      const Vector3 expected(straight.x() * std::cos(angle), -straight.x() * std::sin(angle), 0);
      EXPECT_LE((turned - expected).norm(), 1e-12) << name << " at " << angle;
    }
    EXPECT_TRUE(law(name)->wrench({}, {}, {}, kTick).force.isZero(0)) << name;
  }
}

TEST(EveryLaw, RecoversFromWhateverItIsGiven) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const auto &info : haptic::force_laws()) {
    const auto made = info.make();
    for (const double bad : {1e30, 1e300, infinity, std::nan("")})
      made->wrench({{bad, -bad}, bad, bad}, {bad, bad}, {}, kTick);
    Vector3 force = Vector3::Zero();
    for (int i = 0; i < 20'000; ++i)
      force = made->wrench(motion(100), {}, {}, kTick).force;
    EXPECT_TRUE(force.allFinite()) << info.name;
  }
}

TEST(LinearLaw, TheFastestMotionOfTheWindowGivesTheMaximumForce) {
  const auto linear = law("linear");
  const LawSettings settings{.max_force = 2, .gain_window = 1};
  const auto feel = [&](double v) {
    return linear->wrench(motion(v), {}, settings, kTick).force.x();
  };
  EXPECT_NEAR(feel(200), 2, 1e-12);
  EXPECT_NEAR(feel(50), 0.5, 1e-12);
  for (int i = 0; i < 900; ++i)
    feel(50);
  EXPECT_NEAR(feel(50), 0.5, 1e-12); // still remembered
  for (int i = 0; i < 200; ++i)
    feel(50);
  EXPECT_NEAR(feel(50), 2, 1e-12); // and forgotten
}

TEST(LinearLaw, SilenceIsNotAmplified) {
  const auto linear = law("linear");
  EXPECT_NEAR(linear->wrench(motion(1), {}, {.gain_window = 1}, kTick).force.x(), 0.1, 1e-12);
}

TEST(DragLaw, IsEquation5OfTheMotionRelativeToTheHand) {
  const auto drag = [](double v, double hand) {
    return law("drag")->wrench(motion(v), {hand, 0}, {}, kTick).force.x();
  };
  EXPECT_NEAR(drag(100, 0), equation5(100), 1e-12); // a hand at rest feels the paper's law
  EXPECT_EQ(drag(100, 100), 0);                     // one that goes along nothing
  EXPECT_NEAR(drag(100, 300), -equation5(200), 1e-12);
  EXPECT_NEAR(drag(100, -100), equation5(200), 1e-12);
}

TEST(DragLaw, TheHandChangesTheForceByAtMostWhatIsStable) {
  haptic::LawSettings settings;
  settings.most_for_hand = 0.1; // N
  const auto drag = [&](double v, double hand) {
    return law("drag")->wrench(motion(v), {hand, 0}, settings, kTick).force.x();
  };
  EXPECT_NEAR(drag(100, 100), equation5(100) - 0.1, 1e-12);
  EXPECT_NEAR(drag(0, 300), -0.1, 1e-12);
  EXPECT_NEAR(drag(100, 101), equation5(100) - 0.1, 1e-12);
  EXPECT_NEAR(drag(100, 5), equation5(95), 1e-12); // less than that: as the law says
}

TEST(InertialLaw, FeelsTheChangeOfTheMotionAndNotTheMotion) {
  const auto inertial = law("inertial");
  const auto feel = [&](double v) { return inertial->wrench(motion(v), {}, {}, kTick).force.x(); };
  for (int i = 0; i < 2000; ++i)
    feel(200);
  EXPECT_NEAR(feel(200), 0, 1e-6);
  double force = 0;
  for (int i = 0; i < 1000; ++i)
    force = feel(200 + 1000 * i * kTick); // 1000 px/s², over 0.1 s
  EXPECT_NEAR(force, equation5(100), 0.01);
}

TEST(Torque, FollowsTheRotationOnTheScreen) {
  const auto torque = [](double spin) -> Vector3 {
    return law("arctan")->wrench({.spin = spin}, {}, {}, kTick).torque;
  };
  EXPECT_NEAR(torque(1).z(), -0.01, 1e-12); // clockwise on the screen: against z, half of 20 mN·m
  EXPECT_NEAR(torque(-1).z(), 0.01, 1e-12);
  EXPECT_LT(torque(-1e6).z(), 0.02);
  EXPECT_EQ(torque(0.7).head<2>().norm(), 0);
}

TEST(Push, IsOffUnlessAskedForAndThenTowardsTheUser) {
  const Motion approach{.divergence = 0.5};
  EXPECT_EQ(law("arctan")->wrench(approach, {}, {}, kTick).force.z(), 0);
  EXPECT_NEAR(law("arctan")->wrench(approach, {}, {.max_push = 1}, kTick).force.z(), 0.5, 1e-12);
}

TEST(HandScale, TheWorkspaceIsTheFrame) {
  MotionSample sample = seen(0, 0);
  sample.frame_height = 288;
  const auto hand = haptic::scale_hand({0.01, 0.02, 5}, {0.025, 0.025, 0.025}, sample, 352);
  EXPECT_NEAR(hand.x, 0.01 / 0.05 * 352, 1e-9);
  EXPECT_NEAR(hand.y, -0.02 / 0.05 * 288, 1e-9); // down in the frame
}

} // namespace force_law_test
