// SPDX-License-Identifier: LGPL-2.1-or-later
// Pose of the grip from eight string lengths: Gauss-Newton, rotation scaled by the grip radius.
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
  };

  /// `start` is the pose of the tick before. Real-time safe.
  Result solve(const StringLengths &lengths, const Pose &start) const noexcept;

private:
  Geometry geometry_;
};

} // namespace spidar
