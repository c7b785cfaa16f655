// SPDX-License-Identifier: LGPL-2.1-or-later
#include "check-machine.hpp"

#include <atomic>
#include <chrono>
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

namespace spidar_check {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

namespace {

constexpr auto kPeriod = 1ms;

double seconds(Clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

/// As the thread of hapticsink's loop.
bool take_priority() {
  prctl(PR_SET_TIMERSLACK, 1UL);
  const sched_param wanted{.sched_priority = kRealTimePriority};
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted) == 0;
}

std::size_t usable_processors() {
  cpu_set_t usable;
  return sched_getaffinity(0, sizeof usable, &usable) == 0
             ? static_cast<std::size_t>(CPU_COUNT(&usable))
             : std::thread::hardware_concurrency();
}

} // namespace

TimedTicks time_ticks(double length, const std::function<bool()> &exchange) {
  const auto ticks = static_cast<std::size_t>(length / seconds(kPeriod));
  TimedTicks result;
  std::vector<double> late;
  std::vector<double> taken;
  late.reserve(ticks);
  taken.reserve(ticks);
  std::jthread([&] {
    result.priority = take_priority();
    const auto end = Clock::now() + ticks * kPeriod;
    for (auto next = Clock::now() + kPeriod; next <= end; next += kPeriod) {
      std::this_thread::sleep_until(next);
      const auto now = Clock::now();
      late.push_back(seconds(now - next));
      if (exchange && exchange())
        taken.push_back(seconds(Clock::now() - now));
      if (now - next > kPeriod) // the periods that are past are skipped, as in the loop
        next += (now - next) / kPeriod * kPeriod;
    }
  }).join();
  result.lateness = spidar::lateness_of(std::move(late));
  if (!taken.empty())
    result.round_trip = spidar::lateness_of(std::move(taken)).usual;
  return result;
}

BusyProcessors::BusyProcessors() {
  for (std::size_t i = usable_processors(); i > 0; --i)
    threads_.emplace_back([](const std::stop_token &stop) {
      for (std::atomic<unsigned> number = 0; !stop.stop_requested();)
        number.fetch_add(1, std::memory_order_relaxed);
    });
}

BusyProcessors::~BusyProcessors() {
  for (std::jthread &thread : threads_)
    thread.request_stop(); // all at once
}

} // namespace spidar_check
