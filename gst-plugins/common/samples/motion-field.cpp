// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/motion-field.hpp"

#include "samples/motion-bytes.hpp"

#include <cmath>

namespace haptic {
namespace {

constexpr FieldBytes kBytes{MotionKind::field, kFieldCellSize};

bool is_valid(const FieldCell &cell) {
  return std::isfinite(cell.velocity_x) && std::isfinite(cell.velocity_y) && cell.confidence >= 0 &&
         cell.confidence <= 1;
}

} // namespace

bool is_valid(const MotionField &field) noexcept {
  return is_field(field, [](const FieldCell &cell) { return is_valid(cell); });
}

void pack_motion_field(const MotionField &field, std::span<std::uint8_t> bytes) noexcept {
  pack_field(field, kBytes, bytes, [](LittleEndianWriter &out, const FieldCell &cell) {
    for (auto value : {cell.velocity_x, cell.velocity_y, cell.confidence})
      out.f32(value);
  });
}

bool unpack_motion_field(std::span<const std::uint8_t> bytes, MotionField &field) {
  return unpack_field(bytes, kBytes, field,
                      [](LittleEndianReader &in, FieldCell &cell) {
                        for (auto *value : {&cell.velocity_x, &cell.velocity_y, &cell.confidence})
                          *value = in.f32();
                      }) &&
         is_valid(field);
}

} // namespace haptic
