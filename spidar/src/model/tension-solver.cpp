// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/tension-solver.hpp"

#include "model/tension-search.hpp"

namespace spidar {

namespace {

// The search leaves up to a fifteenth of a torque and some millinewtons away, to save tension. Both
// are asked for again, but no more than this: where a wrench is out of reach, asking does not help,
// and would pull the strings against each other.
constexpr double kForceAskedAgain = 0.02; // N
constexpr double kTorqueAskedAgain = 0.2; // of the torque

bool finite(const Wrench &wrench, const Pose &pose) noexcept {
  return wrench.force.allFinite() && wrench.torque.allFinite() && pose.position.allFinite() &&
         pose.rotation.allFinite();
}

Vector3 clamp_norm(const Vector3 &v, double most) noexcept {
  const double norm = v.norm();
  return norm > most ? Vector3(v * (most / norm)) : v;
}

/// How much of the way from one torque to another stays within `limit`: 0..1. The first one does.
double share_within(double limit, const Vector3 &from, const Vector3 &to) noexcept {
  if (to.norm() <= limit)
    return 1;
  // |from + share (to - from)|² = limit²
  const Vector3 way = to - from;
  const double squared = way.squaredNorm();
  const double half = way.dot(from);
  const double room = std::max(limit * limit - from.squaredNorm(), 0.0);
  return std::clamp((std::sqrt(half * half + squared * room) - half) / squared, 0.0, 1.0);
}

} // namespace

TensionSolver::TensionSolver(const Geometry &geometry)
    : geometry_(geometry), tensions_(Tensions::Constant(geometry.tension_min)) {
  active_.fill(-1);
}

void TensionSolver::limit_side_torque(double limit) noexcept {
  side_torque_ = limit > 0 ? limit : 0; // also if it is none
}

TensionSolver::Result TensionSolver::solve(const Wrench &wrench, const Pose &pose) noexcept {
  const Tensions rest = Tensions::Constant(geometry_.tension_min);
  if (!finite(wrench, pose)) {
    tensions_ = rest;
    active_.fill(-1);
    const Pose known = finite({}, pose) ? pose : Pose{};
    return {rest, realised_wrench(string_kinematics(geometry_, known).pull, rest), {}, false, 0};
  }
  const WrenchMatrix pull = string_kinematics(geometry_, pose).pull;
  TensionProblem problem(geometry_, pull);
  problem.want(wrench);
  int iterations = find_tensions(problem, tensions_, active_);
  const Wrench first = realised_wrench(pull, tensions_);
  const double most_torque = kTorqueAskedAgain * wrench.torque.norm();
  problem.want({wrench.force + clamp_norm(wrench.force - first.force, kForceAskedAgain),
                wrench.torque + clamp_norm(wrench.torque - first.torque, most_torque)});
  iterations += find_tensions(problem, tensions_, active_);

  // Towards equal tensions force and side torque fade together, and no tension crosses a limit.
  const Vector3 side = realised_wrench(pull, tensions_).torque - wrench.torque;
  const Vector3 side_at_rest = realised_wrench(pull, rest).torque - wrench.torque;
  const double limit = std::max(side_torque_, side_at_rest.norm());
  const Tensions given = rest + share_within(limit, side_at_rest, side) * (tensions_ - rest);
  const Wrench realised = realised_wrench(pull, given);
  const Wrench given_up{wrench.force - realised.force, wrench.torque - realised.torque};
  return {given, realised, given_up, given_up.force.norm() <= kFeasible, iterations};
}

} // namespace spidar
