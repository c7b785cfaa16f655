// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "session/session-client.hpp"

#include <functional>
#include <memory>
#include <spidar/error.hpp>
#include <spidar/haptic-device.hpp>

namespace haptic {

/// Opens a lost device again: how often it tries, and what it reports. Pointer thread.
class Reopening {
public:
  using Device = std::unique_ptr<spidar::HapticDevice>;
  /// While the device is not lost.
  void rest() noexcept { wait_ = kFirst; }
  /// While the device is lost and destroyed. Returns what `open` opened; null before that. `now` in
  /// ns of the monotonic clock.
  Device attempt(std::int64_t now, const std::function<Device()> &open, SessionClient &client);

private:
  static constexpr std::int64_t kFirst = 100'000'000; // ns after the loss; doubled each time
  static constexpr std::int64_t kLast = 500'000'000;  // ns

  void report(const spidar::Error &error, std::int64_t now, SessionClient &client);

  std::int64_t wait_ = kFirst;          // ns, between two attempts
  std::optional<std::int64_t> next_at_; // ns, monotonic; nothing: it has not begun
  std::string reported_;                // text of the last failure that was reported
};

} // namespace haptic
