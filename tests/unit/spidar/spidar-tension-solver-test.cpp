// SPDX-License-Identifier: LGPL-2.1-or-later
#include "model/tension-search.hpp"
#include "spidar-poses.hpp"
#include "spidar/tension-solver.hpp"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>
#include <limits>

namespace spidar_tension_solver_test {

using namespace spidar;
using namespace spidar_test;

using Matrix8 = Eigen::Matrix<double, 8, 8>;

/// The problem as written in the header, built independently of the solver.
struct Problem {
  Matrix8 hessian;
  Tensions linear;

  Problem(const Geometry &geometry, const Wrench &wrench, const Pose &pose) {
    constexpr double kTorqueWeight = 4e-3;
    constexpr double kTensionWeight = 1e-4;
    Eigen::Matrix<double, 6, 8> pull;
    for (std::size_t i = 0; i < kStrings; ++i) {
      const Vector3 arm = pose.rotation * geometry.attachments[i];
      const Vector3 direction = (geometry.motors[i] - pose.position - arm).normalized();
      pull.col(i) << direction, arm.cross(direction) / geometry.grip_radius;
    }
    Eigen::Matrix<double, 6, 1> weights;
    weights << 1, 1, 1, kTorqueWeight, kTorqueWeight, kTorqueWeight;
    Eigen::Matrix<double, 6, 1> wanted;
    wanted << wrench.force, wrench.torque / geometry.grip_radius;
    hessian = pull.transpose() * weights.asDiagonal() * pull + kTensionWeight * Matrix8::Identity();
    linear = pull.transpose() * weights.asDiagonal() * wanted +
             kTensionWeight * Tensions::Constant(geometry.tension_min);
  }

  double cost(const Tensions &tensions) const {
    return 0.5 * tensions.dot(hessian * tensions) - linear.dot(tensions);
  }

  /// Zero exactly at the optimum: how far a step down the slope leads, kept within the limits.
  double kkt_residual(const Tensions &tensions, double lower, double upper) const {
    const Tensions step = tensions - (hessian * tensions - linear);
    return (step.cwiseMax(lower).cwiseMin(upper) - tensions).cwiseAbs().maxCoeff();
  }

  /// The best of all 3^8 ways to keep each string at a limit or free.
  Tensions brute_force(double lower, double upper) const {
    Tensions best = Tensions::Constant(lower);
    double lowest = std::numeric_limits<double>::infinity();
    for (int code = 0; code < 6561; ++code) {
      Tensions tensions;
      std::array<int, 8> free{};
      int count = 0;
      for (int i = 0, rest = code; i < 8; ++i, rest /= 3) {
        tensions[i] = rest % 3 == 0 ? lower : upper;
        if (rest % 3 == 2) {
          tensions[i] = 0;
          free[static_cast<std::size_t>(count++)] = i;
        }
      }
      if (count > 0) {
        Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 8, 8> block(count, count);
        Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 8, 1> right(count);
        for (int row = 0; row < count; ++row) {
          const int i = free[static_cast<std::size_t>(row)];
          right[row] = linear[i] - hessian.row(i).dot(tensions);
          for (int column = 0; column < count; ++column)
            block(row, column) = hessian(i, free[static_cast<std::size_t>(column)]);
        }
        right = block.llt().solve(right).eval();
        if (right.minCoeff() < lower || right.maxCoeff() > upper)
          continue;
        for (int row = 0; row < count; ++row)
          tensions[free[static_cast<std::size_t>(row)]] = right[row];
      }
      if (cost(tensions) < lowest) {
        lowest = cost(tensions);
        best = tensions;
      }
    }
    return best;
  }
};

Wrench random_wrench(Random &random, double force, double torque) {
  return {random.between(0, force) * random.direction(),
          random.between(0, torque) * random.direction()};
}

/// Of tensions, from those before.
struct Search {
  explicit Search(const Geometry &of) : geometry(of), tensions(Tensions::Constant(of.tension_min)) {
    active.fill(-1);
  }
  int find(const Wrench &wrench, const Pose &pose) {
    TensionProblem problem(geometry, string_kinematics(geometry, pose).pull);
    problem.want(wrench);
    return find_tensions(problem, tensions, active);
  }

