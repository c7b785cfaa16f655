// SPDX-License-Identifier: LGPL-2.1-or-later
// From the place of a held thing in each frame to its way: smooth, and never beyond a known place.
#pragma once

#include "samples/held-place.hpp"

#include <cstdint>

namespace haptic {

/// Parts of the frame, origin at its top left corner.
struct FramePoint {
  double x = 0;
  double y = 0;
  bool operator==(const FramePoint &) const = default;
};

/// A place on the way, and how fast the thing is there.
struct WayPoint {
  FramePoint place;
  FramePoint speed; ///< 1/s
  bool operator==(const WayPoint &) const = default;
};

/// The held thing at one time.
struct HeldAt {
  HoldState state = HoldState::none;
  FramePoint place;     ///< while it is held or hidden
  FramePoint moved;     ///< since the call before, of the same thing
  bool another = false; ///< than at the call before
};

/// Returns whether both frames show the same thing: it was not taken anew between them.
constexpr bool is_same_thing(const HeldPlace &before, const HeldPlace &after) noexcept {
  return before.state != HoldState::none && before.time < after.time;
}

/// Returns the way in the middle between two frames, `interval` ns apart: the velocity of a motion
/// is known there, too.
WayPoint middle_of_way(const HeldPlace &before, const HeldPlace &after,
                       std::int64_t interval) noexcept;

/// A cubic line from where the thing is to where it will be, so that place and speed have no step.
/// One thread; real-time safe; times in ns.
class HeldPath {
public:
  /// Another thing, or none.
  void end() noexcept { begun_ = false; }
  bool begun() const noexcept { return begun_; }
  void begin(const WayPoint &there, std::int64_t now) noexcept;
  /// The thing is there at `time`. Changes nothing if it was told so before.
  void lead_to(const WayPoint &there, std::int64_t time, std::int64_t now) noexcept;
  /// Nothing is known after `place`: the thing comes to rest there within `interval`.
  void stop_at(const FramePoint &place, std::int64_t interval, std::int64_t now) noexcept;
  /// Returns the place at `now`, and the way since the call before.
  HeldAt at(std::int64_t now) noexcept;

private:
  WayPoint point(std::int64_t now) const noexcept;
  void head_for(const WayPoint &there, std::int64_t time, std::int64_t now) noexcept;

  bool begun_ = false;
  bool stops_ = false;
  WayPoint from_;
  WayPoint to_;
  std::int64_t begin_ = 0; // ns, at from_
  std::int64_t end_ = 0;   // ns, at to_
  FramePoint last_;        // of the call before
};

} // namespace haptic
