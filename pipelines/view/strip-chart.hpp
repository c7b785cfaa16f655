// SPDX-License-Identifier: LGPL-2.1-or-later
// A scrolling strip of velocity and force.
#pragma once

#include <cairo.h>
#include <deque>
#include <string>

namespace view {

/// Of one frame. What is not finite was not measured.
struct Reading {
  double duration = 0; ///< s since the reading before
  double vx = 0;       ///< px/s, to the right
  double vy = 0;       ///< px/s, down
  double fx = 0;       ///< N, to the right
  double fy = 0;       ///< N, up
};

class StripChart {
public:
  void add(const Reading &reading);

  /// Fills width x height px. The newest reading is at the right border, so that the strip stands
  /// still while none come.
  void draw(cairo_t *cairo, double width, double height, const std::string &caption) const;

private:
  std::deque<Reading> readings_; // oldest first
};

} // namespace view
