// SPDX-License-Identifier: LGPL-2.1-or-later
// From a frame of colours to the relief of a grid of cells, by a table.
#pragma once

#include "relief/touch-table.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace haptic {

/// Red, green and blue of 8 bits each, somewhere in memory; not owned.
struct ColourView {
  std::array<const std::uint8_t *, 3> components = {}; ///< of the first pixel
  int width = 0;                                       ///< px
  int height = 0;                                      ///< px
  std::ptrdiff_t stride = 0;                           ///< bytes from row to row
  int pixel_size = 3;                                  ///< bytes
};

/// Fills the cells of `relief`, whose columns and rows are set. The colour of a cell is the mean of
/// the light of 25 of its pixels.
void make_colour_relief(const ColourView &frame, const TouchTable &table, ReliefField &relief);

} // namespace haptic
