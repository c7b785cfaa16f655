// SPDX-License-Identifier: LGPL-2.1-or-later
// The interface of a tracker: two crops of luma in, patches with their displacement out.
#pragma once

#include "haptic-patch.h"
#include "motion-sample.hpp"
#include "region.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace haptic {

using Patch = GstHapticPatch;

inline constexpr int kMaxPatches = GST_HAPTIC_MOTION_META_MAX_PATCHES;
inline constexpr int kUsualPatches = 20; ///< as the lab measures it

/// Standard deviation of the noise that a camera's frame is assumed to have, 8-bit grey levels.
inline constexpr float kAssumedNoise = 1.5F;

/// Rows of 8-bit luma somewhere in memory; not owned.
struct LumaView {
  const std::uint8_t *pixels = nullptr;
  int width = 0;             ///< px
  int height = 0;            ///< px
  std::ptrdiff_t stride = 0; ///< bytes from row to row, may exceed the width
};

/// Two frames cropped at the same place, so that a moving pointer is not taken for motion.
struct CropPair {
  LumaView previous;
  LumaView current;
  Rectangle crop;         ///< where both views lie in the frame
  Rectangle region;       ///< the region of interest in the frame, inside crop
  bool continues = false; ///< previous is the frame that was `current` in the call before
};

/// The MotionFlags that a tracker sets: why there are no patches, or that they may mean nothing.
inline constexpr std::uint16_t kStill = kMotionStill; ///< the displacement is exactly zero
inline constexpr std::uint16_t kCut = kMotionCut;

/// What was measured. Patch centres are in frame coordinates.
struct Measurement {
  std::uint16_t flags = 0; ///< kStill or kCut
  int candidates = 0; ///< patches looked at; those that could not be trusted are not in the list
  int count = 0;
  std::array<Patch, kMaxPatches> patches;

  void clear() {
    flags = 0;
    candidates = 0;
    count = 0;
  }
  void add(const Patch &patch) { patches[static_cast<std::size_t>(count++)] = patch; }
  std::span<const Patch> view() const { return {patches.data(), static_cast<std::size_t>(count)}; }
};

/// One instance serves one stream, from one thread at a time.
class PatchTracker {
public:
  virtual ~PatchTracker() = default;

  /// Pixels wanted around a region of this side length; the caller clips the crop at the frame.
  virtual int margin(int region_side) const = 0;

  /// At most max_points patches (1..kMaxPatches).
  virtual void set_max_points(int max_points) = 0;

  /// Fills `measurement` anew. An empty one means that nothing could be tracked.
  virtual void measure(const CropPair &pair, Measurement &measurement) = 0;

  /// Forgets earlier frames (discontinuity, flush, new caps).
  virtual void reset() = 0;
};

/// What may be traded between speed and accuracy; the defaults are what the element runs.
struct FastTrackerOptions {
  float spacing = 6;        ///< px between the patches of the grid, for a region of 30 px
  int iterations = 4;       ///< most Gauss-Newton steps of a patch
  int levels = 3;           ///< 1..5, of the pyramid for a region of 30 px
  bool always_grid = false; ///< also where one translation explains the region
};

/// The default: still, one translation or a grid of patches, whatever is the least that explains
/// the pixels. Inverse-compositional Lucas-Kanade, invariant to gain and offset.
std::unique_ptr<PatchTracker> make_fast_tracker(const FastTrackerOptions &options = {});

/// The reference: Shi-Tomasi corners and pyramidal Lucas-Kanade with a forward-backward check.
std::unique_ptr<PatchTracker> make_opencv_tracker();

} // namespace haptic
