// SPDX-License-Identifier: LGPL-2.1-or-later
// Distinguishes a frame that is shown twice from a scene that stands still.
#pragma once

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
      repeats_ = 0;
      return Repetition::none;
    }
    if (repeats_ < kMostRepeats && same_there()) {
      ++repeats_;
      return Repetition::duplicate;
    }
    repeats_ = kMostRepeats;
    return Repetition::still;
  }

  /// Begins a new stream, which may start with a duplicate.
  void forget() { repeats_ = 0; }

private:
  // Film at 24 frames a second, shown at 60, shows frames three times and twice in turn.
  static constexpr int kMostRepeats = 2;
  int repeats_ = 0;
};

} // namespace haptic
