// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion-field.hpp"

#include "motion-bytes.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

bool is_valid(const FieldCell &cell) {
  return std::isfinite(cell.velocity_x) && std::isfinite(cell.velocity_y) && cell.confidence >= 0 &&
         cell.confidence <= 1;
}

} // namespace

bool is_valid(const MotionField &field) noexcept {
  const std::size_t cells = std::size_t{field.columns} * field.rows;
  return has_frame(field) && cells > 0 && cells <= kMostFieldCells && field.cells.size() == cells &&
         std::ranges::all_of(field.cells, [](const FieldCell &cell) { return is_valid(cell); });
}

void pack_motion_field(const MotionField &field, std::span<std::uint8_t> bytes) noexcept {
  LittleEndianWriter out(bytes);
  write_header(out, MotionKind::field, {field.flags, field.interval});
  write_frame(out, field);
  out.u16(field.columns);
  out.u16(field.rows);
  out.u32(0);
  for (const FieldCell &cell : field.cells)
    for (auto value : {cell.velocity_x, cell.velocity_y, cell.confidence})
      out.f32(value);
}

bool unpack_motion_field(std::span<const std::uint8_t> bytes, MotionField &field) {
  if (bytes.size() < kFieldHeaderSize)
    return false;
  LittleEndianReader in(bytes);
  const auto header = read_header(in, MotionKind::field);
  if (!header)
    return false;
  field.flags = header->flags;
  field.interval = header->interval;
  read_frame(in, field);
  field.columns = in.u16();
  field.rows = in.u16();
  in.u32();
  const std::size_t cells = std::size_t{field.columns} * field.rows;
  if (cells > kMostFieldCells || bytes.size() < kFieldHeaderSize + cells * kFieldCellSize)
    return false;
  field.cells.resize(cells);
  for (FieldCell &cell : field.cells)
    for (auto *value : {&cell.velocity_x, &cell.velocity_y, &cell.confidence})
      *value = in.f32();
  return is_valid(field);
}

} // namespace haptic
