// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usb/usb-protocol.hpp"

namespace spidar {

namespace {

template <std::size_t Size>
void put_words(std::array<std::uint8_t, Size> &packet, std::size_t offset,
               const DacWords &words) noexcept {
  static_assert(Size >= 2 * kStrings);
  for (std::size_t i = 0; i < kStrings; ++i) {
    const auto word = static_cast<std::uint16_t>(words[i]);
    packet[offset + 2 * i] = static_cast<std::uint8_t>(word & 0xff);
    packet[offset + 2 * i + 1] = static_cast<std::uint8_t>(word >> 8);
  }
}

std::uint32_t number(std::span<const std::uint8_t> bytes) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;)
    value = value << 8 | bytes[i];
  return value;
}

Reply reply(std::span<const std::uint8_t> counters, std::size_t width,
            std::uint8_t switches) noexcept {
  Reply result;
  for (std::size_t i = 0; i < kStrings; ++i)
    result.counters[i] = number(counters.subspan(i * width, width));
  result.rotary_switch = switches >> 4;
  result.inputs = switches & 0xf;
  return result;
}

} // namespace

namespace simple {

Packet count_direction() noexcept {
  return {0xa2, 0x1a, 0xff};
}

Packet clear_counters() noexcept {
  return {0xa2, 0x19, 0xff};
}

Packet set_dac(const DacWords &words) noexcept {
  Packet packet{0x52};
  put_words(packet, 1, words);
  return packet;
}

Packet latch_counters() noexcept {
  return {0x51};
}

std::optional<Reply> parse(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() != kPacket)
    return std::nullopt;
  return reply(bytes.first(3 * kStrings), 3, bytes[24]);
}

} // namespace simple

namespace sh4 {

Packet update(const DacWords &words) noexcept {
  Packet packet{0x01, 0x0e};
  put_words(packet, 2, words);
  return packet;
}

std::optional<Reply> parse(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.size() != kPacket)
    return std::nullopt;
  Reply result = reply(bytes.subspan(16, 2 * kStrings), 2, bytes[48]);
  result.inputs = static_cast<std::uint16_t>(result.inputs | bytes[49] << 8);
  for (std::uint32_t &counter : result.counters)
    counter = (0x10000 - counter) & 0xffff;
  return result;
}

} // namespace sh4

std::int32_t extended(std::int32_t before, std::uint32_t counter, int bits) noexcept {
  const std::uint32_t range = 1U << bits;
  const std::uint32_t ahead = (counter - static_cast<std::uint32_t>(before)) & (range - 1);
  const std::uint32_t change = ahead < range / 2 ? ahead : ahead - range;
  // Unsigned, so that after years of turning one way it wraps instead of being undefined.
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(before) + change);
}

} // namespace spidar