  Geometry geometry;
  Tensions tensions;
  ActiveSet active{};
};

bool within_limits(const Tensions &tensions, const Geometry &geometry) {
  return tensions.minCoeff() >= geometry.tension_min && tensions.maxCoeff() <= geometry.tension_max;
}

class TensionSolverOf : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Builtin, TensionSolverOf, testing::ValuesIn(builtin_geometries()),
                         [](const auto &test) {
                           return test.param.substr(test.param.find('-') + 1);
                         });

constexpr double kSideTorque = 0.02; // N·m, unless something else was wanted

Wrench at_minimum_tension(const Geometry &geometry, const Pose &pose) {
  return realised_wrench(string_kinematics(geometry, pose).pull,
                         Tensions::Constant(geometry.tension_min));
}

TEST_P(TensionSolverOf, Within15MillimetresAForceOf1NewtonIsExactAndHardlyTurnsTheGrip) {
  const Geometry geometry = load_geometry(GetParam());
  TensionSolver solver(geometry);
  Random random(1);
  double worst = 0;
  double side = 0;
  for (int i = 0; i < 20000; ++i) {
    const Pose pose{random.between(0, 0.015) * random.direction(),
                    turn(random.direction(), random.between(0, 10 * kDegree))};
    const Wrench wrench{random.direction(), Vector3::Zero()};
    const TensionSolver::Result result = solver.solve(wrench, pose);
    ASSERT_TRUE(result.feasible);
    worst = std::max(worst, (result.realised.force - wrench.force).norm());
    side = std::max(side, result.realised.torque.norm());
  }
  EXPECT_LE(worst, 0.005);
  EXPECT_LE(side, 0.010);
  RecordProperty("worst_force_error_mN", std::to_string(1000 * worst));
  RecordProperty("worst_side_torque_mNm", std::to_string(1000 * side));
}

TEST_P(TensionSolverOf, InTheWholeWorkspaceTheSideTorqueHasALimitAndWhatIsBelowItIsExact) {
  const Geometry geometry = load_geometry(GetParam());
  TensionSolver solver(geometry);
  Random random(1);
  int reduced = 0;
  for (int i = 0; i < 20000; ++i) {
    Pose pose = random.pose(0.025, 20 * kDegree);
    const Wrench wrench{random.between(0, 1) * random.direction(), Vector3::Zero()};
    const bool corner = i % 2 == 0; // the hardest, tilted as far as it goes
    if (corner)
      pose = {0.025 * pose.position.cwiseSign(), turn(random.direction(), 20 * kDegree)};
    const TensionSolver::Result result = solver.solve(wrench, pose);
    ASSERT_TRUE(within_limits(result.tensions, geometry));
    const double side = result.realised.torque.norm();
    ASSERT_LE(side, kSideTorque * (1 + 1e-9));
    const double missing = (result.realised.force - wrench.force).norm();
    ASSERT_TRUE(missing <= 0.005 || side >= kSideTorque * (1 - 1e-9)) << missing;
    ASSERT_EQ(result.feasible, missing <= 0.005);
    ASSERT_LE((result.given_up.force - (wrench.force - result.realised.force)).norm(), 1e-12);
    ASSERT_LE((result.given_up.torque + result.realised.torque).norm(), 1e-12);
    reduced += !corner && !result.feasible;
  }
  EXPECT_LE(reduced, 0.06 * 10000);
  RecordProperty("places_reduced_percent", std::to_string(reduced / 100.0));
}

