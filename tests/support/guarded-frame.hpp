// SPDX-License-Identifier: LGPL-2.1-or-later
// A frame whose surroundings may not be read.
#pragma once

#include "tracking/patch-tracker.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <sys/mman.h>
#include <unistd.h>
#include <utility>

namespace test {

/// A frame in the middle of memory that may not be touched.
class GuardedFrame {
public:
  GuardedFrame(int width, int height) : width_(width), height_(height) {
    page_ = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    rows_ = (static_cast<std::size_t>(width) + page_ - 1) / page_ * page_ + page_;
    size_ = rows_ * static_cast<std::size_t>(height) + page_;
    memory_ = static_cast<std::uint8_t *>(
        mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
  }
  ~GuardedFrame() { munmap(memory_, size_); }
  GuardedFrame(const GuardedFrame &) = delete;
  GuardedFrame &operator=(const GuardedFrame &) = delete;

  /// Each row ends (or begins) at a page that is protected.
  haptic::LumaView filled(const haptic::LumaView &from, bool ends) {
    const std::size_t inner = rows_ - page_;
    for (int y = 0; y < height_; ++y) {
      std::uint8_t *row = memory_ + page_ + static_cast<std::size_t>(y) * rows_;
      std::uint8_t *first = ends ? row + inner - width_ : row;
      std::copy_n(from.pixels + y * from.stride, width_, first);
      if (y == 0)
        first_ = first;
    }
    for (int y = 0; y <= height_; ++y)
      mprotect(memory_ + static_cast<std::size_t>(y) * rows_, page_, PROT_NONE);
    return {first_, width_, height_, static_cast<std::ptrdiff_t>(rows_)};
  }

private:
  int width_;
  int height_;
  std::size_t page_ = 0;
  std::size_t rows_ = 0;
  std::size_t size_ = 0;
  std::uint8_t *memory_ = nullptr;
  std::uint8_t *first_ = nullptr;
};

/// First pixel and length of a part of so many: one pixel, any length, or all; at either border or
/// anywhere.
inline std::pair<int, int> any_part(std::mt19937 &random, int length) {
  const auto between = [&](int least, int most) {
    return std::uniform_int_distribution(least, most)(random);
  };
  const int some = std::array{1, between(1, length), length}[between(0, 2)];
  const int rest = length - some;
  return {std::array{0, between(0, rest), rest}[between(0, 2)], some};
}

} // namespace test
