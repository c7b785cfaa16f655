// SPDX-License-Identifier: LGPL-2.1-or-later
// Owning pointers for GLib's D-Bus types, and calls with a short time limit. Not for the 1 kHz
// thread.
#pragma once

#include <gio/gio.h>
#include <memory>
#include <string>

namespace haptic::dbus {

struct Releaser {
  void operator()(GDBusConnection *connection) const noexcept { g_object_unref(connection); }
  void operator()(GCancellable *cancellable) const noexcept { g_object_unref(cancellable); }
  void operator()(GMainContext *context) const noexcept { g_main_context_unref(context); }
  void operator()(GVariant *value) const noexcept { g_variant_unref(value); }
};

using ConnectionPtr = std::unique_ptr<GDBusConnection, Releaser>;
using CancellablePtr = std::unique_ptr<GCancellable, Releaser>;
using ContextPtr = std::unique_ptr<GMainContext, Releaser>;
using VariantPtr = std::unique_ptr<GVariant, Releaser>;

inline constexpr int kTimeLimit = 2000; // ms; a service may have to be started

struct Service {
  const char *name;
  const char *path;
  const char *interface;
};

/// Opens a connection of our own: the shared one of g_bus_get() ends the process when the bus goes.
/// Returns null without a bus.
inline ConnectionPtr connect(const std::string &address, GCancellable *cancellable) {
  if (address.empty())
    return nullptr;
  constexpr auto kFlags =
      static_cast<GDBusConnectionFlags>(G_DBUS_CONNECTION_FLAGS_AUTHENTICATION_CLIENT |
                                        G_DBUS_CONNECTION_FLAGS_MESSAGE_BUS_CONNECTION);
  return ConnectionPtr(g_dbus_connection_new_for_address_sync(address.c_str(), kFlags, nullptr,
                                                              cancellable, nullptr));
}

/// Calls a method; consumes `arguments`. Returns null if it fails or is refused.
inline VariantPtr call(GDBusConnection *connection, const Service &service, const char *interface,
                       const char *method, GVariant *arguments, GCancellable *cancellable) {
  return VariantPtr(g_dbus_connection_call_sync(connection, service.name, service.path, interface,
                                                method, arguments, nullptr, G_DBUS_CALL_FLAGS_NONE,
                                                kTimeLimit, cancellable, nullptr));
}

} // namespace haptic::dbus
