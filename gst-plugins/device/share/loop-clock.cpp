// SPDX-License-Identifier: LGPL-2.1-or-later
#include "share/loop-clock.hpp"

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <mutex>
#include <spidar/haptic-device.hpp>

namespace haptic {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000; // ns

class MachineClock final : public LoopClock {
public:
  std::int64_t now() const noexcept override { return spidar::monotonic_time(); }

  std::int64_t boot_time() const noexcept override {
    timespec now{};
    clock_gettime(CLOCK_BOOTTIME, &now);
    return now.tv_sec * kSecond + now.tv_nsec;
  }

  void sleep_until(std::int64_t when) noexcept override {
    const timespec at{.tv_sec = when / kSecond, .tv_nsec = when % kSecond};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
    }
  }

  void wait_until(std::int64_t when, const std::stop_token &stop) override {
    const std::chrono::steady_clock::time_point at{std::chrono::nanoseconds(when)};
    std::mutex mutex; // only to sleep on
    std::unique_lock lock(mutex);
    std::condition_variable_any().wait_until(lock, stop, at, [] { return false; });
  }
};

MachineClock the_machines;

} // namespace

LoopClock &machine_clock() noexcept {
  return the_machines;
}

} // namespace haptic
