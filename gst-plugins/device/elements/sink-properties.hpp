// SPDX-License-Identifier: LGPL-2.1-or-later
// The properties of hapticsink: one table with their names, ranges, texts and places.
#pragma once

#include "session/haptic-session.hpp"

#include <gst/gst.h>
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

/// The type of the property `session-state`.
GType session_state_type();

/// Installs the properties of the table.
void install_sink_properties(GObjectClass *klass);

/// Copies the value of the property `id` into or out of the settings. `id` must be one of the
/// table.
void set_sink_property(guint id, const GValue *value, SinkSettings &settings);
void get_sink_property(guint id, GValue *value, SinkSettings &settings);

} // namespace haptic
