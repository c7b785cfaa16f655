// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion field: the motion of one whole frame, as motionfield puts it into haptics/x-raw
// buffers.
#pragma once

#include "samples/field.hpp"
#include "samples/motion-sample.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

/// One buffer of these caps holds exactly one motion field. The caps may carry the same further
/// fields as HAPTIC_MOTION_CAPS.
#define HAPTIC_FIELD_CAPS "haptics/x-raw, modality=(string)velocity, layout=(string)field"

namespace haptic {

/// The motion in one cell, in px of the frame per second, x to the right and y down.
struct FieldCell {
  float velocity_x = 0; ///< px/s
  float velocity_y = 0; ///< px/s
  float confidence = 0; ///< 0..1; 0 means that nothing was measured, and the velocity is 0

  bool operator==(const FieldCell &) const = default;
};

using MotionField = Field<FieldCell>;

/// Bytes of each packed cell (docs/formats/motion-field.md).
inline constexpr std::size_t kFieldCellSize = 12;

constexpr std::size_t packed_size(const MotionField &field) noexcept {
  return kFieldHeaderSize + field.cells.size() * kFieldCellSize;
}

/// Writes packed_size(field) bytes, little-endian on every machine; there must be as many.
void pack_motion_field(const MotionField &field, std::span<std::uint8_t> bytes) noexcept;

/// Whether every number is finite and in its range. A reader refuses other fields.
bool is_valid(const MotionField &field) noexcept;

/// Returns false, with `field` in an unspecified state, if the bytes are not a field of this
/// version or a number is outside its range. Never reads beyond `bytes`. Allocates only if the
/// field has more cells than any before in `field`.
bool unpack_motion_field(std::span<const std::uint8_t> bytes, MotionField &field);

} // namespace haptic
