// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether this machine is in time: spidar-check --machine.
#pragma once

#include <functional>
#include <optional>
#include <spidar/machine.hpp>
#include <thread>
#include <vector>

namespace spidar_check {

inline constexpr int kRealTimePriority = 50; ///< as the loop of hapticsink

/// What the ticks of a 1 kHz clock showed.
struct TimedTicks {
  bool priority = false; ///< the clock had real-time priority
  spidar::Lateness lateness;
  std::optional<double> round_trip; ///< s; 99.9 % of the exchanges did not take longer
};

/// Lets a clock tick for so many seconds, in a thread that has the priority of hapticsink's loop
/// where the user may have it. `exchange` is called in each tick, and says whether the
/// device answered: no other call counts. Null: there is no device.
TimedTicks time_ticks(double seconds, const std::function<bool()> &exchange);

/// Keeps all processors of this process busy, at normal priority, as long as it lives.
class BusyProcessors {
public:
  BusyProcessors();
  ~BusyProcessors();
  BusyProcessors(const BusyProcessors &) = delete;
  BusyProcessors &operator=(const BusyProcessors &) = delete;

  std::size_t count() const noexcept { return threads_.size(); }

private:
  std::vector<std::jthread> threads_;
};

} // namespace spidar_check
