// SPDX-License-Identifier: LGPL-2.1-or-later
// The interface of a tracker: two crops of luma in, patches with their displacement out.
#pragma once

#include "haptic-patch.h"
#include "motion-sample.hpp"
#include "region.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace haptic {

using Patch = GstHapticPatch;

inline constexpr int kMaxPatches = GST_HAPTIC_MOTION_META_MAX_PATCHES;
inline constexpr int kUsualPatches = 20; ///< the number that the lab measures with

/// px, side of the region in the paper. Constants of length hold for this side.
inline constexpr int kPaperSide = 30;

/// Doublings of the region over that of the paper: a region twice as wide shows displacements twice
/// as large.
inline int doublings(int region_side) {
  return std::bit_width(static_cast<unsigned>(std::max(region_side / kPaperSide, 1))) - 1;
}

/// Standard deviation of the noise that a camera's frame is assumed to have, 8-bit grey levels.
inline constexpr float kAssumedNoise = 1.5F;

/// Largest mean squared residual of a patch that compression of a still scene leaves, grey levels
/// squared.
inline constexpr float kCompressionResidual2 = 40;

/// Rows of 8-bit luma somewhere in memory; not owned.
struct LumaView {
  const std::uint8_t *pixels = nullptr;
  int width = 0;             ///< px
  int height = 0;            ///< px
  std::ptrdiff_t stride = 0; ///< bytes from row to row, may exceed the width
};

/// Two frames cropped at the same place, so that a moving pointer does not look like motion.
struct CropPair {
  LumaView previous;
  LumaView current;
  Rectangle crop;         ///< where both views lie in the frame
  Rectangle region;       ///< the region of interest in the frame, inside crop
  bool continues = false; ///< previous is the frame that was `current` in the call before
  int repeats = 0;        ///< frames since that call that repeated the one before, not handed over
};

/// The MotionFlags that a tracker sets.
inline constexpr std::uint16_t kStill = kMotionStill; ///< the displacement is exactly zero
inline constexpr std::uint16_t kCut = kMotionCut;     ///< the frames do not show the same scene

/// The result of a tracker. Patch centres are in frame coordinates.
struct Measurement {
  std::uint16_t flags = 0; ///< kStill or kCut
  int candidates = 0;      ///< patches looked at; those that cannot be trusted are not in the list
  int count = 0;
  std::array<Patch, kMaxPatches> patches;

  void clear() {
    flags = 0;
    candidates = 0;
    count = 0;
  }
  /// A patch beyond kMaxPatches is left out.
  void add(const Patch &patch) {
    if (count < kMaxPatches)
      patches[static_cast<std::size_t>(count++)] = patch;
  }
  std::span<const Patch> view() const { return {patches.data(), static_cast<std::size_t>(count)}; }
  std::span<Patch> view() { return {patches.data(), static_cast<std::size_t>(count)}; }

  /// Moves the origin of the coordinates by (-x, -y) px.
  void shift(float x, float y) {
    for (Patch &patch : view()) {
      patch.x += x;
      patch.y += y;
    }
  }
  /// Converts to the pixels of a frame that is `factor` times larger.
  void scale(float factor) {
    if (factor == 1)
      return;
    for (Patch &patch : view()) {
      for (float *length : {&patch.x, &patch.y, &patch.width, &patch.height, &patch.dx, &patch.dy})
        *length *= factor;
      for (float *precision : {&patch.precision_xx, &patch.precision_xy, &patch.precision_yy})
        *precision /= factor * factor;
    }
  }
};

/// One instance serves one stream, from one thread at a time.
class PatchTracker {
public:
  virtual ~PatchTracker() = default;

  /// Pixels wanted around a region of this side length; the caller clips the crop at the frame.
  virtual int margin(int region_side) const = 0;

  /// At most max_points patches (1..kMaxPatches).
  virtual void set_max_points(int max_points) = 0;

  /// Overwrites `measurement`. It holds no patches if nothing could be tracked.
  virtual void measure(const CropPair &pair, Measurement &measurement) = 0;

  /// Forgets earlier frames (discontinuity, flush, new caps).
  virtual void reset() = 0;
};

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

/// The default: still, one translation or a grid of patches, whichever is the simplest that
/// explains the pixels. Inverse-compositional Lucas-Kanade, invariant to gain and offset.
std::unique_ptr<PatchTracker> make_fast_tracker(const FastTrackerOptions &options = {});

/// The reference: Shi-Tomasi corners and pyramidal Lucas-Kanade with a forward-backward check.
std::unique_ptr<PatchTracker> make_opencv_tracker();

} // namespace haptic
