// SPDX-License-Identifier: LGPL-2.1-or-later
// The interface of a tracker: two crops of luma in, patches with their displacement out.
#pragma once

#include "layers/frame-translation.hpp"
#include "patches/measurement.hpp"
#include "pixels/luma-view.hpp"
#include "tracking/tracker-options.hpp"

#include <algorithm>
#include <bit>
#include <memory>

namespace haptic {

inline constexpr int kUsualPatches = 20; ///< the number that the lab measures with

/// px, side of the region in the paper. Constants of length hold for this side.
inline constexpr int kPaperSide = 30;

/// Doublings of the region over that of the paper: a region twice as wide shows displacements twice
/// as large.
inline int doublings(int region_side) {
  return std::bit_width(static_cast<unsigned>(std::max(region_side / kPaperSide, 1))) - 1;
}

/// Two frames cropped at the same place, so that a moving pointer does not look like motion.
struct CropPair {
  LumaView previous;
  LumaView current;
  Rectangle crop;         ///< where both views lie in the frame
  Rectangle region;       ///< the region of interest in the frame, inside crop
  bool continues = false; ///< previous is the frame that was `current` in the call before
  /// Frames since that call that repeated the one before, not handed over; 0 for one that
  /// measures_unchanged().
  int repeats = 0;
  /// Both frames, for a tracker that looks beyond the crop; nothing: it cannot.
  const FramePair *frames = nullptr;
  float seconds = 0; ///< between the two frames; 0: not known
};

/// One instance serves one stream, from one thread at a time.
class PatchTracker {
public:
  virtual ~PatchTracker() = default;

  /// Pixels wanted around a region of this side length; the caller clips the crop at the frame.
  virtual int margin(int region_side) const = 0;

  /// At most max_points patches (1..kMaxPatches).
  virtual void set_max_points(int max_points) = 0;

  /// Whether it is asked about pixels that did not change, too. A coder lets slow things stand for
  /// some frames; a tracker that remembers knows that they go on.
  virtual bool measures_unchanged() const { return false; }

  /// Overwrites `measurement`. It holds no patches if nothing could be tracked.
  virtual void measure(const CropPair &pair, Measurement &measurement) = 0;

  /// Forgets earlier frames (discontinuity, flush, new caps).
  virtual void reset() = 0;
};

/// Still, one translation or a grid of patches, whichever is the simplest that explains the pixels.
/// Inverse-compositional Lucas-Kanade, invariant to gain and offset.
std::unique_ptr<PatchTracker> make_fast_tracker(const FastTrackerOptions &options = {});

/// The default: still, one translation, or what moves before a background, each with its own
/// motion. The mean of the patches is the mean over the region as it moved. As the fast tracker,
/// where nothing is remembered of the place.
std::unique_ptr<PatchTracker> make_layer_tracker();

/// The reference: Shi-Tomasi corners and pyramidal Lucas-Kanade with a forward-backward check.
std::unique_ptr<PatchTracker> make_opencv_tracker();

} // namespace haptic
