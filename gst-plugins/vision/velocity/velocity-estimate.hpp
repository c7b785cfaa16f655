// SPDX-License-Identifier: LGPL-2.1-or-later
// From the patches of one frame to one velocity (paper, equations 2 and 3).
#pragma once

#include "haptic-patch.h"
#include "samples/motion-sample.hpp"

#include <span>

namespace haptic {

/// How the velocities of the patches become one.
enum class Average {
  model,   ///< a motion model fitted to the patches, evaluated at the pointer
  pointed, ///< the same of the patches that show what the pointer points at
  mean,    ///< equation 3 as printed
  median,  ///< of each component
};
/// Nearer to the motion of the thing under the pointer than the others (docs/lab.md).
inline constexpr Average kUsualAverage = Average::pointed;

/// The motion model that `Average::model` and `pointed` fit. `automatic`: the smallest that
/// explains the patches. `still`: nothing moves, whatever the patches.
enum class ModelChoice { automatic, still, translation, similarity, affine };

/// Parts of the estimate. All are on, except where the lab measures what one of them is worth.
struct EstimateParts {
  bool second_motion = true;    ///< two motions in one region
  bool neighbours = true;       ///< neighbours that contradict the model alike
  bool pixel_confidence = true; ///< doubts of a mixture, and of rest that leaves much unexplained
};

struct PatchSet {
  std::span<const GstHapticPatch> patches; ///< those that could be trusted
  int candidates = 0;                      ///< patches tried
  float pointer_x = 0;                     ///< px
  float pointer_y = 0;                     ///< px
  double interval = 0;                     ///< s between the two frames, > 0
  float region_x = 0, region_y = 0;        ///< px, top left of the region of interest
  /// px; 0: the region is the box about the centres of the patches.
  float region_width = 0, region_height = 0;
  /// The patches cover the region, each with the mean over its pixels: their mean is the velocity,
  /// whatever the model.
  bool is_tiled = false;
  EstimateParts parts = {};
};

/// The choice of `automatic` from frame to frame, so that two models that explain a scene about
/// equally well do not alternate. A cut begins a new one (`{}`).
struct ModelHistory {
  MotionModel current = MotionModel::none;    ///< of the frame before
  MotionModel challenger = MotionModel::none; ///< explained that frame a little better
  bool mixture = false;                       ///< of the frame before: two motions
};

struct VelocityEstimate : PlanarMotion {
  float confidence = 0; ///< 0..1; 0: nothing was measured, and all else is 0
  int points = 0;       ///< patches that agree with the velocity
  MotionModel model = MotionModel::none;
  /// Two motions in one region: the velocity is their mean by area, `model` that of the first.
  bool mixture = false;
  /// All edges have one direction: the velocity is its part across them, and the confidence is that
  /// of this part.
  bool aperture = false;
  ModelHistory history; ///< for the next frame

  const PlanarMotion &motion() const noexcept { return *this; }
};

/// `automatic` minimises the geometric robust information criterion (Torr, IJCV 50(1), 2002) over
/// static, translation, similarity and affine. Errors count in units of each patch's precision,
/// direction by direction (0.1 px where it is unknown). Where the patches cannot determine the
/// model that was asked for (too few, or on one line), the next smaller one is fitted; the result
/// names it. Patches with a number that is not finite are left out. Never returns such a number,
/// never allocates. Pure.
VelocityEstimate estimate_velocity(const PatchSet &set, Average average, ModelChoice choice,
                                   ModelHistory history = {});

} // namespace haptic
