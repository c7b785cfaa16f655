// SPDX-License-Identifier: LGPL-2.1-or-later
// Recognises the key frames of a codec. Between them it leaves out what changes little, and draws
// that anew in a key frame: clouds and shades jump by some pixels, though nothing moved.
#pragma once

#include "pixels/luma-view.hpp"

#include <algorithm>

namespace haptic {

/// Compares how much each frame of a region changed with the frames before.
class SuddenChange {
public:
  /// `energy`: mean squared difference to the frame before, grey levels squared. Returns whether it
  /// is far above those before, and no larger than compression leaves: a key frame, or the first
  /// frame of a faint motion, which the next frame shows too.
  bool add(float energy) {
    const bool is_sudden = frames_ >= kFewest && energy < kCompressionResidual2 &&
                           energy > kLeast && energy > kSudden * recent_;
    frames_ = std::min(frames_ + 1, kFewest);
    recent_ = std::max(energy, kKept * recent_);
    return is_sudden;
  }

private:
  static constexpr int kFewest = 8;    // frames before
  static constexpr float kLeast = 1;   // grey levels squared: less is nothing to feel
  static constexpr float kSudden = 4;  // times the largest before
  static constexpr float kKept = 0.8F; // of it, each frame: films show a frame up to five times

  int frames_ = 0;
  float recent_ = 0; // the largest energy of the frames before, fading
};

} // namespace haptic
