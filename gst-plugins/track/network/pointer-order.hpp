// SPDX-License-Identifier: LGPL-2.1-or-later
// The order of pointers that come over a network, where packets overtake each other.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace haptic {

/// Finds pointers that are older than one that has come.
class PointerOrder {
public:
  using Time = std::chrono::steady_clock::time_point;

  /// The far end sends every 200 ms at least. After a longer silence it may have been started anew,
  /// and its numbers begin again.
  static constexpr std::chrono::seconds kForgotten{1};

  /// Returns whether the pointer is to be used, and then remembers it. Numbers go round.
  bool accept(std::uint32_t sequence, Time now) noexcept {
    const bool newer =
        !last_ || now - arrived_ > kForgotten || static_cast<std::int32_t>(sequence - *last_) > 0;
    if (newer) {
      last_ = sequence;
      arrived_ = now;
    }
    return newer;
  }

private:
  std::optional<std::uint32_t> last_;
  Time arrived_;
};

} // namespace haptic
