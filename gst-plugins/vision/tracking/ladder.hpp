// SPDX-License-Identifier: LGPL-2.1-or-later
// The fast tracker in two halves, for a tracker that explains in its own way what is neither at
// rest nor one translation.
#pragma once

#include "tracking/patch-tracker.hpp"

namespace haptic {

/// What two frames alone say of a region.
enum class Explanation {
  none,        ///< more than one translation
  rest,        ///< measured as still
  translation, ///< one patch
  unseen,      ///< nothing but noise, which could hide a motion
  sudden,      ///< a small change after rest, as a key frame makes it; not measured
  periodic,    ///< a texture that could have moved in several ways; not measured
  fields,      ///< two fields of an interlaced frame, measured apart
  narrow,      ///< too little to measure
};

class Ladder : public PatchTracker {
public:
  /// The first half of measure(). After `none` the second half may follow for the same pair.
  virtual Explanation measure_simply(const CropPair &pair, Measurement &measurement) = 0;
  virtual void measure_rest(Measurement &measurement) = 0;

  /// Of the pair, px, after `translation` and `none`: also if it does not explain the pixels.
  virtual Displacement best_translation() const = 0;
};

/// make_fast_tracker() with the usual options.
std::unique_ptr<Ladder> make_ladder();

} // namespace haptic
