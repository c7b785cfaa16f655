// SPDX-License-Identifier: LGPL-2.1-or-later
// One translation of several blocks, how much of the frames it explains, and what a patch of it
// is worth: what the trackers of a region and of the whole frame share.
#pragma once

#include "patch-grid.hpp"
#include "tensor.hpp"

namespace haptic {

/// Variance of a smoothed pixel from white noise of variance 1: (6/16)^2.
inline constexpr float kSmoothedNoise = 36.0F / 256;

/// What one translation of all blocks explains.
struct Translation {
  Displacement displacement;
  Tensor structure;
  float pixels = 0;
  float correlation = -1;     ///< mean over the blocks, weighted by their contrast
  float residual2 = 0;        ///< mean squared grey levels
  float interpolation2 = 0;   ///< how much of it interpolation may cause
  float disagreement = 0;     ///< chi-squared of what each block alone would correct
  bool one_direction = false; ///< only the component along strong_direction() is known

  float variance() const; ///< of the displacement times the structure
};

/// Whether an eigenvalue of the structure of so many pixels is more than noise (variance of a
/// pixel, grey levels squared) makes it.
bool has_texture(float eigenvalue, float pixels, float noise);

/// At most so many Gauss-Newton steps from `start`. `judged`: with `disagreement`, at the finest
/// level. All blocks have one side, at most kMaxPatches of them.
Translation translate_blocks(const Plane &later, std::span<const Template> blocks,
                             Displacement start, int iterations, float noise, bool judged);

/// Whether blocks of this side move as one.
bool explains(const Translation &whole, int side, float noise);
bool is_still(const Translation &whole);
bool is_precise(const Translation &whole);

/// A texture of one spatial frequency looks the same one period further, so that two frames
/// cannot tell which way it went. 0: no such texture, else the period in px, at most `longest`.
float period(const Plane &earlier, std::span<const Template> blocks, float longest);

/// The translation of the area as one patch.
Patch patch_of(const Area &area, const Translation &whole);

/// Adds the patch unless it cannot be trusted, and counts it as a candidate if it should have been.
/// Returns how far a candidate may be trusted, 0..1.
float add_patch(const Template &patch, Displacement moved, const Fit &fit, float noise,
                Measurement &measurement);

} // namespace haptic
