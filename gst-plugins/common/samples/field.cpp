// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/field.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr int kNarrowestCell = 8; // px

} // namespace

FieldShape field_shape(int width, int height, double pixel_aspect, int columns) noexcept {
  const int most = std::max(1, std::min(width / kNarrowestCell, static_cast<int>(kMostFieldCells)));
  FieldShape shape;
  for (shape.columns = std::clamp(columns, 1, most);; --shape.columns) {
    const double side = width * pixel_aspect / shape.columns;
    shape.rows =
        static_cast<int>(std::clamp(std::round(height / side), 1.0, std::max(1.0, height / 8.0)));
    if (shape.columns == 1)
      shape.rows = std::min(shape.rows, static_cast<int>(kMostFieldCells));
    if (static_cast<std::size_t>(shape.cells()) <= kMostFieldCells)
      return shape;
  }
}

} // namespace haptic
