// SPDX-License-Identifier: LGPL-2.1-or-later
// The field tracker with frames of a test, read strip by strip as the element reads them.
#pragma once

#include "field/field-tracker.hpp"
#include "frame-view.hpp"

#include <vector>

namespace test {

/// Reads the whole frame, strip by strip.
inline void read(haptic::FieldTracker &tracker, const haptic::LumaView &frame) {
  for (int y = 0; y < frame.height; y += tracker.strip_rows())
    tracker.read({frame.pixels + y * frame.stride, frame.width,
                  std::min(tracker.strip_rows(), frame.height - y), frame.stride});
}

/// Velocities are in px per frame.
struct Field {
  int width;
  int height;
  haptic::FieldShape shape;
  haptic::FieldTracker tracker;
  std::vector<haptic::FieldCell> cells;

  Field(int frame_width, int frame_height, int columns = 32)
      : width(frame_width), height(frame_height),
        shape(haptic::field_shape(width, height, 1, columns)),
        cells(static_cast<std::size_t>(shape.cells())) {
    tracker.set_frame(width, height, shape);
  }

  const haptic::FieldCell &at(int row, int column) const {
    return cells[static_cast<std::size_t>(row * shape.columns + column)];
  }

  /// Measures from the frame before to this one, `interval` seconds later. Returns the flags.
  std::uint32_t follow(const haptic::LumaView &frame, double interval = 1) {
    read(tracker, frame);
    const std::uint32_t flags = tracker.measure(interval, cells);
    for (haptic::FieldCell &cell : cells) {
      cell.velocity_x *= static_cast<float>(interval);
      cell.velocity_y *= static_cast<float>(interval);
    }
    tracker.keep();
    return flags;
  }
  std::uint32_t follow(const Frame &frame, double interval = 1) {
    return follow(view_of(frame), interval);
  }

  std::uint32_t measure(const Frame &before, const Frame &after) {
    tracker.forget();
    follow(before);
    return follow(after);
  }
};

} // namespace test
