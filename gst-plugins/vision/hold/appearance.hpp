// SPDX-License-Identifier: LGPL-2.1-or-later
// What a thing looks like, learned while it is seen, and which samples of the patch are of it.
#pragma once

#include "hold/patch-kernels.hpp"

namespace haptic {

/// How much a patch looks like the appearance about its middle.
struct Likeness {
  float correlation = 0; ///< zero-mean, normalised; noise of two grey levels is counted
  float share = 0;       ///< of the samples that differ no more than usual
  float difference = 0;  ///< grey levels, mean
};

/// Learns only where it fits: what passes before the thing leaves nothing behind.
class Appearance {
public:
  /// Begins with this patch. A sample counts as far as it is near the middle, and as `fits` says
  /// that it belongs to the thing (0..1); it learns the rest.
  void begin(const PatchSamples &grey, const PatchSamples &fits);

  /// `error_scale`: grey levels, of what fits in this frame.
  void learn(const PatchSamples &now, float error_scale, float fit_rate, float grey_rate);

  Likeness compare(const PatchSamples &now, float usual_difference) const;

  const PatchSamples &grey() const { return patch_.grey; }
  /// With its gradients.
  const PatchTemplate &patch();
  /// Weights by the distance from the middle alone.
  static const PatchSamples &nearness();
  /// Weights of the samples that belong to the thing.
  const PatchSamples &mask() const { return mask_; }

private:
  void update_mask();

  PatchTemplate patch_;
  PatchSamples fits_; // 0..1
  PatchSamples mask_;
  PatchSamples judged_; // the middle, by how well it fits
};

} // namespace haptic
