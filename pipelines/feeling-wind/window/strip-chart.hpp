// SPDX-License-Identifier: LGPL-2.1-or-later
// A scrolling strip of velocity and force.
#pragma once

#include "player/reading.hpp"

#include <cairo.h>
#include <deque>
#include <gdk/gdk.h>

namespace program {

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
