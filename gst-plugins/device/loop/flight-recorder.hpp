// SPDX-License-Identifier: LGPL-2.1-or-later
// The last two seconds of ticks, in memory, for whoever asks why the force stopped.
#pragma once

#include "loop/tick-row.hpp"
#include "share/shared-value.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace haptic {

/// The loop records each tick into one of two rings. When a rule stops the force, it leaves that
/// ring to another thread and goes on with the other one, so that no tick belongs to both threads.
class FlightRecorder {
public:
  static constexpr double kSeconds = 2;

  /// Keeps nothing.
  FlightRecorder() = default;
  explicit FlightRecorder(double rate) {
    for (Ring &ring : rings_)
      ring.ticks.resize(static_cast<std::size_t>(std::ceil(kSeconds * rate)));
  }

  struct Tick {
    TickRow row;
    bool late = false; ///< it began more than a period late
  };

  // The loop. Real-time safe.

  void record(const TickRow &row, bool late) noexcept {
    Ring &ring = rings_[active_];
    if (!ring.ticks.empty())
      ring.ticks[ring.count++ % ring.ticks.size()] = {row, late};
  }
  /// What was recorded so far is kept, unless the record before has not been taken yet. `rules`:
  /// the holds (Hold) that have just begun.
  void keep(std::uint32_t rules) noexcept {
    Ring &ring = rings_[active_];
    if (kept_.load() != kNone || ring.count == 0)
      return;
    ring.rules = rules;
    kept_.store(static_cast<int>(active_));
    active_ = 1 - active_;
    rings_[active_].count = 0;
  }

  // One other thread.

  /// Calls `use(rules, ticks)`, the earliest tick first, if there is a record; then it is gone.
  template <typename Use>
  void take(const Use &use) {
    const int kept = kept_.load();
    if (kept == kNone)
      return;
    Ring &ring = rings_[static_cast<std::size_t>(kept)];
    std::vector<Tick> &ticks = ring.ticks;
    if (ring.count > ticks.size())
      std::rotate(ticks.begin(),
                  ticks.begin() + static_cast<std::ptrdiff_t>(ring.count % ticks.size()),
                  ticks.end());
    use(ring.rules, std::span<const Tick>(ticks.data(), std::min(ring.count, ticks.size())));
    kept_.store(kNone);
  }

private:
  static constexpr int kNone = -1;
  struct Ring {
    std::vector<Tick> ticks;
    std::size_t count = 0; // ever recorded since it became the active one
    std::uint32_t rules = 0;
  };

  std::array<Ring, 2> rings_;     // the active one: the loop; the kept one: the other thread
  std::size_t active_ = 0;        // the loop
  SharedValue<int> kept_ = kNone; // index of the ring that the other thread has
};

} // namespace haptic
