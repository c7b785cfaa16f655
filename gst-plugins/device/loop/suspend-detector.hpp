// SPDX-License-Identifier: LGPL-2.1-or-later
// Detects that the machine slept: the clock that counts sleep is ahead of the one that does not.
#pragma once

#include <cstdint>

namespace haptic {

/// One thread; real-time safe.
class SuspendDetector {
public:
  /// Returns true once after each sleep. `monotonic` and `boottime` are CLOCK_MONOTONIC and
  /// CLOCK_BOOTTIME, ns, read one right after the other.
  bool has_slept(std::int64_t monotonic, std::int64_t boottime) noexcept {
    const std::int64_t asleep = boottime - monotonic;
    const bool slept = known_ && asleep - asleep_ > kShortestSleep;
    // Follows only downwards: a delay between the two readings must not hide a later sleep.
    if (!known_ || slept || asleep < asleep_)
      asleep_ = asleep;
    known_ = true;
    return slept;
  }

private:
  static constexpr std::int64_t kShortestSleep = 500'000'000; // ns; more than any hold-up

  std::int64_t asleep_ = 0; // ns
  bool known_ = false;
};

} // namespace haptic
