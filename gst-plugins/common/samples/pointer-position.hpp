// SPDX-License-Identifier: LGPL-2.1-or-later
// Where the hand points, as plain data: the 1 kHz loop needs it without GStreamer.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

namespace haptic {

/// A time stamp that says nothing; the same as GST_CLOCK_TIME_NONE.
inline constexpr std::uint64_t kNoTimestamp = std::numeric_limits<std::uint64_t>::max();

/// The point of a relief where a hand that touches it is held (docs/force.md#touch).
struct ProxyPosition {
  double x = 0.5;   ///< 0..1, as of the pointer
  double y = 0.5;   ///< 0..1
  double depth = 0; ///< m, from the hand to the proxy; 0: it touches nothing, and is the hand
  bool operator==(const ProxyPosition &) const = default;
};

/// x and y are fractions of the frame, origin at its top left corner (paper, equation 1).
struct PointerPosition {
  double x = 0.5;       ///< 0..1, to the right
  double y = 0.5;       ///< 0..1, down
  double z = 0;         ///< -1..1, fraction of the half workspace, towards the user
  bool pressed = false; ///< a button of the grip
  std::string device;   ///< name of the device, for people to read
  std::uint64_t timestamp = kNoTimestamp; ///< running time, ns
  /// N, as commanded, mean since the event before; x to the right, y up, z towards the user.
  std::optional<std::array<double, 3>> force;
  std::optional<ProxyPosition> proxy; ///< while the device can touch reliefs
};

} // namespace haptic
