// SPDX-License-Identifier: LGPL-2.1-or-later
// Passes the newest value from one thread to another; older ones are lost. Neither side waits.
#pragma once

#include "share/shared-value.hpp"

#include <array>
#include <cstdint>

namespace haptic {

/// A triple buffer. One writer at a time and one reader at a time (writers that are several threads
/// take turns under a lock of their own). Real-time safe on both sides if copying T is.
template <typename T>
class NewestSlot {
public:
  /// The writer's side.
  void write(const T &value) noexcept {
    cells_[back_].value = value;
    back_ = middle_.exchange(static_cast<std::uint8_t>(back_ | kFresh), std::memory_order_acq_rel) &
            kIndex;
  }

  /// The reader's side: returns true if a value was written since the last call.
  bool refresh() noexcept {
    if (!(middle_.load(std::memory_order_relaxed) & kFresh))
      return false;
    front_ = middle_.exchange(front_, std::memory_order_acq_rel) & kIndex;
    return true;
  }

  /// The reader's side: returns the value of the last refresh().
  const T &value() const noexcept { return cells_[front_].value; }

private:
  static constexpr std::uint8_t kFresh = 4;
  static constexpr std::uint8_t kIndex = 3;
  static constexpr std::size_t kCacheLine = 64;

  struct alignas(kCacheLine) Cell {
    T value{};
  };
  std::array<Cell, 3> cells_;
  alignas(kCacheLine) std::uint8_t back_ = 0;                // writer
  alignas(kCacheLine) SharedValue<std::uint8_t> middle_ = 1; // both
  alignas(kCacheLine) std::uint8_t front_ = 2;               // reader
};

} // namespace haptic
