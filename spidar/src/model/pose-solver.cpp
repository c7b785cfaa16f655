// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/pose-solver.hpp"

#include "model/string-kinematics.hpp"

#include <Eigen/Cholesky>

namespace spidar {

namespace {

// A step below this leaves an error of about its square over a string length: under 1 nm.
constexpr double kConverged = 1e-5; // m
// The linearisation holds for a few centimetres; wrong lengths must not move the pose far.
constexpr double kLongestStep = 0.02; // m, rotation counted at the grip radius
constexpr int kMostSteps = 6;
constexpr double kLongestString = 100;  // m
constexpr double kSmallestPivot = 1e-3; // of the largest; 1/30 is usual at the centre

} // namespace

// Minimises |l(p, R) - m|² (l: modelled, m: measured lengths) by Gauss-Newton steps: with the pull
// matrix A (a column per string: direction to the motor, moment / grip radius), dl = -A' x, so that
// A A' x = A (l - m); p += x_1..3, R = Rot(x_4..6 / grip radius) R.
PoseSolver::PoseSolver(const Geometry &geometry) : geometry_(geometry) {}

PoseSolver::Result PoseSolver::solve(const StringLengths &lengths,
                                     const Pose &start) const noexcept {
  Result result{.pose = start, .singular = true};
  if (!lengths.allFinite() || lengths.minCoeff() <= 0 || lengths.maxCoeff() > kLongestString ||
      !start.position.allFinite() || !start.rotation.allFinite())
    return result;

  Pose pose = start;
  StringKinematics strings = string_kinematics(geometry_, pose);
  for (int steps = 0; steps < kMostSteps; ++steps) {
    // In units of the grip radius a turn weighs as much as a shift: the normal matrix is then well
    // conditioned and needs no damping.
    WrenchMatrix scaled = strings.pull;
    scaled.bottomRows<3>() /= geometry_.grip_radius;
    const Eigen::LLT<Matrix6> cholesky(Matrix6(scaled.lazyProduct(scaled.transpose())));
    const auto pivots = cholesky.matrixLLT().diagonal();
    if (cholesky.info() != Eigen::Success ||
        !(pivots.minCoeff() > kSmallestPivot * pivots.maxCoeff()))
      return result;

    Vector6 step = cholesky.solve(scaled * (strings.lengths - lengths));
    const double size = step.norm();
    if (size > kLongestStep)
      step *= kLongestStep / size;
    pose.position += step.head<3>();
    pose.rotation = turned(pose.rotation, step.tail<3>() / geometry_.grip_radius);
    strings = string_kinematics(geometry_, pose);
    if (size < kConverged)
      break;
  }
  if (!pose.position.allFinite() || !pose.rotation.allFinite())
    return result;
  constexpr double kCount = kStrings;
  const StringLengths misfit = lengths - strings.lengths;
  return {pose, std::sqrt(misfit.squaredNorm() / kCount), false, misfit};
}

} // namespace spidar
