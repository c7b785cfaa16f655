#include "force-law.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

namespace {

using haptic::LawSettings;
using haptic::Motion;
using haptic::MotionSample;
using spidar::Vector3;

Vector3 felt(const char *name, double vx, double vy, const LawSettings &settings = {}) {
  for (const auto &law : haptic::force_laws())
    if (std::string(law.name) == name)
      return law.make()->force({vx, vy}, {}, settings);
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
  sample.picture_width = width;
  sample.picture_height = width * 3 / 4;
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

TEST(ArctanLaw, PushesUpWhenThePictureMovesUp) {
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

TEST(MotionScale, TheSameVisibleMotionMeansTheSameInEveryPicture) {
  const Motion cif = haptic::scale_motion(seen(100, -50, 352), 352);
  const Motion hd = haptic::scale_motion(seen(100 * 1920 / 352.0, -50 * 1920 / 352.0, 1920), 352);
  EXPECT_NEAR(cif.velocity_x, 100, 1e-9);
  EXPECT_NEAR(hd.velocity_x, cif.velocity_x, 1e-4);
  EXPECT_NEAR(hd.velocity_y, cif.velocity_y, 1e-4);
}

TEST(MotionScale, ReferenceWidthZeroKeepsThePixelsOfThePicture) {
  EXPECT_EQ(haptic::scale_motion(seen(545, 0, 1920), 0).velocity_x, 545);
}

TEST(MotionScale, VerticalMotionIsCountedInPixelWidths) {
  MotionSample sample = seen(0, 120);
  sample.pixel_aspect_n = 12; // a pixel is 12 wide and 11 high
  sample.pixel_aspect_d = 11;
  EXPECT_NEAR(haptic::scale_motion(sample, 352).velocity_y, 110, 1e-9);
}

TEST(MotionScale, StandstillIsFreeOfNoiseAndMotionIsLeftAsItIs) {
  EXPECT_EQ(haptic::scale_motion(seen(2, -2), 352).velocity_x, 0);
  EXPECT_EQ(haptic::scale_motion(seen(0, 3), 352).velocity_y, 0);
  EXPECT_NEAR(haptic::scale_motion(seen(4.5, 0), 352).velocity_x, 3, 1e-9);
  EXPECT_EQ(haptic::scale_motion(seen(6, 0), 352).velocity_x, 6);
  EXPECT_EQ(haptic::scale_motion(seen(20, 0), 352).velocity_x, 20);
}

TEST(MotionScale, TheDeadbandHasNoStep) {
  double before = 0;
  for (double v = 0; v < 10; v += 0.001) {
    const double now = haptic::scale_motion(seen(v, 0), 352).velocity_x;
    ASSERT_GE(now, before);
    ASSERT_LE(now - before, 0.003);
    before = now;
  }
}

TEST(MotionScale, AnImpossibleSpeedIsNotPlausible) {
  EXPECT_TRUE(haptic::is_plausible(seen(5000, -5000, 7680)));
  EXPECT_FALSE(haptic::is_plausible(seen(1e30, 0)));
  EXPECT_FALSE(haptic::is_plausible(seen(std::nan(""), 0)));
}

TEST(MotionScale, ASampleWithoutAPictureIsHarmless) {
  EXPECT_EQ(haptic::scale_motion({}, 352).velocity_x, 0);
}

} // namespace
