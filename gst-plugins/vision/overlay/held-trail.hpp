// SPDX-License-Identifier: LGPL-2.1-or-later
// The path of a thing that is held, over the last second.
#pragma once

#include "samples/held-place.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace haptic {

/// Not thread-safe.
class HeldTrail {
public:
  struct Point {
    float x = 0, y = 0;     ///< fractions of the frame
    std::uint64_t time = 0; ///< ns since the frame in which the thing was taken
    bool joined = false;    ///< the thing was seen all the way from the point before
  };

  /// Takes what the next frame says. Where the thing is not seen, the trail has a gap; without a
  /// thing, or with another one, it begins anew.
  void add(const HeldPlace &held);
  void forget() { *this = {}; }

  /// The oldest first.
  std::span<const Point> points() const { return points_; }

private:
  std::vector<Point> points_;
  std::uint64_t time_ = 0; // of the frame before
  bool seen_ = false;      // in the frame before
};

} // namespace haptic
