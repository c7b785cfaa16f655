// SPDX-License-Identifier: LGPL-2.1-or-later
// Asks rtkit, or the desktop's portal, for real-time priority where limits.conf grants none.
#pragma once

#include "system/dbus.hpp"

namespace haptic {

/// Of this process. Limits the processor time that a real-time thread of this process may use
/// without sleeping (RLIMIT_RTTIME), which both services demand. Returns whether the priority was
/// granted.
bool request_from_rtkit(GDBusConnection *system_bus, int thread, GCancellable *cancellable);
bool request_from_portal(GDBusConnection *session_bus, int thread, GCancellable *cancellable);

} // namespace haptic
