// SPDX-License-Identifier: LGPL-2.1-or-later
// What motion fields and reliefs have in common: numbers for each cell of a grid over the whole
// frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace haptic {

/// The most cells of a field. Readers refuse more, so that their memory is bounded.
inline constexpr std::size_t kMostFieldCells = 8192;

/// Columns of a field unless a user wants others.
inline constexpr int kFieldColumns = 32;

/// Cells of equal size, side by side over the whole frame.
struct FieldShape {
  int columns = 0;
  int rows = 0;

  int cells() const { return columns * rows; }
  bool operator==(const FieldShape &) const = default;
};

/// `columns` columns, or as many as leave each at least 8 px wide, and rows such that the cells are
/// as square on the screen as they can be; no more than kMostFieldCells cells. `pixel_aspect`:
/// width of a pixel over its height.
FieldShape field_shape(int width, int height, double pixel_aspect, int columns) noexcept;

/// Cells of equal size, side by side over the whole frame, row by row from its top left.
template <typename Cell>
struct Field {
  std::uint64_t interval = 0;       ///< ns between the two frames, 0 when there is none
  std::uint32_t frame_width = 0;    ///< px
  std::uint32_t frame_height = 0;   ///< px
  std::uint32_t pixel_aspect_n = 1; ///< pixel width : height
  std::uint32_t pixel_aspect_d = 1;
  std::uint16_t flags = 0; ///< of kFrameFlags
  std::uint16_t columns = 0;
  std::uint16_t rows = 0;
  std::vector<Cell> cells; ///< columns * rows

  bool operator==(const Field &) const = default;
};

/// Bytes of a packed field before its cells (docs/formats/motion-field.md).
inline constexpr std::size_t kFieldHeaderSize = 40;

} // namespace haptic
