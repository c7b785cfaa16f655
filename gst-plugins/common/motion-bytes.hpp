// SPDX-License-Identifier: LGPL-2.1-or-later
// The bytes that motion samples and motion fields have in common (docs/formats/motion-sample.md).
#pragma once

#include "little-endian.hpp"

#include <array>
#include <cstdint>
#include <optional>

namespace haptic {

enum class MotionKind : std::uint8_t { point = 0, field = 1 };

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

/// `Motion` is MotionSample or MotionField.
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

} // namespace haptic
