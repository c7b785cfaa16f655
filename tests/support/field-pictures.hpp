// A field of two pictures, as the element reads them.
#pragma once

#include "field-tracker.hpp"
#include "moving-texture.hpp"

#include <vector>

namespace test {

inline haptic::LumaView view_of(const Picture &picture) {
  return {picture.pixels.data(), picture.width, picture.height, picture.width};
}

/// Reads the whole picture, strip by strip.
inline void read(haptic::FieldTracker &tracker, const haptic::LumaView &picture) {
  for (int y = 0; y < picture.height; y += tracker.strip_rows())
    tracker.read({picture.pixels + y * picture.stride, picture.width,
                  std::min(tracker.strip_rows(), picture.height - y), picture.stride});
}

/// Velocities are in px per picture.
struct Field {
  int width;
  int height;
  haptic::FieldShape shape;
  haptic::FieldTracker tracker;
  std::vector<haptic::FieldCell> cells;

  Field(int picture_width, int picture_height, int columns = 32)
      : width(picture_width), height(picture_height),
        shape(haptic::field_shape(width, height, 1, columns)),
        cells(static_cast<std::size_t>(shape.cells())) {
    tracker.set_picture(width, height, shape);
  }

  const haptic::FieldCell &at(int row, int column) const {
    return cells[static_cast<std::size_t>(row * shape.columns + column)];
  }

  /// The picture follows on the one before. Returns MeasurementFlags.
  std::uint32_t follow(const haptic::LumaView &picture) {
    read(tracker, picture);
    const std::uint32_t flags = tracker.measure(1, cells);
    tracker.keep();
    return flags;
  }
  std::uint32_t follow(const Picture &picture) { return follow(view_of(picture)); }

  std::uint32_t measure(const Picture &before, const Picture &after) {
    tracker.forget();
    follow(before);
    return follow(after);
  }
};

} // namespace test
