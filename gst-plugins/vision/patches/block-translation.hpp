// SPDX-License-Identifier: LGPL-2.1-or-later
// One translation of several blocks, and how well it explains the pixels.
#pragma once

#include "patches/patch-grid.hpp"
#include "patches/patch-trust.hpp"
#include "pixels/tensor.hpp"

namespace haptic {

/// Most Gauss-Newton steps at a level where the start may be a pixel off.
inline constexpr int kMostSteps = 5;

/// The translation of all blocks together.
struct Translation {
  Displacement displacement;
  Tensor structure;           ///< sum over the blocks inside the frame
  float pixels = 0;           ///< of the blocks inside the frame
  float correlation = -1;     ///< mean over the blocks, weighted by their contrast
  float residual2 = 0;        ///< mean squared grey levels
  float interpolation2 = 0;   ///< the part of it that interpolation may cause
  float disagreement = 0;     ///< chi-squared of the corrections that the blocks want one by one
  bool one_direction = false; ///< only the component along strong_direction() is known

  float variance() const; ///< of the displacement times the structure
};

/// At most `iterations` Gauss-Newton steps from `start`. `judged`: also fills in `disagreement`,
/// which only makes sense at the finest level. All blocks have one side, at most kMaxPatches of
/// them. `noise`: variance of a pixel, grey levels squared.
Translation translate_blocks(const Plane &later, std::span<const Template> blocks,
                             Displacement start, int iterations, float noise, bool judged);

/// Whether blocks of this side move as one.
bool explains(const Translation &whole, int side, float noise);
/// Whether the displacement is zero within its error, and no more than noise (variance of a pixel,
/// grey levels squared) and compression are left.
bool is_still(const Translation &whole, float noise);
/// Whether the error of the displacement is small enough for a single patch.
bool is_precise(const Translation &whole);

/// The translation of the area as one patch.
Patch patch_of(const Area &area, const Translation &whole);

} // namespace haptic
