// SPDX-License-Identifier: LGPL-2.1-or-later
// A binary adaptive range coder: the likelier a bit, the less it costs.
//
// A bit with the probability p of being 0 splits the interval [low, low + range) at
// low + (range / 2^12) (2^12 p): 0 takes the lower part, 1 the upper one (G. N. N. Martin, "Range
// encoding", 1979). Bytes leave at the top as soon as no carry can reach them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace haptic {

/// The probability that the next bit of one kind is 0, learned from the bits before.
class BitModel {
public:
  static constexpr unsigned kBits = 12;

  /// `zeros` of 4096 bits are expected to be 0.
  constexpr BitModel() noexcept : BitModel(1U << (kBits - 1)) {}
  constexpr explicit BitModel(std::uint16_t zeros) noexcept : zeros_(zeros) {}

  std::uint32_t bound(std::uint32_t range) const noexcept { return (range >> kBits) * zeros_; }
  void learn(bool bit) noexcept {
    // p moves towards the bit by 1/8 at first and by 1/32 after six bits: the first p is a guess.
    const unsigned rate = seen_ < 6 ? 3U + (seen_ >> 1U) : 5U;
    seen_ = static_cast<std::uint8_t>(seen_ + (seen_ < 6));
    zeros_ = static_cast<std::uint16_t>(bit ? zeros_ - (zeros_ >> rate)
                                            : zeros_ + (((1U << kBits) - 1 - zeros_) >> rate));
  }

private:
  std::uint16_t zeros_; // of 1 << kBits
  std::uint8_t seen_ = 0;
};

class RangeEncoder {
public:
  void bit(BitModel &model, bool bit) {
    const std::uint32_t bound = model.bound(range_);
    if (bit) {
      low_ += bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.learn(bit);
    normalize();
  }
  /// Codes a bit that is as likely 0 as 1.
  void even_bit(bool bit) {
    range_ >>= 1;
    if (bit)
      low_ += range_;
    normalize();
  }
  /// Appends the coded bytes. Zeros at the end are left out, since a decoder reads zeros there.
  void finish(std::vector<std::uint8_t> &bytes) {
    // Any value in the interval will do. This one ends in the most zeros.
    for (unsigned shift = 32; shift-- > 0;) {
      const std::uint64_t mask = (std::uint64_t{1} << shift) - 1;
      const std::uint64_t value = (low_ + mask) & ~mask;
      if (value < low_ + range_) {
        low_ = value;
        break;
      }
    }
    for (int i = 0; i < 5; ++i)
      shift_low();
    // The first byte is always 0: it would take the carry of an interval that is above the first
    // one.
    std::size_t size = bytes_.size();
    while (size > 1 && bytes_[size - 1] == 0)
      --size;
    bytes.insert(bytes.end(), bytes_.begin() + 1,
                 bytes_.begin() + static_cast<std::ptrdiff_t>(size));
  }

private:
  void normalize() {
    while (range_ < 1U << 24) {
      range_ <<= 8;
      shift_low();
    }
  }
  // A byte that a carry can still reach waits, with all bytes 0xFF behind it.
  void shift_low() {
    if (low_ < 0xFF000000U || low_ > 0xFFFFFFFFU) {
      const auto carry = static_cast<std::uint8_t>(low_ >> 32);
      for (; waiting_ > 0; --waiting_) {
        bytes_.push_back(static_cast<std::uint8_t>(first_waiting_ + carry));
        first_waiting_ = 0xFF;
      }
      first_waiting_ = static_cast<std::uint8_t>(low_ >> 24);
    }
    ++waiting_;
    low_ = (low_ & 0x00FFFFFFU) << 8;
  }

  std::vector<std::uint8_t> bytes_;
  std::uint64_t low_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFU;
  std::size_t waiting_ = 1;
  std::uint8_t first_waiting_ = 0;
};

/// Decodes any bytes without failing. Behind their end it reads zeros.
class RangeDecoder {
public:
  explicit RangeDecoder(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {
    for (int i = 0; i < 4; ++i)
      code_ = code_ << 8 | next();
  }

  bool bit(BitModel &model) noexcept {
    const std::uint32_t bound = model.bound(range_);
    const bool bit = code_ >= bound;
    if (bit) {
      code_ -= bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.learn(bit);
    normalize();
    return bit;
  }
  bool even_bit() noexcept {
    range_ >>= 1;
    const bool bit = code_ >= range_;
    if (bit)
      code_ -= range_;
    normalize();
    return bit;
  }

private:
  void normalize() noexcept {
    while (range_ < 1U << 24) {
      range_ <<= 8;
      code_ = code_ << 8 | next();
    }
  }
  std::uint8_t next() noexcept { return at_ < bytes_.size() ? bytes_[at_++] : 0; }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  std::uint32_t range_ = 0xFFFFFFFFU;
  std::uint32_t code_ = 0;
};

} // namespace haptic
