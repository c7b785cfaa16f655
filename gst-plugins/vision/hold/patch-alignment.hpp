// SPDX-License-Identifier: LGPL-2.1-or-later
// Finds the pose at which a plane shows a patch: iterated, robust least squares, invariant to gain
// and offset (Baker and Matthews, IJCV 56, 2004).
#pragma once

#include "hold/nearby-luma.hpp"
#include "hold/patch-kernels.hpp"

#include <optional>

namespace haptic {

struct AlignmentOptions {
  int iterations = 5;
  float enough = 0.02F; ///< samples: a step so small ends it
  /// Standard deviation of a change of scale and angle that is expected; 0: translation only.
  float similarity = 0;
};

struct PatchAlignment {
  PatchPose pose;
  float correlation = 0; ///< zero-mean, normalised, -1..1, of the samples of the last iteration
  float error_scale = 0; ///< grey levels, of what fits
  float variance = 0;    ///< px^2, of the place
  float step = 0;        ///< samples, the last one
};

/// Not thread-safe.
class PatchAligner {
public:
  /// Returns the pose near `start`, or nothing if the patch is plain, leaves the plane or has no
  /// solution. Needs the gradients of the patch.
  std::optional<PatchAlignment> align(const LumaLayer &layer, const PatchTemplate &patch,
                                      const PatchSamples &weights, const PatchPose &start,
                                      const AlignmentOptions &options);

private:
  PatchSamples now_;
  PatchSamples errors_;
};

} // namespace haptic
