// Tells a picture that was merely shown twice from a scene that stands still.
#pragma once

namespace haptic {

enum class Repetition {
  none,      ///< the pixels changed
  duplicate, ///< the picture is the one before once more, its motion goes on (3:2 pulldown)
  still,     ///< nothing moves
};

/// One answer per picture. Not thread-safe.
class RepetitionJudge {
public:
  /// `same_here`: the pixels under the pointer did not change. `same_there()`: nor did those where
  /// motion was last seen, asked only when it matters. A duplicate repeats everywhere; when the
  /// pointer has left what moves for what stands still, only the pixels under it do.
  template <typename SameThere>
  Repetition judge(bool same_here, SameThere &&same_there) {
    const bool may_move = may_move_;
    may_move_ = !same_here;
    if (!same_here)
      return Repetition::none;
    return may_move && same_there() ? Repetition::duplicate : Repetition::still;
  }

  /// Of a stream that begins nothing is known: it may begin with a duplicate.
  void forget() { may_move_ = true; }

private:
  bool may_move_ = true;
};

} // namespace haptic
