// SPDX-License-Identifier: LGPL-2.1-or-later
// The pointer event: the position of the hand. It travels upstream from hapticsink to roitracker.
#pragma once

#include "gst-raii.hpp"

#include <array>
#include <optional>
#include <string>

namespace haptic {

/// x and y are fractions of the frame, origin at its top left corner (paper, equation 1).
struct PointerPosition {
  double x = 0.5;       ///< 0..1, to the right
  double y = 0.5;       ///< 0..1, down
  double z = 0;         ///< -1..1, fraction of the half workspace, towards the user
  bool pressed = false; ///< a button of the grip
  std::string device;   ///< name of the device, for people
  GstClockTime timestamp = GST_CLOCK_TIME_NONE; ///< running time
  /// N, as commanded, mean since the event before; x to the right, y up, z towards the user.
  std::optional<std::array<double, 3>> force;
};

/// A GST_EVENT_CUSTOM_UPSTREAM with the structure `haptic-pointer` (docs/formats/pointer-event.md).
EventPtr make_pointer_event(const PointerPosition &position);

/// Returns the position, or nothing if the event is not a pointer event, or x or y is missing or
/// not finite. Clamps values outside their range. A force that is not finite in all directions
/// counts as none. Does not take the event.
std::optional<PointerPosition> parse_pointer_event(GstEvent *event);

} // namespace haptic
