// SPDX-License-Identifier: LGPL-2.1-or-later
// What the player tells the window of each frame.
#pragma once

#include "samples/held-place.hpp"

namespace program {

/// Motion and force of one frame. A value that was not measured is not finite.
struct Reading {
  double duration = 0; ///< s since the previous reading
  double vx = 0;       ///< px/s, to the right
  double vy = 0;       ///< px/s, down
  double fx = 0;       ///< N, to the right
  double fy = 0;       ///< N, up
  haptic::HoldState hold = haptic::HoldState::none;
};

} // namespace program
