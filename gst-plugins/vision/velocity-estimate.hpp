// From the patches of one picture to one velocity (paper, equations 2 and 3).
#pragma once

#include "haptic-patch.h"
#include "motion-sample.hpp"

#include <span>

namespace haptic {

/// How the velocities of the patches become one.
enum class Average {
  model,  ///< a motion model fitted to the patches, evaluated at the pointer
  mean,   ///< equation 3 as printed
  median, ///< of each component
};

/// Which motion model `Average::model` fits; `still` says that nothing moves, whatever the patches.
enum class ModelChoice { automatic, still, translation, similarity, affine };

struct PatchSet {
  std::span<const GstHapticPatch> patches; ///< those that could be trusted
  int candidates = 0;                      ///< how many were looked at
  float pointer_x = 0;                     ///< px
  float pointer_y = 0;                     ///< px
  double interval = 0;                     ///< s between the two pictures, > 0
};

struct VelocityEstimate {
  float velocity_x = 0; ///< px/s
  float velocity_y = 0; ///< px/s, y down
  float spin = 0;       ///< rad/s, positive turns x towards y
  float divergence = 0; ///< 1/s, mean relative rate of expansion
  float confidence = 0; ///< 0..1; 0: nothing was measured, and all else is 0
  int points = 0;       ///< patches that agree with the velocity
  MotionModel model = MotionModel::none;
};

/// `automatic` is a translation for now. A model that the patches cannot determine (too few, or on
/// one line) gives way to the next smaller one; `model` of the result tells. Never returns a number
/// that is not finite. Pure.
VelocityEstimate estimate_velocity(const PatchSet &set, Average average, ModelChoice choice);

} // namespace haptic
