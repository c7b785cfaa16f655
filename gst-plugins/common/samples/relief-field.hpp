// SPDX-License-Identifier: LGPL-2.1-or-later
// The relief: the surface of one whole frame that a hand can touch, as depthfield and reliefmap
// make it.
#pragma once

#include "samples/field.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

/// One buffer of these caps holds exactly one relief. The caps may carry width, height,
/// pixel-aspect-ratio and framerate of the frame.
#define HAPTIC_RELIEF_CAPS "haptics/x-field, kind=(string)relief"

namespace haptic {

/// Limits of a cell's numbers. A reader refuses others.
inline constexpr float kMostReliefHeight = 1;       ///< m, above and below the plane z = 0
inline constexpr float kMostReliefStiffness = 1e5F; ///< N/m
inline constexpr float kMostReliefFriction = 10;    ///< Coulomb coefficient

/// The surface at the centre of one cell. Between the centres it is bilinear; outside the outer
/// ones it goes on as it is there.
struct ReliefCell {
  float height = 0;    ///< m, towards the user, above the plane z = 0 of the device's workspace
  float stiffness = 0; ///< N/m, >= 0
  float friction = 0;  ///< Coulomb coefficient, >= 0
  float validity = 0;  ///< 0..1; 0 means that there is no surface, and the other numbers are 0

  bool operator==(const ReliefCell &) const = default;
};

/// `flags` of kFrameFlags.
using ReliefField = Field<ReliefCell>;

/// Bytes of each packed cell (docs/formats/relief-field.md).
inline constexpr std::size_t kReliefCellSize = 16;

constexpr std::size_t packed_size(const ReliefField &field) noexcept {
  return kFieldHeaderSize + field.cells.size() * kReliefCellSize;
}

/// Writes packed_size(field) bytes, little-endian on every machine; there must be as many.
void pack_relief_field(const ReliefField &field, std::span<std::uint8_t> bytes) noexcept;

/// Whether every number is finite and in its range. A reader refuses other reliefs.
bool is_valid(const ReliefField &field) noexcept;

/// Returns false, with `field` in an unspecified state, if the bytes are not a relief of this
/// version or a number is outside its range. Never reads beyond `bytes`. Allocates only if the
/// relief has more cells than any before in `field`.
bool unpack_relief_field(std::span<const std::uint8_t> bytes, ReliefField &field);

} // namespace haptic
