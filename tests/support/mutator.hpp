// SPDX-License-Identifier: LGPL-2.1-or-later
// Damages bytes, always in the same way for each seed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace test {

using Bytes = std::vector<std::uint8_t>;

class Mutator {
public:
  explicit Mutator(unsigned seed) : state_(seed * 2654435761U + 1) {}

  std::uint32_t number() { // xorshift: the mutations must not cost more than the parsers
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return static_cast<std::uint32_t>(state_ >> 16);
  }
  std::size_t below(std::size_t limit) { return limit == 0 ? 0 : number() % limit; }

  void mutate(Bytes &bytes, std::span<const Bytes> seeds) {
    constexpr std::array<std::uint8_t, 9> kTelling = {0, 1, 0x7F, 0x80, 0xFF, 0x82, '0', '"', '['};
    for (auto times = 1 + below(4); times > 0; --times) {
      const std::size_t at = below(bytes.size());
      const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
      switch (bytes.empty() ? 4U : number() % 7) {
      case 0:
        bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ 1U << below(8));
        break;
      case 1:
        bytes[at] = static_cast<std::uint8_t>(number());
        break;
      case 2:
        bytes[at] = kTelling[below(kTelling.size())];
        break;
      case 3:
        bytes.resize(at);
        break;
      case 4: { // another one from there on
        const Bytes &other = seeds[below(seeds.size())];
        const auto from = static_cast<std::ptrdiff_t>(below(other.size()));
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), other.begin() + from,
                     other.end());
        break;
      }
      case 5:
        bytes.erase(place, place + static_cast<std::ptrdiff_t>(1 + below(bytes.size() - at)));
        break;
      default:
        bytes.insert(place, static_cast<std::uint8_t>(number()));
        break;
      }
    }
  }

private:
  std::uint64_t state_;
};

} // namespace test
