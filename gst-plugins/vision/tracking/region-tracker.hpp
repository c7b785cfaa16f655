// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion in a region of interest, frame after frame: compares the pixels of two frames first,
// and runs the patch tracker only where they differ.
#pragma once

#include "pixels/kept-luma.hpp"
#include "tracking/patch-tracker.hpp"
#include "tracking/region.hpp"
#include "tracking/repetition.hpp"

#include <chrono>
#include <memory>
#include <optional>
#include <string>

namespace haptic {

enum class TrackerMethod { fast, opencv, layers };

/// The areas of a frame that belong to one pointer position.
struct Areas {
  Rectangle region; ///< of interest
  Rectangle crop;   ///< the region and the margin that the tracker needs
  int frame_width;  ///< px
  int frame_height; ///< px
};

/// The result for one frame.
struct Finding {
  std::uint16_t flags = 0;       ///< of kFrameFlags, and kTiled
  std::uint64_t interval = 0;    ///< ns
  bool becomes_reference = true; ///< the next frame is compared with this one
  /// From the frames to the patches, with the conversion to luma. Nothing: the tracker did not run.
  std::optional<std::chrono::nanoseconds> time;
  std::string error; ///< reason why the tracker failed; empty: it did not
};

/// Whether two views of the same size show the same pixels.
bool is_identical(const LumaView &one, const LumaView &other);

/// One instance serves one stream, from one thread at a time.
class RegionTracker {
public:
  /// Changes the method and the limit for the frames that follow.
  void set_method(TrackerMethod method, int max_points);

  /// Returns the region with the margin of the method in use, clipped at the frame.
  Areas areas(const Rectangle &region, int frame_width, int frame_height) const;

  /// Compares a frame with the earlier one, which is the frame of the latest finding that became
  /// the reference, or of the latest skip(). Leaves the patches in measurement(). `interval`: ns
  /// between the two frames; 0: not known.
  Finding compare(const LumaSource &earlier, const LumaSource &frame, const Areas &areas,
                  std::uint64_t interval = 0);

  /// A frame that is not compared becomes the earlier one.
  void skip();

  /// Forgets the earlier frames: the frame that follows begins a scene.
  void forget();

  void clear_measurement() { measurement_.clear(); }
  const Measurement &measurement() const { return measurement_; }

private:
  Repetition repetition(const LumaSource &earlier, const LumaSource &frame, const CropPair &pair);
  void run(const CropPair &pair, Finding &finding);

  TrackerMethod method_ = TrackerMethod::layers;
  std::unique_ptr<PatchTracker> tracker_ = make_layer_tracker();
  RepetitionJudge judge_;
  Rectangle moving_crop_;             // where motion was last seen; empty: nowhere yet
  int repeats_ = 0;                   // still frames since the tracker was last asked
  bool earlier_was_measured_ = false; // by the tracker, as the later frame
  Measurement measurement_;
  KeptLuma earlier_luma_;
  KeptLuma luma_;
};

} // namespace haptic
