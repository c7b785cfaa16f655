// SPDX-License-Identifier: LGPL-2.1-or-later
// What hapticsink posts: notices of the session as messages with their codes, and the statistics.
#pragma once

#include "glue/gst-raii.hpp"
#include "session/haptic-session.hpp"

namespace haptic {

/// Level of a notice in the debug log.
GstDebugLevel log_level(Severity severity);

/// Posts a notice that has a cause as an error, warning or info.
void post_notice(GstElement *element, const Notice &notice);

void post_stream_status(GstElement *element, GstStreamStatusType type);

/// Posts the element message `haptic-session`.
void post_session(GstElement *element, const SessionStatus &status);

/// Posts the element message `hapticsink-stats`.
void post_stats(GstElement *element, const HapticSession &session);

/// Returns the structure of the property `stats`.
StructurePtr make_stats(const HapticSession &session);

/// Returns the time of `monotonic` and the running time, or nothing if the element has no clock.
std::optional<ClockReading> read_clocks(GstElement *element, const LoopClock &monotonic);

} // namespace haptic
