// SPDX-License-Identifier: LGPL-2.1-or-later
// The properties of hapticsink: one table with their names, ranges, texts and places.
#pragma once

#include "glue/property-table.hpp"
#include "session/haptic-session.hpp"

#include <gst/gst.h>
#include <span>
#include <string>

namespace haptic {

/// The properties as set. A default-constructed one holds their defaults.
struct SinkSettings {
  DeviceChoice choice;
  std::string log_location;
  LatencyMode latency_mode = LatencyMode::automatic;
  RateLaw rate_law = RateLaw::as_seen;
  LoopSettings loop;
};

/// Number of the properties in the table; their ids are 1 to kSinkProperties.
inline constexpr guint kSinkProperties = 23;
std::span<const Property<SinkSettings>> sink_properties();

/// The type of the property `session-state`; to be called once.
GType session_state_type();

} // namespace haptic
