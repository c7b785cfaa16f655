// SPDX-License-Identifier: LGPL-2.1-or-later
// Distinguishes a frame that is shown twice from a scene that stands still.
#pragma once

#include <algorithm>

namespace haptic {

enum class Repetition {
  none,      ///< the pixels changed
  duplicate, ///< the frame repeats the one before, whose motion goes on (3:2 pulldown)
  still,     ///< nothing moves
};

/// To be asked once per frame. Not thread-safe.
class RepetitionJudge {
public:
  /// `same_here`: the pixels under the pointer did not change. `same_there()`: those where motion
  /// was last seen did not change either; it is called only if the result depends on it. A
  /// duplicate repeats in both places. A pointer that moved from a moving object to one at rest
  /// sees equal pixels under itself only.
  template <typename SameThere>
  Repetition judge(bool same_here, SameThere &&same_there) {
    if (!same_here) {
      if (repeats_ > 0)
        expected_ = repeats_ > kMostRepeats ? kUsualRepeats : std::max(repeats_, kUsualRepeats);
      repeats_ = 0;
      return Repetition::none;
    }
    repeats_ = std::min(repeats_ + 1, kMostRepeats + 1);
    if (repeats_ > expected_)
      return Repetition::still;
    if (same_there())
      return Repetition::duplicate;
    repeats_ = kMostRepeats + 1;
    return Repetition::still;
  }

  /// Begins a new stream, which may start with a duplicate.
  void forget() { *this = {}; }

private:
  // Film at 24 frames a second, shown at 60, shows frames three times and twice in turn.
  static constexpr int kUsualRepeats = 2;
  // 15 frames a second, shown at 120. What is repeated more often stands still.
  static constexpr int kMostRepeats = 7;
  int repeats_ = 0;              // at most one more than these
  int expected_ = kUsualRepeats; // of a frame, as of the last one that was repeated
};

} // namespace haptic
