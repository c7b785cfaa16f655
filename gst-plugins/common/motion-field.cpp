// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion-field.hpp"

#include "little-endian.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

constexpr std::array<std::uint8_t, 4> kMagic = {'H', 'M', 'S', 'P'};
constexpr std::uint8_t kVersion = 1;
constexpr std::uint8_t kKindField = 1;

bool is_valid(const FieldCell &cell) {
  return std::isfinite(cell.velocity_x) && std::isfinite(cell.velocity_y) && cell.confidence >= 0 &&
         cell.confidence <= 1;
}

} // namespace

bool is_valid(const MotionField &field) noexcept {
  const std::size_t cells = std::size_t{field.columns} * field.rows;
  return field.frame_width > 0 && field.frame_height > 0 && field.pixel_aspect_n > 0 &&
         field.pixel_aspect_d > 0 && cells > 0 && cells <= kMostFieldCells &&
         field.cells.size() == cells &&
         std::ranges::all_of(field.cells, [](const FieldCell &cell) { return is_valid(cell); });
}

void pack_motion_field(const MotionField &field, std::span<std::uint8_t> bytes) noexcept {
  LittleEndianWriter out(bytes);
  for (auto letter : kMagic)
    out.u8(letter);
  out.u8(kVersion);
  out.u8(kKindField);
  out.u16(field.flags);
  out.u64(field.interval);
  for (auto value :
       {field.frame_width, field.frame_height, field.pixel_aspect_n, field.pixel_aspect_d})
    out.u32(value);
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
  for (auto letter : kMagic)
    if (in.u8() != letter)
      return false;
  if (in.u8() != kVersion || in.u8() != kKindField)
    return false;
  field.flags = in.u16();
  field.interval = in.u64();
  for (auto *value :
       {&field.frame_width, &field.frame_height, &field.pixel_aspect_n, &field.pixel_aspect_d})
    *value = in.u32();
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
