// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion field: the motion of one whole frame, as motionfield puts it into haptics/x-raw
// buffers.
#pragma once

#include "samples/field.hpp"
#include "samples/held-place.hpp"
#include "samples/motion-sample.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

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

/// Where a thing is that was followed when the field was made, so that whoever presses there holds
/// it. Places are in steps of 1/65535 once they were packed.
struct FieldThing {
  std::uint16_t id = 0;              ///< of no other thing in this field or one near it
  HoldState state = HoldState::held; ///< held, about or hidden
  float x = 0;                       ///< 0..1 of the width
  float y = 0;                       ///< 0..1 of the height
  float radius = 0;                  ///< fraction of the width, 0..1

  bool operator==(const FieldThing &) const = default;
};

/// The most things of a field.
inline constexpr std::size_t kMostFieldThings = 32;

struct MotionField : Field<FieldCell> {
  std::vector<FieldThing> things;

  bool operator==(const MotionField &) const = default;
};

/// Bytes of each packed cell (docs/formats/motion-field.md).
inline constexpr std::size_t kFieldCellSize = 12;

inline constexpr std::size_t kThingsHeader = 4;
inline constexpr std::size_t kThingSize = 12;

/// Bytes of the packed things, 0 if there is none.
constexpr std::size_t packed_size(std::span<const FieldThing> things) noexcept {
  return things.empty() ? 0 : kThingsHeader + things.size() * kThingSize;
}

constexpr std::size_t packed_size(const MotionField &field) noexcept {
  return kFieldHeaderSize + field.cells.size() * kFieldCellSize + packed_size(field.things);
}

/// Writes packed_size(things) bytes; there must be as many.
void pack_field_things(std::span<const FieldThing> things, std::span<std::uint8_t> bytes) noexcept;

/// Whether the bytes begin with things of which every number is in its range. No bytes: no things.
bool are_field_things(std::span<const std::uint8_t> bytes) noexcept;

/// Returns false, without things, if the bytes are none (are_field_things()). Allocates only for
/// more things than any before.
bool unpack_field_things(std::span<const std::uint8_t> bytes, std::vector<FieldThing> &things);

/// Writes packed_size(field) bytes, little-endian on every machine; there must be as many.
void pack_motion_field(const MotionField &field, std::span<std::uint8_t> bytes) noexcept;

/// Whether every number is finite and in its range. A reader refuses other fields.
bool is_valid(const MotionField &field) noexcept;

/// Returns false, with `field` in an unspecified state, if the bytes are not a field of this
/// version or a number is outside its range. Never reads beyond `bytes`. Allocates only if the
/// field has more cells or things than any before in `field`.
bool unpack_motion_field(std::span<const std::uint8_t> bytes, MotionField &field);

} // namespace haptic
