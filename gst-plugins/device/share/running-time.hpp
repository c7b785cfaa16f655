// SPDX-License-Identifier: LGPL-2.1-or-later
// The pipeline's running time from the monotonic clock.
#pragma once

#include "share/shared-value.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace haptic {

/// Threads of normal priority relate the two clocks (set()); the loop's thread reads (advance(),
/// at()).
class RunningTime {
public:
  /// `running` is the running time at `monotonic`, both ns.
  void set(std::int64_t monotonic, std::int64_t running) noexcept {
    const std::int64_t offset = monotonic - running;
    // Reading two clocks takes time, so that smaller differences mean nothing.
    if (std::abs(offset - offset_.load(std::memory_order_relaxed)) > kReadingError)
      offset_.store(offset, std::memory_order_relaxed);
  }

  /// Returns the time column of the log: running time at `monotonic`, s. Never decreases: where the
  /// running time itself starts again (a flushing seek), this one continues from its last value.
  double advance(std::int64_t monotonic) noexcept {
    const std::int64_t running = std::max<std::int64_t>(at(monotonic), 0);
    if (running + shift_ < last_ - kRestart)
      shift_ = last_ - running;
    last_ = std::max(last_, running + shift_);
    return last();
  }

  /// Returns the running time at `monotonic`, ns. It jumps where the pipeline's does.
  std::int64_t at(std::int64_t monotonic) const noexcept {
    return monotonic - offset_.load(std::memory_order_relaxed);
  }

  /// Returns the last result of advance().
  double last() const noexcept { return static_cast<double>(last_) * 1e-9; }

private:
  static constexpr std::int64_t kReadingError = 50'000; // ns
  static constexpr std::int64_t kRestart = 100'000'000; // ns

  SharedValue<std::int64_t> offset_ = 0; // ns, monotonic - running
  std::int64_t shift_ = 0;               // ns, the loop's
  std::int64_t last_ = 0;                // ns, the loop's
};

} // namespace haptic
