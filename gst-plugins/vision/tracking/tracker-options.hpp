// SPDX-License-Identifier: LGPL-2.1-or-later
// What the lab and the benchmarks change in the fast tracker.
#pragma once

namespace haptic {

/// Parts of the fast tracker. All are on, except where the lab measures what one of them is worth.
struct TrackerParts {
  bool still_pixels = true;      ///< first, a test whether any pixel changed
  bool still_translation = true; ///< a translation that is zero within its error is rest
  bool sudden = true;            ///< does not measure small changes that come suddenly
  bool prior = true;             ///< starts from the displacement between the two frames before
  bool search = true;            ///< looks further where the start led nowhere
  bool period = true;            ///< doubts and resolves textures that repeat
  bool coarse_starts = true;     ///< starts of patches from a grid on half the size
  bool bend = true;              ///< one affine motion of all patches before others are tried
  bool dither = true;            ///< patches off the raster of the pixels
  bool second_pass = true;       ///< starts of patches from their neighbours
  bool strain = true;            ///< patches that turn and stretch
  bool noise_at_rest = true;     ///< learns the noise from what does not move
  bool noise_of_fits = true;     ///< learns it also from what moves
  bool trust = true;             ///< correlation counts in the precision of a patch
  bool cut = true;               ///< recognises a cut
  bool votes = true;             ///< pixels vote where neighbouring patches disagree
  bool labels = true;            ///< pixels follow one of two motions, if these explain them
  bool layers = true;            ///< one motion for layers over one another (reflections)
};

/// Options that trade speed for accuracy. The element uses the defaults.
struct FastTrackerOptions {
  float spacing = 6;        ///< px between the patches of the grid, for a region of 30 px
  int iterations = 4;       ///< most Gauss-Newton steps of a patch
  int levels = 3;           ///< 1..5, of the pyramid for a region of 30 px
  bool always_grid = false; ///< even where one translation explains the region
  TrackerParts parts = {};
};

} // namespace haptic
