// SPDX-License-Identifier: LGPL-2.1-or-later
// Random numbers that are the same on every machine: the C++ standard specifies the generators but
// not the distributions' algorithms.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

namespace lab {

class Random {
public:
  explicit Random(std::uint64_t seed) : generator_(seed) {}

  std::uint64_t bits() { return generator_(); }

  /// Uniform in 0..end-1; the bias of the remainder is below 1e-12 for the small numbers in use.
  std::size_t index(std::size_t end) { return static_cast<std::size_t>(bits() % end); }

  double uniform(double from, double to) {
    return from + (to - from) * static_cast<double>(bits() >> 11) * 0x1p-53;
  }

  /// Standard normal, after Box and Muller.
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2 * std::log(1 - uniform(0, 1)));
    const double angle = uniform(0, 2 * std::numbers::pi);
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

private:
  std::mt19937_64 generator_;
  double spare_ = 0;
  bool has_spare_ = false;
};

} // namespace lab
