// SPDX-License-Identifier: LGPL-2.1-or-later
// Computes the pose of the grip from eight string lengths: Gauss-Newton on the differences between
// measured and modelled lengths, rotation in units of the grip radius. SI units; frame of
// types.hpp.
#pragma once

#include "spidar/geometry.hpp"

namespace spidar {

class SPIDAR_API PoseSolver {
public:
  explicit PoseSolver(const Geometry &geometry);

  struct Result {
    Pose pose;
    double residual = 0;   ///< m, rms difference between measured and modelled lengths
    bool singular = false; ///< the strings do not determine the pose; it was kept
    StringLengths misfit = StringLengths::Zero(); ///< m, measured minus modelled
  };

  /// `lengths` in m; `start` is the pose of the tick before. Real-time safe.
  Result solve(const StringLengths &lengths, const Pose &start) const noexcept;

private:
  Geometry geometry_;
};

} // namespace spidar
