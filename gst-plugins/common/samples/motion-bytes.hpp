// SPDX-License-Identifier: LGPL-2.1-or-later
// The bytes that motion samples, motion fields and reliefs have in common
// (docs/formats/motion-sample.md, docs/formats/motion-field.md).
#pragma once

#include "samples/field.hpp"
#include "samples/little-endian.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace haptic {

enum class MotionKind : std::uint8_t { point = 0, field = 1, relief = 2 };

/// The first 16 bytes.
struct MotionHeader {
  std::uint16_t flags = 0;
  std::uint64_t interval = 0; ///< ns
};
inline constexpr std::size_t kMotionHeaderSize = 16;

inline constexpr std::array<std::uint8_t, 4> kMotionMagic = {'H', 'M', 'S', 'P'};
inline constexpr std::uint8_t kMotionVersion = 1;

inline void write_header(LittleEndianWriter &out, MotionKind kind, const MotionHeader &header) {
  for (auto letter : kMotionMagic)
    out.u8(letter);
  out.u8(kMotionVersion);
  out.u8(static_cast<std::uint8_t>(kind));
  out.u16(header.flags);
  out.u64(header.interval);
}

/// Nothing, if the bytes begin another kind or version. There must be kMotionHeaderSize of them.
inline std::optional<MotionHeader> read_header(LittleEndianReader &in, MotionKind kind) {
  for (auto letter : kMotionMagic)
    if (in.u8() != letter)
      return std::nullopt;
  if (in.u8() != kMotionVersion || in.u8() != static_cast<std::uint8_t>(kind))
    return std::nullopt;
  const std::uint16_t flags = in.u16();
  return MotionHeader{flags, in.u64()};
}

/// `Motion` is MotionSample or a Field.
template <typename Motion>
void write_frame(LittleEndianWriter &out, const Motion &motion) {
  for (auto value :
       {motion.frame_width, motion.frame_height, motion.pixel_aspect_n, motion.pixel_aspect_d})
    out.u32(value);
}

template <typename Motion>
void read_frame(LittleEndianReader &in, Motion &motion) {
  for (auto *value :
       {&motion.frame_width, &motion.frame_height, &motion.pixel_aspect_n, &motion.pixel_aspect_d})
    *value = in.u32();
}

template <typename Motion>
bool has_frame(const Motion &motion) {
  return motion.frame_width > 0 && motion.frame_height > 0 && motion.pixel_aspect_n > 0 &&
         motion.pixel_aspect_d > 0;
}

struct FieldBytes {
  MotionKind kind;
  std::size_t cell_size;
};

/// Whether frame and shape are possible and `is_valid_cell` is true for each cell.
template <typename Cell, typename IsValidCell>
bool is_field(const Field<Cell> &field, IsValidCell is_valid_cell) {
  const std::size_t cells = std::size_t{field.columns} * field.rows;
  return has_frame(field) && cells > 0 && cells <= kMostFieldCells && field.cells.size() == cells &&
         std::ranges::all_of(field.cells, is_valid_cell);
}

/// There must be kFieldHeaderSize + cells * cell_size bytes. `write_cell` writes one cell.
template <typename Cell, typename WriteCell>
void pack_field(const Field<Cell> &field, const FieldBytes &form, std::span<std::uint8_t> bytes,
                WriteCell write_cell) {
  LittleEndianWriter out(bytes);
  write_header(out, form.kind, {field.flags, field.interval});
  write_frame(out, field);
  out.u16(field.columns);
  out.u16(field.rows);
  out.u32(0);
  for (const Cell &cell : field.cells)
    write_cell(out, cell);
}

/// Returns false if there are too few bytes or they begin something else. `read_cell` reads one
/// cell. The caller checks the numbers.
template <typename Cell, typename ReadCell>
bool unpack_field(std::span<const std::uint8_t> bytes, const FieldBytes &form, Field<Cell> &field,
                  ReadCell read_cell) {
  if (bytes.size() < kFieldHeaderSize)
    return false;
  LittleEndianReader in(bytes);
  const auto header = read_header(in, form.kind);
  if (!header)
    return false;
  field.flags = header->flags;
  field.interval = header->interval;
  read_frame(in, field);
  field.columns = in.u16();
  field.rows = in.u16();
  in.u32();
  const std::size_t cells = std::size_t{field.columns} * field.rows;
  if (cells > kMostFieldCells || bytes.size() < kFieldHeaderSize + cells * form.cell_size)
    return false;
  field.cells.resize(cells);
  for (Cell &cell : field.cells)
    read_cell(in, cell);
  return true;
}

} // namespace haptic
