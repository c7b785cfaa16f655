// SPDX-License-Identifier: LGPL-2.1-or-later
// From the bytes of a relief and its presentation time to a surface for the loop.
#pragma once

#include "share/shared-value.hpp"
#include "touch/relief-timeline.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <utility>

namespace haptic {

/// The state of one stream: a start replaces it. The streaming thread of the reliefs; the counters
/// are read by any thread.
class ReliefIntake {
public:
  /// `pool` outlives every relief that accept() returns.
  explicit ReliefIntake(ReliefPool &pool) noexcept : pool_(&pool) {}

  struct Result {
    std::optional<TimedRelief> relief; ///< for the loop
    bool damaged = false;              ///< the bytes cannot be used: there is no surface
  };
  /// One frame, in the order of the stream; `time` of its presentation. `gap`: there is no surface.
  Result accept(std::span<const std::uint8_t> bytes, bool gap, std::int64_t time) {
    if (gap)
      return {TimedRelief{.time = time}};
    ReliefPool::Field field = pool_->acquire();
    if (!field)
      return {}; // the loop stands still; the newest relief is lost
    if (!unpack_relief_field(bytes, *field)) {
      ++bad_reliefs_;
      return {TimedRelief{.time = time}, true};
    }
    ++reliefs_;
    interval_ = field->interval;
    return {TimedRelief{std::move(field), time}};
  }

  /// ns between the frames of the last relief; 0: unknown.
  std::uint64_t interval() const noexcept { return interval_; }
  std::uint64_t reliefs() const noexcept { return reliefs_.load(); }
  std::uint64_t bad_reliefs() const noexcept { return bad_reliefs_.load(); }

private:
  ReliefPool *pool_;
  std::uint64_t interval_ = 0;
  SharedValue<std::uint64_t> reliefs_;
  SharedValue<std::uint64_t> bad_reliefs_;
};

} // namespace haptic