TEST_P(TensionSolverOf, AReducedForceKeepsItsDirectionButForThePullOfMinimumTension) {
  const Geometry geometry = load_geometry(GetParam());
  Random random(5);
  for (const double limit : {0.0, 0.005, 0.01, 0.02}) {
    TensionSolver solver(geometry);
    solver.limit_side_torque(limit);
    int reduced = 0;
    for (int i = 0; i < 5000; ++i) {
      const Pose pose = random.pose(0.025, 20 * kDegree);
      const Wrench wrench{random.direction(), Vector3::Zero()};
      const TensionSolver::Result result = solver.solve(wrench, pose);
      const Wrench rest = at_minimum_tension(geometry, pose);
      const double most = std::max(limit, rest.torque.norm());
      ASSERT_LE(result.realised.torque.norm(), most + 1e-9);
      if (result.realised.torque.norm() < most - 1e-9)
        continue;
      const Vector3 way = wrench.force - rest.force;
      const Vector3 gone = result.realised.force - rest.force;
      const double share = gone.dot(way) / way.squaredNorm();
      ASSERT_GE(share, -1e-12);
      ASSERT_LE(share, 1);
      ASSERT_LE((gone - share * way).norm(), 0.005);
      ++reduced;
    }
    EXPECT_GT(reduced, 0) << limit;
  }
}

TEST_P(TensionSolverOf, FindsTheOptimumWithinTheLimitsWhateverIsAsked) {
  const Geometry geometry = load_geometry(GetParam());
  Search search(geometry);
  Random random(2);
  double worst = 0;
  int most_iterations = 0;
  for (int i = 0; i < 10000; ++i) {
    const Pose pose = random.pose(0.04, 45 * kDegree);
    const Wrench wrench = i % 2 == 0 ? random_wrench(random, 1, 0) : random_wrench(random, 20, 0.3);
    most_iterations = std::max(most_iterations, search.find(wrench, pose));
    ASSERT_TRUE(within_limits(search.tensions, geometry));
    worst = std::max(
        worst, Problem(geometry, wrench, pose)
                   .kkt_residual(search.tensions, geometry.tension_min, geometry.tension_max));
  }
  EXPECT_LE(worst, 1e-9);
  EXPECT_LT(most_iterations, 40);
  RecordProperty("most_iterations", most_iterations);
}

TEST(TensionSolver, AgreesWithBruteForceOverAllActiveSets) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Search search(geometry);
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Pose pose = random.pose(0.03, 30 * kDegree);
    const double force = i % 3 == 0 ? 1 : i % 3 == 1 ? 3 : 20;
    const Wrench wrench = random_wrench(random, force, i % 2 == 0 ? 0 : 0.05);
    const Problem problem(geometry, wrench, pose);
    const Tensions best = problem.brute_force(geometry.tension_min, geometry.tension_max);
    search.find(wrench, pose);
    ASSERT_LT((search.tensions - best).cwiseAbs().maxCoeff(), 1e-7) << "case " << i;
  }
}

TEST(TensionSolver, TheCallsBeforeDoNotChangeTheResult) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  TensionSolver warm(geometry);
  Random random(4);
  for (int i = 0; i < 2000; ++i) {
    const Pose pose = random.pose(0.03, 30 * kDegree);
    const Wrench wrench = random_wrench(random, 5, 0.05);
    TensionSolver cold(geometry);
    const Tensions difference =
        warm.solve(wrench, pose).tensions - cold.solve(wrench, pose).tensions;
    ASSERT_LT(difference.cwiseAbs().maxCoeff(), 1e-9);
  }
}

// A hand that wanders through the workspace and tilts, while the force turns and swells.
TEST_P(TensionSolverOf, TensionsChangeSmoothlyAlongASmoothMovement) {
  const Geometry geometry = load_geometry(GetParam());
  TensionSolver solver(geometry);
  Tensions before = Tensions::Zero();
  double largest = 0;
  for (int tick = 0; tick < 60000; ++tick) {
    const double t = 0.001 * tick;
    const Pose pose{0.025 *
                        Vector3(std::sin(2.1 * t), std::sin(1.7 * t + 1), std::sin(1.3 * t + 2)),
                    turn({std::sin(0.9 * t), std::cos(0.7 * t), std::sin(0.5 * t + 1)},
                         20 * kDegree * std::sin(1.1 * t))};
    const double size = 0.5 + 0.5 * std::sin(5 * t);
    const Wrench wrench{
        size * Vector3(std::cos(7 * t), std::sin(7 * t), 0.3 * std::sin(3 * t)).normalized(),
        Vector3::Zero()};
    const TensionSolver::Result result = solver.solve(wrench, pose);
    if (tick > 0)
      largest = std::max(largest, (result.tensions - before).cwiseAbs().maxCoeff());
    before = result.tensions;
  }
  EXPECT_LE(largest, 0.1);
  RecordProperty("largest_step_N", std::to_string(largest));
}

