// SPDX-License-Identifier: LGPL-2.1-or-later
// The pointer event: the position of the hand, sent upstream from hapticsink to roitracker.
#pragma once

#include "glue/gst-raii.hpp"
#include "samples/pointer-position.hpp"

#include <optional>

namespace haptic {

/// Returns a GST_EVENT_CUSTOM_UPSTREAM with the structure `haptic-pointer`
/// (docs/formats/pointer-event.md).
EventPtr make_pointer_event(const PointerPosition &position);

/// Returns the position, or nothing if the event is not a pointer event, or x or y is missing or
/// not finite. Values outside their range are clamped. A force that is not finite in all directions
/// is left out, and so is a proxy that is not finite. Does not take ownership of the event.
std::optional<PointerPosition> parse_pointer_event(GstEvent *event);

} // namespace haptic
