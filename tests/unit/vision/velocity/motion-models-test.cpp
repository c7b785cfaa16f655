// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion models in each instruction set against a plain reference in double precision.
#include "velocity/velocity-estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

// The kernels are in headers, and each test uses some of them.
#pragma GCC diagnostic ignored "-Wunused-function"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "vision/velocity/motion-models-test.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "velocity/motion-models-inl.hpp"

#ifndef HAPTIC_MOTION_MODELS_TEST
#define HAPTIC_MOTION_MODELS_TEST
namespace test {

using haptic::MotionModel;
using Parameters = std::array<double, 6>; // x0, y0, xx, xy, yx, yy

struct Point {
  double x = 0, y = 0;                  // px
  double dx = 0, dy = 0;                // px
  double pxx = 100, pxy = 0, pyy = 100; // 1/px²
};

struct Sums {
  std::array<float, 6> xx, xy, yy;
  std::array<float, 3> gx, gy;
};

struct Judgement {
  double cost;
  std::size_t explained;
};

struct Choice {
  MotionModel model;
  Parameters motion;
};

} // namespace test
#endif

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {

Points points_of(const std::vector<test::Point> &from) {
  Points points;
  for (const test::Point &point : from) {
    const std::size_t i = points.count++;
    points.x[i] = static_cast<float>(point.x);
    points.y[i] = static_cast<float>(point.y);
    points.dx[i] = static_cast<float>(point.dx);
    points.dy[i] = static_cast<float>(point.dy);
    points.xx[i] = static_cast<float>(point.pxx);
    points.xy[i] = static_cast<float>(point.pxy);
    points.yy[i] = static_cast<float>(point.pyy);
    points.weight[i] = 1;
  }
  points.step = 2 * std::log(4 * static_cast<float>(points.count));
  points.pad();
  return points;
}

Motion motion_of(const test::Parameters &p) {
  const auto f = [](double value) { return static_cast<float>(value); };
  return {f(p[0]), f(p[1]), f(p[2]), f(p[3]), f(p[4]), f(p[5])};
}

test::Parameters parameters_of(const Motion &m) {
  return {m.x0, m.y0, m.xx, m.xy, m.yx, m.yy};
}

std::vector<float> SquaredErrors(const std::vector<test::Point> &from,
                                 const test::Parameters &motion) {
  const Points points = points_of(from);
  alignas(64) Points::Row errors;
  for (std::size_t i = 0; i < points.count; i += kLanes)
    hn::Store(squared_errors(points, motion_of(motion), i), kTag, errors.data() + i);
  return {errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(points.count)};
}

float Median(const std::vector<float> &values) {
  alignas(64) Points::Row row{};
  std::copy(values.begin(), values.end(), row.begin());
  return median(row, values.size());
}

test::Point Blurred(const test::Point &from, double variance) {
  Points points = points_of({from});
  blur(points, static_cast<float>(variance));
  test::Point point = from;
  point.pxx = static_cast<double>(points.xx[0]);
  point.pxy = static_cast<double>(points.xy[0]);
  point.pyy = static_cast<double>(points.yy[0]);
  return point;
}

test::Sums SumsAt(const std::vector<test::Point> &from, const test::Parameters &motion,
                  float narrowness, float limit) {
  const auto found = sums_at<true>(points_of(from), motion_of(motion), narrowness, limit);
  test::Sums sums;
  std::copy_n(found.xx, 6, sums.xx.begin());
  std::copy_n(found.xy, 6, sums.xy.begin());
  std::copy_n(found.yy, 6, sums.yy.begin());
  std::copy_n(found.gx, 3, sums.gx.begin());
  std::copy_n(found.gy, 3, sums.gy.begin());
  return sums;
}

std::optional<test::Parameters> RobustFit(const std::vector<test::Point> &from, MotionModel model) {
  const Points points = points_of(from);
  const auto motion = robust_fit(model, points, mean_start(points));
  return motion ? std::optional(parameters_of(*motion)) : std::nullopt;
}

test::Judgement Judge(const std::vector<test::Point> &from, MotionModel model,
                      const test::Parameters &motion) {
  const Fit fit = judged(model, motion_of(motion), points_of(from));
  return {static_cast<double>(fit.cost), fit.explained};
}

test::Choice Select(const std::vector<test::Point> &from) {
  const Selection found = select_model(points_of(from), MotionModel::still, {});
  return {found.fit.model, parameters_of(found.fit.motion)};
}

test::Parameters Commonest(const std::vector<test::Point> &from) {
  return parameters_of(commonest_translation(points_of(from)).motion);
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {
namespace {

HWY_EXPORT(SquaredErrors);
HWY_EXPORT(Median);
HWY_EXPORT(Blurred);
HWY_EXPORT(SumsAt);
HWY_EXPORT(RobustFit);
HWY_EXPORT(Judge);
HWY_EXPORT(Select);
HWY_EXPORT(Commonest);

using test::Parameters;
using test::Point;

constexpr Parameters kShift = {1.5, -0.75, 0, 0, 0, 0};
constexpr Parameters kTurn = {0.5, 1, 0.03, -0.06, 0.06, 0.03}; // grows by 3 %, turns by 0.06 rad
constexpr Parameters kShear = {-0.5, 0.25, 0.05, 0.04, -0.02, -0.03};

struct Truth {
  MotionModel model;
  Parameters motion;
};
constexpr std::array kTruths = {Truth{MotionModel::translation, kShift},
                                Truth{MotionModel::similarity, kTurn},
                                Truth{MotionModel::affine, kShear}};

void move(Point &point, const Parameters &m) {
  point.dx = m[0] + m[2] * point.x + m[3] * point.y;
  point.dy = m[1] + m[4] * point.x + m[5] * point.y;
}

double squared_error(const Point &p, const Parameters &m) {
  Point moved = p;
  move(moved, m);
  const double ex = p.dx - moved.dx;
  const double ey = p.dy - moved.dy;
  return p.pxx * ex * ex + 2 * p.pxy * ex * ey + p.pyy * ey * ey;
}

// Each test runs in each instruction set that this machine has.
class MotionModels : public ::testing::TestWithParam<std::int64_t> {
protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  double uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  }

  std::vector<Point> points(int count, const Parameters &motion, double noise = 0) {
    std::vector<Point> points(static_cast<std::size_t>(count));
    std::normal_distribution<double> error(0, noise > 0 ? noise : 1);
    for (Point &point : points) {
      point.x = uniform(-15, 15);
      point.y = uniform(-15, 15);
      move(point, motion);
      if (noise > 0) {
        point.dx += error(random);
        point.dy += error(random);
        // Correlated, and positive definite.
        point.pxx = uniform(20, 150);
        point.pyy = uniform(20, 150);
        point.pxy = uniform(-15, 15);
      }
    }
    return points;
  }

  std::mt19937 random{5};
};

void expect_motion(const Parameters &found, const Parameters &truth, double shift,
                   double gradient) {
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_NEAR(found[i], truth[i], i < 2 ? shift : gradient) << "parameter " << i;
}

TEST_P(MotionModels, SquaredErrorsAreThoseOfThePlainFormula) {
  for (const int count : {1, 3, 8, 17, 64}) {
    const auto some = points(count, kShear, 0.2);
    const auto found = HWY_DYNAMIC_DISPATCH(SquaredErrors)(some, kTurn);
    for (std::size_t i = 0; i < some.size(); ++i) {
      const double truth = squared_error(some[i], kTurn);
      EXPECT_NEAR(found[i], truth, 1e-4 * truth + 1e-3) << i << " of " << count;
    }
  }
}

TEST_P(MotionModels, TheMedianIsTheUpperMiddleOfTheSortedValues) {
  for (std::size_t count = 1; count <= 64; ++count) {
    std::vector<float> values(count);
    for (float &value : values)
      value = static_cast<float>(std::floor(uniform(0, 20))); // with values that repeat
    const float found = HWY_DYNAMIC_DISPATCH(Median)(values);
    std::sort(values.begin(), values.end());
    EXPECT_EQ(found, values[count / 2]) << count;
  }
}

TEST_P(MotionModels, AddedNoiseLowersThePrecisionAsTheInverseCovarianceGrows) {
  const Point point{.pxx = 100, .pxy = 30, .pyy = 50};
  constexpr double kVariance = 0.04;
  const double det = 100 * 50 - 30 * 30;
  const double cxx = 50 / det + kVariance;
  const double cxy = -30 / det;
  const double cyy = 100 / det + kVariance;
  const double inverse = 1 / (cxx * cyy - cxy * cxy);
  const Point found = HWY_DYNAMIC_DISPATCH(Blurred)(point, kVariance);
  EXPECT_NEAR(found.pxx, cyy * inverse, 1e-4);
  EXPECT_NEAR(found.pxy, -cxy * inverse, 1e-4);
  EXPECT_NEAR(found.pyy, cxx * inverse, 1e-4);
}

TEST_P(MotionModels, AddedNoiseLeavesADirectionWithoutPrecisionAsItIs) {
  const Point found = HWY_DYNAMIC_DISPATCH(Blurred)({.pxx = 100, .pxy = 0, .pyy = 0}, 0.04);
  EXPECT_NEAR(found.pxx, 1 / (0.01 + 0.04), 1e-4);
  EXPECT_EQ(found.pxy, 0);
  EXPECT_EQ(found.pyy, 0);
}

TEST_P(MotionModels, SumsOfTheNormalEquationsAreThoseOfThePlainFormula) {
  constexpr double kNarrowness = 1.0 / 36;
  constexpr double kLimit = 60;
  for (const int count : {1, 5, 16, 33, 64}) {
    const auto some = points(count, kTurn, 0.3);
    std::array<double, 6> xx{}, xy{}, yy{};
    std::array<double, 3> gx{}, gy{};
    double size = 1;
    for (const Point &p : some) {
      const double e2 = squared_error(p, kShift);
      if (e2 >= kLimit)
        continue;
      const double w = 1 / ((1 + kNarrowness * e2) * (1 + kNarrowness * e2));
      const double ex = p.dx - kShift[0];
      const double ey = p.dy - kShift[1];
      const std::array<double, 6> products = {1, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y};
      for (std::size_t k = 0; k < 6; ++k) {
        xx[k] += w * p.pxx * products[k];
        xy[k] += w * p.pxy * products[k];
        yy[k] += w * p.pyy * products[k];
      }
      for (std::size_t k = 0; k < 3; ++k) {
        gx[k] += w * (p.pxx * ex + p.pxy * ey) * products[k];
        gy[k] += w * (p.pxy * ex + p.pyy * ey) * products[k];
      }
      size += w * 150 * 225;
    }
    const auto found = HWY_DYNAMIC_DISPATCH(SumsAt)(some, kShift, static_cast<float>(kNarrowness),
                                                    static_cast<float>(kLimit));
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(found.xx[k], xx[k], 1e-5 * size) << count << " points, sum " << k;
      EXPECT_NEAR(found.xy[k], xy[k], 1e-5 * size) << count << " points, sum " << k;
      EXPECT_NEAR(found.yy[k], yy[k], 1e-5 * size) << count << " points, sum " << k;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(found.gx[k], gx[k], 1e-5 * size) << count << " points, sum " << k;
      EXPECT_NEAR(found.gy[k], gy[k], 1e-5 * size) << count << " points, sum " << k;
    }
  }
}

TEST_P(MotionModels, EachModelRecoversItsMotionExactly) {
  for (const Truth &truth : kTruths)
    for (const int count : {4, 9, 20, 64}) {
      SCOPED_TRACE(count);
      const auto found = HWY_DYNAMIC_DISPATCH(RobustFit)(points(count, truth.motion), truth.model);
      ASSERT_TRUE(found.has_value());
      expect_motion(*found, truth.motion, 1e-3, 1e-4);
    }
}

TEST_P(MotionModels, FalseMatchesDoNotChangeTheFit) {
  for (const Truth &truth : kTruths) {
    auto some = points(40, truth.motion);
    for (std::size_t i = 0; i < some.size(); i += 4) {
      some[i].dx += uniform(3, 8);
      some[i].dy -= uniform(3, 8);
    }
    const auto found = HWY_DYNAMIC_DISPATCH(RobustFit)(some, truth.model);
    ASSERT_TRUE(found.has_value());
    expect_motion(*found, truth.motion, 1e-3, 1e-4);
  }
}

TEST_P(MotionModels, PointsThatDoNotDetermineAModelGiveNone) {
  const auto fit = [&](const std::vector<Point> &some, MotionModel model) {
    return HWY_DYNAMIC_DISPATCH(RobustFit)(some, model);
  };
  auto together = points(10, kShift); // at one place
  for (Point &point : together)
    point.x = point.y = 3;
  EXPECT_TRUE(fit(together, MotionModel::translation).has_value());
  EXPECT_FALSE(fit(together, MotionModel::similarity).has_value());
  EXPECT_FALSE(fit(together, MotionModel::affine).has_value());

  auto line = points(10, kShift); // a line determines a similarity
  for (Point &point : line)
    point.y = 0.5 * point.x;
  EXPECT_TRUE(fit(line, MotionModel::similarity).has_value());
  EXPECT_FALSE(fit(line, MotionModel::affine).has_value());

  auto unknown = points(10, kShift);
  for (Point &point : unknown)
    point.pxx = point.pyy = 0;
  for (const auto model : {MotionModel::translation, MotionModel::similarity, MotionModel::affine})
    EXPECT_FALSE(fit(unknown, model).has_value());
}

TEST_P(MotionModels, ADirectionWithoutPrecisionKeepsItsStart) {
  auto some = points(20, kShift);
  for (Point &point : some)
    point.pyy = 0; // vertical edges
  const auto found = HWY_DYNAMIC_DISPATCH(RobustFit)(some, MotionModel::translation);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR((*found)[0], kShift[0], 1e-3);
  EXPECT_NEAR((*found)[1], 0, 1e-3);
}

// Sum of min(e' P e, 9.21) + k ln 4n, and at least 2 ln 200 for two parameters.
TEST_P(MotionModels, TheCostIsTheCriterionOfTorr) {
  constexpr double kLimit = 9.21;
  for (const int count : {3, 20, 64}) {
    const auto some = points(count, kShear, 0.15);
    const double step = 2 * std::log(4.0 * count);
    for (const auto &[model, parameters] :
         {std::pair(MotionModel::still, 0), std::pair(MotionModel::translation, 2),
          std::pair(MotionModel::similarity, 4), std::pair(MotionModel::affine, 6)}) {
      double cost = parameters == 0 ? 0 : std::max(step, 10.6) + step * (parameters / 2 - 1);
      std::size_t explained = 0;
      for (const Point &point : some) {
        const double error = squared_error(point, kShear);
        cost += std::min(error, kLimit);
        explained += error < kLimit;
      }
      const auto found = HWY_DYNAMIC_DISPATCH(Judge)(some, model, kShear);
      EXPECT_NEAR(found.cost, cost, 1e-3 * cost);
      EXPECT_EQ(found.explained, explained);
    }
  }
}

TEST_P(MotionModels, TheSmallestModelThatExplainsThePointsIsChosen) {
  const auto still = HWY_DYNAMIC_DISPATCH(Select)(points(20, {}));
  EXPECT_EQ(still.model, MotionModel::still);
  for (const Truth &truth : kTruths) {
    const auto found = HWY_DYNAMIC_DISPATCH(Select)(points(30, truth.motion));
    EXPECT_EQ(found.model, truth.model);
    expect_motion(found.motion, truth.motion, 1e-3, 1e-4);
  }
}

TEST_P(MotionModels, TheCommonestTranslationIsThatOfTheLargestGroup) {
  auto some = points(12, kShift);
  const auto others = points(8, {-4, 3, 0, 0, 0, 0});
  some.insert(some.end(), others.begin(), others.end());
  expect_motion(HWY_DYNAMIC_DISPATCH(Commonest)(some), kShift, 1e-3, 0);
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, MotionModels,
                         ::testing::ValuesIn(hwy::SupportedAndGeneratedTargets()),
                         [](const auto &target) {
                           return std::string(hwy::TargetName(target.param));
                         });

} // namespace
} // namespace haptic
#endif
