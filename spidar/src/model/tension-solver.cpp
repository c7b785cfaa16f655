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

/// The side torque: what a torque has beside any part of the wanted one, which may be given up.
Vector3 side_of(const Vector3 &torque, const Vector3 &wanted) noexcept {
  const double part = torque.dot(wanted) / std::max(wanted.squaredNorm(), 1e-30);
  return torque - std::clamp(part, 0.0, 1.0) * wanted;
}

/// How much of the way from one torque to another keeps the side torque within `limit`: 0..1. The
/// first one does. It grows along the way once it has left the limit, since the torques that have
/// none are a straight line.
double share_within(double limit, const Vector3 &from, const Vector3 &to,
                    const Vector3 &wanted) noexcept {
  constexpr int kHalvings = 40;
  if (side_of(to, wanted).norm() <= limit)
    return 1;
  double within = 0;
  double beyond = 1;
  for (int i = 0; i < kHalvings; ++i) {
    const double share = (within + beyond) / 2;
    (side_of(from + share * (to - from), wanted).norm() <= limit ? within : beyond) = share;
  }
  return within;
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
  int iterations = 0;
  // The force, and as much of the torque as is asked for here.
  const auto give = [&](const Vector3 &torque) {
    problem.want({wrench.force, torque});
    iterations += find_tensions(problem, tensions_, active_);
    const Wrench first = realised_wrench(pull, tensions_);
    const double most_torque = kTorqueAskedAgain * torque.norm();
    problem.want({wrench.force + clamp_norm(wrench.force - first.force, kForceAskedAgain),
                  torque + clamp_norm(torque - first.torque, most_torque)});
    iterations += find_tensions(problem, tensions_, active_);

    // Towards equal tensions force and side torque fade together, and no tension crosses a limit.
    const Vector3 found = realised_wrench(pull, tensions_).torque;
    const Vector3 at_rest = realised_wrench(pull, rest).torque;
    const double limit = std::max(side_torque_, side_of(at_rest, torque).norm());
    const Tensions given = rest + share_within(limit, at_rest, found, torque) * (tensions_ - rest);
    const Wrench realised = realised_wrench(pull, given);
    const Wrench given_up{wrench.force - realised.force, wrench.torque - realised.torque};
    return Result{given, realised, given_up, given_up.force.norm() <= kFeasible, iterations};
  };
  Result result = give(wrench.torque);
  if (!result.feasible && !wrench.torque.isZero()) {
    // Without the torque there may be more of the force.
    const Result alone = give(Vector3::Zero());
    if (alone.given_up.force.norm() < result.given_up.force.norm())
      result = alone;
  }
  return result;
}

} // namespace spidar
