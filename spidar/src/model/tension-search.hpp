// SPDX-License-Identifier: LGPL-2.1-or-later
// Finds the tensions within their limits that come nearest to a wrench: box-constrained least
// squares by a primal active set with a warm start. SI units; frame of types.hpp. Real-time safe.
#pragma once

#include "model/string-kinematics.hpp"

namespace spidar {

using ActiveSet = std::array<signed char, kStrings>; ///< -1 at the lower limit, +1 at the upper

/// Minimise |W^1/2 (A t - w)|² + eps |t - t_min|²: half of it is 1/2 t'Ht - g't and a constant,
/// with H = A'WA + eps I and g = A'Ww + eps t_min. A: wrench of each string per newton, torques in
/// units of the grip radius; W: 1 for forces, kTorqueWeight for torques; eps: kTensionWeight.
struct TensionProblem {
  using Matrix8 = Eigen::Matrix<double, kStrings, kStrings>;

  // A torque weighs so much less than a force that the tensions stay continuous where a wrench
  // begins to be out of reach, and so much more than a tension that 1 N alone turns the grip with
  // less than 10 mN·m within 15 mm and 10 degrees.
  static constexpr double kTorqueWeight = 4e-3;
  static constexpr double kTensionWeight = 1e-4;

  WrenchMatrix weighted; ///< W^1/2 A
  double grip_radius;    ///< m
  double lower;          ///< N
  double upper;          ///< N
  Matrix8 hessian;
  Tensions gradient;

  /// `pull` as in StringKinematics. The wrench is that of want().
  TensionProblem(const Geometry &geometry, const WrenchMatrix &pull) noexcept;
  void want(const Wrench &wrench) noexcept;
};

/// Moves the tensions to the optimum, from any tensions within the limits that agree with the
/// active set. Both change the time taken and not the result. Returns the number of iterations.
int find_tensions(const TensionProblem &problem, Tensions &tensions, ActiveSet &active) noexcept;

} // namespace spidar
