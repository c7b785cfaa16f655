// SPDX-License-Identifier: LGPL-2.1-or-later
// Computes string tensions (N) for a wrench. SI units; frame of types.hpp.
#pragma once

#include "spidar/geometry.hpp"

namespace spidar {

/// Off the centre eight strings that only pull cannot give every wrench. Then this order decides:
/// a side torque (what a torque has beside any part of the wanted one) within its limit, then the
/// force, then the torque, then low tensions. At the limit of the side torque all strings go
/// towards minimum tension, so that the force keeps its direction but for the pull that minimum
/// tension has there, towards the centre.
class SPIDAR_API TensionSolver {
public:
  static constexpr double kFeasible = 0.005; // N, of the force

  explicit TensionSolver(const Geometry &geometry);

  struct Result {
    Tensions tensions;
    Wrench realised;
    Wrench given_up;      ///< the wrench without what is realised
    bool feasible = true; ///< no more than kFeasible of the force was given up
    int iterations = 0;
  };

  /// Limits the side torque, N·m; 0.02 if it was never called. What minimum tension alone has is no
  /// lower limit than this one. Real-time safe.
  void limit_side_torque(double limit) noexcept;

  /// Real-time safe; remembers the active set of the call before, which changes the time taken and
  /// not the result. A wrench or pose that is not finite gives minimum tensions.
  Result solve(const Wrench &wrench, const Pose &pose) noexcept;

private:
  Geometry geometry_;
  double side_torque_ = 0.02;                  ///< N·m
  Tensions tensions_;                          ///< of the call before: where the search starts
  std::array<signed char, kStrings> active_{}; ///< -1 at the lower limit, +1 at the upper, 0 free
};

} // namespace spidar
