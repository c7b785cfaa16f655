// SPDX-License-Identifier: LGPL-2.1-or-later
// Computes string tensions (N) for a wrench: box-constrained least squares by a primal active set
// with a warm start. SI units; frame of types.hpp.
#pragma once

#include "spidar/geometry.hpp"

namespace spidar {

class SPIDAR_API TensionSolver {
public:
  explicit TensionSolver(const Geometry &geometry);

  struct Result {
    Tensions tensions;
    Wrench realised;
    bool feasible = true; ///< force met within 10 mN
    int iterations = 0;
  };

  /// Minimises |W^1/2 (A t - w)|² + eps |t - t_min|² within the limits; torque in units of the grip
  /// radius and weighted below force, so that a direction that cannot be had costs torque first.
  /// Real-time safe; remembers the active set of the call before, which changes the time taken and
  /// not the result. A wrench or pose that is not finite gives minimum tensions.
  Result solve(const Wrench &wrench, const Pose &pose) noexcept;

private:
  Geometry geometry_;
  Tensions tensions_;                          ///< of the call before: where the search starts
  std::array<signed char, kStrings> active_{}; ///< -1 at the lower limit, +1 at the upper, 0 free
};

} // namespace spidar
