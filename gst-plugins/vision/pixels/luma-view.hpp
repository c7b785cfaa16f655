// SPDX-License-Identifier: LGPL-2.1-or-later
// Luma in memory, and a place in a frame.
#pragma once

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

/// Rows of 8-bit luma somewhere in memory; not owned.
struct LumaView {
  const std::uint8_t *pixels = nullptr;
  int width = 0;             ///< px
  int height = 0;            ///< px
  std::ptrdiff_t stride = 0; ///< bytes from row to row, may exceed the width
};

/// Largest mean squared residual of a patch that compression of a still scene leaves, grey levels
/// squared.
inline constexpr float kCompressionResidual2 = 40;

} // namespace haptic