TEST_P(TensionSolverOf, ATorqueIsGivenAtTheCentre) {
  const Geometry geometry = load_geometry(GetParam());
  TensionSolver solver(geometry);
  for (int axis = 0; axis < 6; ++axis) {
    Wrench wrench;
    wrench.torque[axis / 2] = axis % 2 == 0 ? 0.02 : -0.02;
    const TensionSolver::Result result = solver.solve(wrench, {});
    EXPECT_LE(result.realised.force.norm(), 0.005) << axis;
    EXPECT_GE(wrench.torque.dot(result.realised.torque) / 0.02, 0.0198) << axis;
    EXPECT_LE(result.given_up.torque.norm(), 0.0002) << axis;
  }
}

// As the brake of a grip that seems to turn, where the strings cannot turn it.
TEST_P(TensionSolverOf, ATorqueThatIsOutOfReachTakesHardlyAnyForce) {
  const Geometry geometry = load_geometry(GetParam());
  TensionSolver solver(geometry);
  Random random(6);
  double most = 0;
  int out_of_reach = 0;
  for (int i = 0; i < 20000; ++i) {
    const Pose pose = random.pose(i % 2 == 0 ? 0.025 : 0.06, 20 * kDegree);
    const Vector3 force = random.between(0, 2) * random.direction();
    const Vector3 torque = random.between(0, 0.02) * random.direction();
    const TensionSolver::Result alone = solver.solve({force, Vector3::Zero()}, pose);
    const TensionSolver::Result result = solver.solve({force, torque}, pose);
    most = std::max(most, result.given_up.force.norm() - alone.given_up.force.norm());
    out_of_reach += result.given_up.torque.norm() > 0.01;
  }
  EXPECT_LE(most, 0.01);
  EXPECT_GT(out_of_reach, 100);
  RecordProperty("most_force_taken_mN", std::to_string(1000 * most));
}

TEST(TensionSolver, AWrenchThatIsNoneGivesMinimumTensions) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  TensionSolver solver(geometry);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  Pose broken;
  broken.position.x() = nan;
  const std::vector<std::pair<Wrench, Pose>> cases = {{{{nan, 0, 0}, {0, 0, 0}}, {}},
                                                      {{{0, 0, 0}, {0, infinity, 0}}, {}},
                                                      {{{1, 0, 0}, {0, 0, 0}}, broken}};
  for (const auto &[wrench, pose] : cases) {
    solver.solve({{0, 3, 0}, {0, 0, 0}}, {});
    const TensionSolver::Result result = solver.solve(wrench, pose);
    EXPECT_EQ(result.tensions, Tensions::Constant(geometry.tension_min));
    EXPECT_FALSE(result.feasible);
    EXPECT_TRUE(result.realised.force.allFinite());
  }
}

TEST(TensionSolver, AnAbsurdWrenchStaysWithinTheLimitsAndSaysSo) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  TensionSolver solver(geometry);
  for (const double size : {30.0, 1e6, 1e30, 1e300}) {
    const TensionSolver::Result result = solver.solve({{size, 0, 0}, {0, 0, -size}}, {});
    EXPECT_TRUE(within_limits(result.tensions, geometry)) << size;
    EXPECT_FALSE(result.feasible) << size;
    EXPECT_LT(result.iterations, 40) << size;
    EXPECT_GT(result.realised.force.x(), 0) << size;
  }
}

} // namespace spidar_tension_solver_test
