// SPDX-License-Identifier: LGPL-2.1-or-later
// Writes and reads numbers as little-endian bytes on every machine. The caller must have checked
// that there are enough bytes.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace haptic {

class LittleEndianWriter {
public:
  explicit LittleEndianWriter(std::span<std::uint8_t> bytes) : bytes_(bytes) {}
  void u8(std::uint8_t value) { bytes_[at_++] = value; }
  void u16(std::uint16_t value) { little_endian(value, 2); }
  void u32(std::uint32_t value) { little_endian(value, 4); }
  void u64(std::uint64_t value) { little_endian(value, 8); }
  void f32(float value) { u32(std::bit_cast<std::uint32_t>(value)); }

private:
  void little_endian(std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i)
      u8(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

class LittleEndianReader {
public:
  explicit LittleEndianReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::uint8_t u8() { return bytes_[at_++]; }
  std::uint16_t u16() { return static_cast<std::uint16_t>(little_endian(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(little_endian(4)); }
  std::uint64_t u64() { return little_endian(8); }
  float f32() { return std::bit_cast<float>(u32()); }

private:
  std::uint64_t little_endian(int count) {
    std::uint64_t value = 0;
    for (int i = 0; i < count; ++i)
      value |= std::uint64_t{u8()} << (8 * i);
    return value;
  }
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

} // namespace haptic
