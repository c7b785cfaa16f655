// SPDX-License-Identifier: LGPL-2.1-or-later
// The field beside the tracker of a region at the same places.
#pragma once

#include "field-frames.hpp"
#include "region-tracking.hpp"

#include <algorithm>
#include <cmath>

namespace test {

/// px per frame and confidence of the region tracker for a region that is the cell.
inline haptic::VelocityEstimate region_at_cell(const Field &field, const haptic::LumaView &before,
                                               const haptic::LumaView &after, int row, int column) {
  const auto edge = [](int index, int length, int parts) { return index * length / parts; };
  const int left = edge(column, field.width, field.shape.columns);
  const int top = edge(row, field.height, field.shape.rows);
  const haptic::Rectangle region{left, top,
                                 edge(column + 1, field.width, field.shape.columns) - left,
                                 edge(row + 1, field.height, field.shape.rows) - top};
  const auto tracker = haptic::make_fast_tracker();
  const haptic::Rectangle crop =
      haptic::crop_around(region, tracker->margin(region.width), field.width, field.height);
  const auto view = [&](const haptic::LumaView &frame) {
    return haptic::LumaView{frame.pixels + crop.y * frame.stride + crop.x, crop.width, crop.height,
                            frame.stride};
  };
  haptic::Measurement found;
  tracker->measure({view(before), view(after), crop, region}, found);
  if (found.flags & haptic::kStill)
    return {.confidence = 1};
  return estimate(found, region);
}

/// px per frame, in order, of all cells where both are sure (confidence 0.5).
inline std::vector<double> differences_to_regions(const Field &field,
                                                  const haptic::LumaView &before,
                                                  const haptic::LumaView &after) {
  std::vector<double> differences;
  for (int row = 0; row < field.shape.rows; ++row)
    for (int column = 0; column < field.shape.columns; ++column) {
      const haptic::FieldCell &cell = field.at(row, column);
      const auto region = region_at_cell(field, before, after, row, column);
      if (cell.confidence >= 0.5F && region.confidence >= 0.5F)
        differences.push_back(
            std::hypot(cell.velocity_x - region.velocity_x, cell.velocity_y - region.velocity_y));
    }
  std::ranges::sort(differences);
  return differences;
}

} // namespace test
