// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers with the most significant byte first, as MPEG has them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace haptic {

/// Appends a number of `size` bytes.
inline void put_number(std::vector<std::uint8_t> &bytes, std::uint64_t number, unsigned size) {
  for (unsigned i = size; i-- > 0;)
    bytes.push_back(static_cast<std::uint8_t>(number >> (8 * i)));
}

/// Reads a number of `size` bytes at `at`, which moves behind it; of as many as there are.
inline std::uint32_t read_number(std::span<const std::uint8_t> bytes, std::size_t &at,
                                 std::size_t size) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < size && at < bytes.size(); ++i)
    number = number << 8 | bytes[at++];
  return number;
}

/// Returns what stands behind a length of `size` bytes, as much as there is. `at` moves behind it.
inline std::span<const std::uint8_t> read_unit(std::span<const std::uint8_t> bytes, std::size_t &at,
                                               std::size_t size) {
  const std::size_t length = read_number(bytes, at, size);
  const auto unit = bytes.subspan(at, std::min(length, bytes.size() - at));
  at += unit.size();
  return unit;
}

} // namespace haptic
