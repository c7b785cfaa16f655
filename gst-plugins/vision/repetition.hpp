// SPDX-License-Identifier: LGPL-2.1-or-later
// Tells a frame that was merely shown twice from a scene that stands still.
#pragma once

namespace haptic {

enum class Repetition {
  none,      ///< the pixels changed
  duplicate, ///< the frame is the one before once more, its motion goes on (3:2 pulldown)
  still,     ///< nothing moves
};

/// One answer per frame. Not thread-safe.
class RepetitionJudge {
public:
  /// `same_here`: the pixels under the pointer did not change. `same_there()`: nor did those where
  /// motion was last seen, asked only when it matters. A duplicate repeats everywhere; when the
  /// pointer has left what moves for what stands still, only the pixels under it do.
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

  /// Of a stream that begins nothing is known: it may begin with a duplicate.
  void forget() { repeats_ = 0; }

private:
  // Film at 24 frames a second shown at 60: three times, twice, three times.
  static constexpr int kMostRepeats = 2;
  int repeats_ = 0;
};

} // namespace haptic
