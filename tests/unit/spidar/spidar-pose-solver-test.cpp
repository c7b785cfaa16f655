// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar-poses.hpp"
#include "spidar/pose-solver.hpp"

#include <gtest/gtest.h>
#include <limits>

namespace spidar_pose_solver_test {

using namespace spidar;
using namespace spidar_test;

struct Deviation {
  double position = 0; ///< m
  double angle = 0;    ///< rad

  void widen(const Pose &truth, const Pose &found) {
    position = std::max(position, (truth.position - found.position).norm());
    angle = std::max(angle, angle_between(truth.rotation, found.rotation));
  }
};

class PoseSolverOf : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Builtin, PoseSolverOf, testing::ValuesIn(builtin_geometries()),
                         [](const auto &test) {
                           return test.param.substr(test.param.find('-') + 1);
                         });

TEST_P(PoseSolverOf, FollowsAStepOf20DegreesAnd14MillimetresInTwoTicks) {
  const Geometry geometry = load_geometry(GetParam());
  const PoseSolver solver(geometry);
  Deviation worst;
  for (const Vector3 &shift : directions(40)) {
    for (const Vector3 &axis : directions(40)) {
      const Pose truth{0.014 * shift, turn(axis, 20 * kDegree)};
      const StringLengths lengths = string_lengths(geometry, truth);
      const PoseSolver::Result first = solver.solve(lengths, {});
      const PoseSolver::Result second = solver.solve(lengths, first.pose);
      ASSERT_FALSE(second.singular);
      worst.widen(truth, second.pose);
    }
  }
  EXPECT_LT(worst.position, 0.05e-3);
  EXPECT_LT(worst.angle, 0.1 * kDegree);
}

TEST_P(PoseSolverOf, FindsAnyPoseOfTheWorkspaceFromTheOneBefore) {
  const Geometry geometry = load_geometry(GetParam());
  const PoseSolver solver(geometry);
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Pose before = random.pose(0.025, 20 * kDegree);
    Pose truth = before;
    truth.position += random.in_box(0.002);
    truth.rotation = turn(random.direction(), 5 * kDegree) * truth.rotation;
    const PoseSolver::Result result = solver.solve(string_lengths(geometry, truth), before);
    ASSERT_FALSE(result.singular);
    EXPECT_LT((result.pose.position - truth.position).norm(), 1e-8);
    EXPECT_LT(angle_between(result.pose.rotation, truth.rotation), 1e-6);
    EXPECT_LT(result.residual, 1e-8);
  }
}

TEST(PoseSolver, OneCountOfQuantisationMovesThePoseByLessThanItsLength) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  const PoseSolver solver(geometry);
  Random random(2);
  Deviation worst;
  for (int i = 0; i < 2000; ++i) {
    const Pose truth = random.pose(0.025, 20 * kDegree);
    StringLengths lengths = string_lengths(geometry, truth);
    for (std::size_t k = 0; k < kStrings; ++k)
      lengths[k] =
          geometry.metres_per_count[k] * std::round(lengths[k] / geometry.metres_per_count[k]);
    worst.widen(truth, solver.solve(lengths, truth).pose);
  }
  EXPECT_LT(worst.position, 17e-6);
  EXPECT_LT(worst.angle, 0.1 * kDegree);
}

TEST(PoseSolver, TheOrientationStaysARotationHoweverOftenItTurns) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  const PoseSolver solver(geometry);
  Pose pose;
  for (int i = 0; i < 100000; ++i) {
    const double angle = 0.3 * std::sin(i * 0.01);
    const Pose truth{Vector3::Zero(), turn({std::cos(i * 0.001), std::sin(i * 0.001), 0.3}, angle)};
    pose = solver.solve(string_lengths(geometry, truth), pose).pose;
  }
  const Matrix3 identity = pose.rotation.transpose() * pose.rotation;
  EXPECT_LT((identity - Matrix3::Identity()).norm(), 1e-12);
  EXPECT_GT(pose.rotation.determinant(), 0.999);
}

TEST(PoseSolver, LengthsThatAreNoneKeepThePose) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  const PoseSolver solver(geometry);
  const Pose start{{0.001, 0.002, 0.003}, turn({1, 1, 0}, 0.1)};
  const double garbage[] = {std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity(), -0.1, 0, 1e30};
  for (const double value : garbage) {
    StringLengths lengths = string_lengths(geometry, start);
    lengths[3] = value;
    const PoseSolver::Result result = solver.solve(lengths, start);
    EXPECT_TRUE(result.singular) << value;
    EXPECT_EQ(result.pose.position, start.position) << value;
    EXPECT_EQ(result.pose.rotation, start.rotation) << value;
  }
}

TEST(PoseSolver, AnyLengthsGiveAFinitePoseAndABadFitIsVisible) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  const PoseSolver solver(geometry);
  Random random(3);
  Pose pose;
  for (int i = 0; i < 20000; ++i) {
    StringLengths lengths;
    for (std::size_t k = 0; k < kStrings; ++k)
      lengths[k] = std::pow(10.0, random.between(-6, 3));
    const PoseSolver::Result result = solver.solve(lengths, pose);
    ASSERT_TRUE(result.pose.position.allFinite() && result.pose.rotation.allFinite());
    ASSERT_TRUE(result.singular || result.residual > 0.005);
    pose = result.pose;
  }
}

} // namespace spidar_pose_solver_test
