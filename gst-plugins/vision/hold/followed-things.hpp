// SPDX-License-Identifier: LGPL-2.1-or-later
// Follows several things of a film at once, so that a receiver of its fields can hold them.
#pragma once

#include "hold/held-thing.hpp"
#include "samples/motion-field.hpp"

#include <cstddef>
#include <list>
#include <span>
#include <vector>

namespace haptic {

/// One instance serves one stream, from one thread at a time.
class FollowedThings {
public:
  /// All of them end.
  void forget() noexcept { followed_.clear(); }

  /// The next frame, so many seconds later. Things that are lost end.
  void follow(const LumaSource &frame, float seconds);
  /// The same, of a frame with the same pixels.
  void rest(const LumaSource &frame, float seconds);

  /// Takes what is under a place (fractions of the frame), unless there is nothing to hold or there
  /// are kMostFieldThings already. `frame` is the frame of the last follow().
  void take(const LumaSource &frame, int width, int height, float x, float y);

  /// Takes things until it has chosen `most` that still are there: first those where the field
  /// moves fastest, far enough from each other, and only those that can be told from their
  /// neighbours.
  void choose(const LumaSource &frame, const MotionField &field, std::size_t most);

  /// As a field has them.
  void write(int width, int height, std::vector<FieldThing> &things) const;

private:
  struct Followed {
    std::uint16_t id = 0;
    bool is_chosen = false;
    HeldThing thing;
  };
  void take(const LumaSource &frame, int width, int height, float x, float y, bool is_chosen);
  void end_lost();
  bool is_near(float x, float y) const noexcept;

  std::list<Followed> followed_;
  std::uint16_t next_id_ = 1;
};

} // namespace haptic
