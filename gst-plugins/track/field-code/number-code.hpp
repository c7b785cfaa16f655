// SPDX-License-Identifier: LGPL-2.1-or-later
// Whole numbers as bits of the range coder.
#pragma once

#include "field-code/range-coder.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

namespace haptic {

/// The bits of one kind of number: whether it is 0, its sign, then its size as Exp-Golomb code.
/// `kLengths`: the most bits of a number.
template <std::size_t kLengths>
struct NumberModel {
  BitModel zero{2048};
  BitModel sign;
  std::array<BitModel, kLengths> longer;
  std::array<BitModel, 2> first_bit;
};

// An Encoder or a Decoder is the `code` of the functions below, so that both directions share them:
// a call gets the bit to be written and returns the bit that was written or read.
class Encoder {
public:
  bool bit(BitModel &model, bool bit) { return out_.bit(model, bit), bit; }
  bool even_bit(bool bit) { return out_.even_bit(bit), bit; }
  void finish(std::vector<std::uint8_t> &bytes) { out_.finish(bytes); }

private:
  RangeEncoder out_;
};

class Decoder {
public:
  explicit Decoder(std::span<const std::uint8_t> bytes) : in_(bytes) {}
  bool bit(BitModel &model, bool) { return in_.bit(model); }
  bool even_bit(bool) { return in_.even_bit(); }

private:
  RangeDecoder in_;
};

template <typename Code, std::size_t kLengths>
int code_number(Code &code, NumberModel<kLengths> &model, int number) {
  if (code.bit(model.zero, number == 0))
    return 0;
  const bool negative = code.bit(model.sign, number < 0);
  const auto size = static_cast<unsigned>(std::abs(number)); // from 1
  unsigned length = 0;
  while (length + 1 < kLengths &&
         code.bit(model.longer[length], static_cast<unsigned>(std::bit_width(size)) > length + 1))
    ++length;
  unsigned read = 1;
  for (unsigned i = length; i-- > 0;) {
    const bool wanted = size >> i & 1;
    const bool bit =
        i + 1 == length ? code.bit(model.first_bit[length > 1], wanted) : code.even_bit(wanted);
    read = read << 1 | unsigned{bit};
  }
  return negative ? -static_cast<int>(read) : static_cast<int>(read);
}

} // namespace haptic
