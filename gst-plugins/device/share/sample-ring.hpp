// SPDX-License-Identifier: LGPL-2.1-or-later
// Passes every value from one thread to another, in order. Neither side waits.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <utility>

namespace haptic {

/// One writer at a time, one reader. Real-time safe on both sides if moving T is.
template <typename T, std::size_t kSize>
class SampleRing {
public:
  /// The writer's side: returns false, and the value is lost, if the reader is kSize values behind.
  bool push(T value) noexcept {
    const std::size_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) >= kSize)
      return false;
    values_[written % kSize] = std::move(value);
    written_.store(written + 1, std::memory_order_release);
    return true;
  }

  /// The reader's side: returns false if there is no value.
  bool pop(T &value) noexcept {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (read == written_.load(std::memory_order_acquire))
      return false;
    value = std::move(values_[read % kSize]);
    read_.store(read + 1, std::memory_order_release);
    return true;
  }

private:
  static constexpr std::size_t kCacheLine = 64;

  std::array<T, kSize> values_{};
  alignas(kCacheLine) std::atomic<std::size_t> written_ = 0; // by the writer
  alignas(kCacheLine) std::atomic<std::size_t> read_ = 0;    // by the reader
};

} // namespace haptic
