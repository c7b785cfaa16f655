// SPDX-License-Identifier: LGPL-2.1-or-later
// Builds and parses the packets of the USB controllers: pure functions of bytes, real-time safe.
//
// "USB2.0 Simple" (0cec:0203): 32-byte packets; 24-bit counters that count as the geometry says.
// "USB2.0 SH4" (0cec:0205): 512-byte packets, one exchange does all; 16-bit counters that count the
// other way round. All numbers are little-endian.
#pragma once

#include "spidar/types.hpp"

#include <optional>
#include <span>

namespace spidar {

inline constexpr std::uint16_t kVendor = 0x0cec;
inline constexpr std::uint16_t kH8Product = 0x0201; ///< protocol unknown
inline constexpr std::uint16_t kSimpleProduct = 0x0203;
inline constexpr std::uint16_t kSh4Product = 0x0205;
inline constexpr unsigned char kEndpointOut = 0x02;
inline constexpr unsigned char kEndpointIn = 0x86;

/// Content of a reply: counters in their width on the wire, the rotary switch and the input pins.
struct Reply {
  std::array<std::uint32_t, kStrings> counters{};
  int rotary_switch = 0;    ///< 0..15
  std::uint16_t inputs = 0; ///< Controller::inputs()
};

namespace simple {
inline constexpr std::size_t kPacket = 32;
inline constexpr int kCounterBits = 24;
using Packet = std::array<std::uint8_t, kPacket>;

Packet count_direction() noexcept; ///< of all encoders, as the geometry's signs expect
Packet clear_counters() noexcept;
Packet set_dac(const DacWords &words) noexcept;
Packet latch_counters() noexcept; ///< answered by one reply
std::optional<Reply> parse(std::span<const std::uint8_t> bytes) noexcept;
} // namespace simple

namespace sh4 {
inline constexpr std::size_t kPacket = 512;
inline constexpr int kCounterBits = 16;
using Packet = std::array<std::uint8_t, kPacket>;

Packet update(const DacWords &words) noexcept; ///< answered by one reply
std::optional<Reply> parse(std::span<const std::uint8_t> bytes) noexcept;
} // namespace sh4

/// The count nearest to `before` whose lowest `bits` are those of `counter`: right as long as the
/// counter moved less than half its range in between.
std::int32_t extended(std::int32_t before, std::uint32_t counter, int bits) noexcept;

} // namespace spidar
