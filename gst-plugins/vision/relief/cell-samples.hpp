// SPDX-License-Identifier: LGPL-2.1-or-later
// Which pixels of a frame are read for the cells of a grid.
#pragma once

#include <cstdint>

namespace haptic {

/// Pixels of a cell along each side.
inline constexpr int kCellSamples = 5;

/// The pixel in the centre of part `i` of `count` equal parts of `length` pixels.
constexpr int centre_of_part(int i, int count, int length) {
  return static_cast<int>((2 * std::int64_t{i} + 1) * length / (2 * std::int64_t{count}));
}

} // namespace haptic
