// SPDX-License-Identifier: LGPL-2.1-or-later
// A scrolling strip of velocity and force.
#pragma once

#include <cairo.h>
#include <deque>
#include <gdk/gdk.h>

namespace program {

/// Motion and force of one frame. A value that was not measured is not finite.
struct Reading {
  double duration = 0; ///< s since the previous reading
  double vx = 0;       ///< px/s, to the right
  double vy = 0;       ///< px/s, down
  double fx = 0;       ///< N, to the right
  double fy = 0;       ///< N, up
};

/// Of the window: a light one or a dark one.
struct ChartColors {
  GdkRGBA background{};
  GdkRGBA text{};
};

class StripChart {
public:
  void add(const Reading &reading);
  void clear() { readings_.clear(); }

  /// Fills width x height px. The newest reading is at the right border: without new readings the
  /// strip does not move.
  void draw(cairo_t *cairo, double width, double height, const ChartColors &colors) const;

private:
  std::deque<Reading> readings_; // oldest first
};

} // namespace program
