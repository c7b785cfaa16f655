// SPDX-License-Identifier: LGPL-2.1-or-later
// Motions that the patches of a grid have in common. Patches and their alignments have the same
// index, and lengths are px of their plane.
#pragma once

#include "haptic-patch.h"
#include "patches/patch-grid.hpp"

#include <optional>
#include <span>

namespace haptic {

/// The middle of a template, which a strain leaves where it is.
Displacement middle_of(const Template &patch);

/// An affine motion: the displacement of a place, and its gradient.
struct BentMotion {
  Displacement place;
  Displacement displacement;
  Strain strain;

  Displacement at(Displacement other) const;
  /// Whether the gradient moves a corner of a patch noticeably.
  bool is_bent() const;
  /// The same in a plane of `scale` times as many pixels along each axis.
  BentMotion finer(float scale) const;
};

/// The affine motion of patches with texture. Nothing if too few can be trusted, or if one of them
/// errs by more than `most`.
std::optional<BentMotion> find_bent_motion(std::span<const Template> patches,
                                           std::span<const Alignment> aligned, float most);

/// The strain at a patch, from its neighbours, which have these displacements. Nothing where it is
/// too small to matter, and where the neighbours have no gradient in common.
std::optional<Strain> strain_at(const PatchGrid &grid, int row, int column,
                                std::span<const Alignment> aligned,
                                std::span<const Displacement> displacements);

/// The displacement that most patches are near to, of those that are far from `other`.
std::optional<Displacement> commonest_of(std::span<const GstHapticPatch> patches,
                                         std::optional<Displacement> other);

} // namespace haptic
