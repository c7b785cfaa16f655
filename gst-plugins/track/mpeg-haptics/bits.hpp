// SPDX-License-Identifier: LGPL-2.1-or-later
// Big-endian bit fields, most significant bit first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace haptic {

class BitWriter {
public:
  /// Writes the low `count` bits of the value, at most 32.
  void put(std::uint64_t value, unsigned count) {
    while (count-- > 0) {
      if (used_ % 8 == 0)
        bytes_.push_back(0);
      if (value >> count & 1)
        bytes_.back() = static_cast<std::uint8_t>(bytes_.back() | 0x80U >> used_ % 8);
      ++used_;
    }
  }
  /// Writes one byte of length, then the text, of which only the first 255 bytes count.
  void text(std::string_view text) {
    text = text.substr(0, 255);
    put(text.size(), 8);
    for (const char c : text)
      put(static_cast<std::uint8_t>(c), 8);
  }
  const std::vector<std::uint8_t> &bytes() const noexcept { return bytes_; }

private:
  std::vector<std::uint8_t> bytes_;
  std::size_t used_ = 0; // bits
};

/// Reading beyond the end gives zeros and makes failed() true.
class BitReader {
public:
  explicit BitReader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  std::uint32_t get(unsigned count) noexcept {
    std::uint32_t value = 0;
    if (count > left()) {
      failed_ = true;
      used_ = bytes_.size() * 8;
      return 0;
    }
    for (; count > 0; --count, ++used_)
      value = value << 1 | (bytes_[used_ / 8] >> (7 - used_ % 8) & 1U);
    return value;
  }
  std::string text() {
    std::string text;
    for (auto length = get(8); length > 0 && !failed_; --length)
      text.push_back(static_cast<char>(get(8)));
    return text;
  }
  std::size_t left() const noexcept { return bytes_.size() * 8 - used_; } ///< bits
  std::size_t byte() const noexcept { return used_ / 8; }
  bool failed() const noexcept { return failed_; }

private:
  std::span<const std::uint8_t> bytes_;
  std::size_t used_ = 0; // bits
  bool failed_ = false;
};

} // namespace haptic
