// SPDX-License-Identifier: LGPL-2.1-or-later
// The clock of the loop, the session and the log. Tests make its time pass themselves.
#pragma once

#include <cstdint>
#include <stop_token>

namespace haptic {

/// Any thread.
class LoopClock {
public:
  LoopClock() = default;
  LoopClock(const LoopClock &) = delete;
  LoopClock &operator=(const LoopClock &) = delete;

  /// ns, monotonic, without the time that the machine slept. Real-time safe.
  virtual std::int64_t now() const noexcept = 0;
  /// ns, the same with the time that the machine slept. Real-time safe.
  virtual std::int64_t boot_time() const noexcept = 0;
  /// The loop sleeps. Real-time safe.
  virtual void sleep_until(std::int64_t when) noexcept = 0;
  /// Any other thread waits. It returns earlier if a stop is requested.
  virtual void wait_until(std::int64_t when, const std::stop_token &stop = {}) = 0;

protected:
  ~LoopClock() = default; // nobody owns a clock by its base
};

/// The clock of the machine. It lives as long as the program.
LoopClock &machine_clock() noexcept;

} // namespace haptic
