// SPDX-License-Identifier: LGPL-2.1-or-later
#include "system/real-time-service.hpp"

#include "share/real-time-priority.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <sys/resource.h>
#include <unistd.h>

namespace haptic {
namespace {

// rtkit's README and the portal's documentation of org.freedesktop.portal.Realtime.
constexpr dbus::Service kRtkit = {"org.freedesktop.RealtimeKit1", "/org/freedesktop/RealtimeKit1",
                                  "org.freedesktop.RealtimeKit1"};
constexpr dbus::Service kPortal = {"org.freedesktop.portal.Desktop",
                                   "/org/freedesktop/portal/desktop",
                                   "org.freedesktop.portal.Realtime"};
constexpr std::int64_t kLongestRun = 200'000; // us, rtkit's default

std::optional<std::int64_t> property(GDBusConnection *bus, const dbus::Service &service,
                                     const char *name, GCancellable *cancellable) {
  const dbus::VariantPtr reply =
      dbus::call(bus, service, "org.freedesktop.DBus.Properties", "Get",
                 g_variant_new("(ss)", service.interface, name), cancellable);
  if (!reply || !g_variant_is_of_type(reply.get(), G_VARIANT_TYPE("(v)")))
    return std::nullopt;
  GVariant *inner = nullptr;
  g_variant_get(reply.get(), "(v)", &inner);
  const dbus::VariantPtr value(inner);
  if (g_variant_is_of_type(inner, G_VARIANT_TYPE_INT32))
    return g_variant_get_int32(inner);
  if (g_variant_is_of_type(inner, G_VARIANT_TYPE_INT64))
    return g_variant_get_int64(inner);
  return std::nullopt;
}

// The loop sleeps each millisecond, so that it never comes near the limit.
bool limit_run_time(std::int64_t microseconds) {
  const auto most = static_cast<rlim_t>(microseconds);
  rlimit limit{};
  if (getrlimit(RLIMIT_RTTIME, &limit) != 0)
    return false;
  if (limit.rlim_max <= most)
    return true;
  limit = {.rlim_cur = std::min(limit.rlim_cur, most), .rlim_max = most};
  return setrlimit(RLIMIT_RTTIME, &limit) == 0;
}

// The priority that may be asked for; nothing if the service is not there.
std::optional<guint32> allowed_priority(GDBusConnection *bus, const dbus::Service &service,
                                        GCancellable *cancellable) {
  const auto highest = property(bus, service, "MaxRealtimePriority", cancellable);
  if (!highest || *highest < 1)
    return std::nullopt;
  const auto longest = property(bus, service, "RTTimeUSecMax", cancellable);
  if (!limit_run_time(longest && *longest > 0 ? *longest : kLongestRun))
    return std::nullopt;
  return static_cast<guint32>(std::min<std::int64_t>(*highest, kRealTimePriority));
}

} // namespace

bool request_from_rtkit(GDBusConnection *system_bus, int thread, GCancellable *cancellable) {
  const auto priority = allowed_priority(system_bus, kRtkit, cancellable);
  return priority &&
         dbus::call(system_bus, kRtkit, kRtkit.interface, "MakeThreadRealtime",
                    g_variant_new("(tu)", static_cast<guint64>(thread), *priority), cancellable);
}

bool request_from_portal(GDBusConnection *session_bus, int thread, GCancellable *cancellable) {
  const auto priority = allowed_priority(session_bus, kPortal, cancellable);
  return priority &&
         dbus::call(session_bus, kPortal, kPortal.interface, "MakeThreadRealtimeWithPID",
                    g_variant_new("(ttu)", static_cast<guint64>(getpid()),
                                  static_cast<guint64>(thread), *priority),
                    cancellable);
}

} // namespace haptic
