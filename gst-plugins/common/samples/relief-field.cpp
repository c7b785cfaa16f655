// SPDX-License-Identifier: LGPL-2.1-or-later
#include "samples/relief-field.hpp"

#include "samples/motion-bytes.hpp"

namespace haptic {
namespace {

constexpr FieldBytes kBytes{MotionKind::relief, kReliefCellSize};

// False for a number that is not finite, too.
bool is_within(float value, float least, float most) {
  return value >= least && value <= most;
}

bool is_valid(const ReliefCell &cell) {
  return is_within(cell.height, -kMostReliefHeight, kMostReliefHeight) &&
         is_within(cell.stiffness, 0, kMostReliefStiffness) &&
         is_within(cell.friction, 0, kMostReliefFriction) && is_within(cell.validity, 0, 1);
}

} // namespace

bool is_valid(const ReliefField &field) noexcept {
  return is_field(field, [](const ReliefCell &cell) { return is_valid(cell); });
}

void pack_relief_field(const ReliefField &field, std::span<std::uint8_t> bytes) noexcept {
  pack_field(field, kBytes, bytes, [](LittleEndianWriter &out, const ReliefCell &cell) {
    for (auto value : {cell.height, cell.stiffness, cell.friction, cell.validity})
      out.f32(value);
  });
}

bool unpack_relief_field(std::span<const std::uint8_t> bytes, ReliefField &field) {
  return unpack_field(
             bytes, kBytes, field,
             [](LittleEndianReader &in, ReliefCell &cell) {
               for (auto *value : {&cell.height, &cell.stiffness, &cell.friction, &cell.validity})
                 *value = in.f32();
             }) &&
         is_valid(field);
}

} // namespace haptic
