// SPDX-License-Identifier: LGPL-2.1-or-later
// Luma in memory, and a place in a frame.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace haptic {

/// Pixels of a frame, origin at its top left corner.
struct Rectangle {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool operator==(const Rectangle &) const = default;
};

/// What two rectangles share. If that is nothing, its width or height is 0 or less.
inline Rectangle intersection(const Rectangle &a, const Rectangle &b) {
  const int left = std::max(a.x, b.x);
  const int top = std::max(a.y, b.y);
  return {left, top, std::min(a.x + a.width, b.x + b.width) - left,
          std::min(a.y + a.height, b.y + b.height) - top};
}

/// Rows of 8-bit luma somewhere in memory; not owned.
struct LumaView {
  const std::uint8_t *pixels = nullptr;
  int width = 0;             ///< px
  int height = 0;            ///< px
  std::ptrdiff_t stride = 0; ///< bytes from row to row, may exceed the width
};

/// The pixels of an area that lies inside the view; its origin is the first pixel of the view.
inline LumaView part_of(const LumaView &view, const Rectangle &area) {
  return {view.pixels + area.y * view.stride + area.x, area.width, area.height, view.stride};
}

/// Largest mean squared residual of a patch that compression of a still scene leaves, grey levels
/// squared.
inline constexpr float kCompressionResidual2 = 40;

} // namespace haptic
