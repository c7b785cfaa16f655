// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patches/patch-grid.hpp"

namespace haptic {
namespace {

// Column or row of the first pixel of a patch, clamped so that gradients and interpolation stay
// inside the plane.
int first_pixel(float from, float length, int index, int parts, int side, int available) {
  const float centre =
      from + (static_cast<float>(index) + 0.5F) * length / static_cast<float>(parts);
  return std::clamp(static_cast<int>(std::floor(centre - 0.5F * static_cast<float>(side))), 1,
                    available - side - 2);
}

} // namespace

void PatchGrid::cover(const Plane &plane, const Area &area, int wanted_columns, int wanted_rows,
                      int side, bool dither) {
  columns = std::clamp(wanted_columns, 1, kMostAlong);
  rows = std::clamp(wanted_rows, 1, kMostAlong);
  if (const std::size_t wanted = cell(rows, columns, 0); patches.size() < wanted)
    patches.resize(wanted);
  for_places(*this, [&](int row, int column) {
    // Interpolation draws displacements towards whole pixels. Neighbours are sampled a quarter
    // and three quarters of a pixel off the raster, so that their errors cancel.
    const float off_raster = !dither ? 0 : ((row + column) & 1) == 0 ? 0.25F : 0.75F;
    const auto first = [&](float from, float length, int index, int parts, int available) {
      return static_cast<float>(first_pixel(from, length, index, parts, side, available)) +
             off_raster;
    };
    Template &patch = patches[cell(row, columns, column)];
    patch.side = side;
    patch.x = first(area.x, area.width, column, columns, plane.width());
    patch.y = first(area.y, area.height, row, rows, plane.height());
  });
  prepare_templates(plane, view());
}

} // namespace haptic
