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
  std::string fault_location = "auto";
  LatencyMode latency_mode = LatencyMode::automatic;
  RateLaw rate_law = RateLaw::as_seen;
  LoopSettings loop;
};

/// Number of the properties in the table; their ids are 1 to kSinkProperties.
inline constexpr guint kSinkProperties = 25;
std::span<const Property<SinkSettings>> sink_properties();

/// The folder that `fault-location` names; auto: ~/.local/state/feeling-wind, or where
/// $XDG_STATE_HOME says; empty for none.
std::string fault_folder(const std::string &fault_location);

/// The type of the property `session-state`; to be called once.
GType session_state_type();

} // namespace haptic
