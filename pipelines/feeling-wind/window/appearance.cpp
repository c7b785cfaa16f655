// SPDX-License-Identifier: LGPL-2.1-or-later
#include "window/appearance.hpp"

#include <gio/gio.h>
#include <gtk/gtk.h>

namespace program {
namespace {

constexpr const char *kService = "org.freedesktop.portal.Desktop";
constexpr const char *kPath = "/org/freedesktop/portal/desktop";
constexpr const char *kInterface = "org.freedesktop.portal.Settings";
constexpr const char *kNamespace = "org.freedesktop.appearance";
constexpr const char *kName = "color-scheme";
constexpr guint32 kDark = 1;
constexpr int kPatience = 1000; // ms

bool follows_system = false;

void set_dark(bool dark) {
  g_object_set(gtk_settings_get_default(), "gtk-application-prefer-dark-theme",
               static_cast<gboolean>(dark), nullptr);
}

// The value may be wrapped in further variants.
void apply(GVariant *value) {
  GVariant *inner = g_variant_ref(value);
  while (g_variant_is_of_type(inner, G_VARIANT_TYPE_VARIANT)) {
    GVariant *next = g_variant_get_variant(inner);
    g_variant_unref(inner);
    inner = next;
  }
  if (follows_system && g_variant_is_of_type(inner, G_VARIANT_TYPE_UINT32))
    set_dark(g_variant_get_uint32(inner) == kDark);
  g_variant_unref(inner);
}

void on_changed(GDBusConnection *, const gchar *, const gchar *, const gchar *, const gchar *,
                GVariant *parameters, gpointer) noexcept {
  const gchar *space = nullptr;
  const gchar *name = nullptr;
  GVariant *value = nullptr;
  if (!g_variant_is_of_type(parameters, G_VARIANT_TYPE("(ssv)")))
    return;
  g_variant_get(parameters, "(&s&sv)", &space, &name, &value);
  if (g_str_equal(space, kNamespace) && g_str_equal(name, kName))
    apply(value);
  g_variant_unref(value);
}

void on_read(GObject *bus, GAsyncResult *result, gpointer) noexcept {
  if (GVariant *answer = g_dbus_connection_call_finish(G_DBUS_CONNECTION(bus), result, nullptr)) {
    GVariant *value = g_variant_get_child_value(answer, 0);
    apply(value);
    g_variant_unref(value);
    g_variant_unref(answer);
  }
}

void on_bus(GObject *, GAsyncResult *result, gpointer) noexcept {
  GDBusConnection *bus = g_bus_get_finish(result, nullptr);
  if (!bus)
    return;
  static guint subscription = 0; // as long as the program
  if (!subscription)
    subscription = g_dbus_connection_signal_subscribe(bus, kService, kInterface, "SettingChanged",
                                                      kPath, nullptr, G_DBUS_SIGNAL_FLAGS_NONE,
                                                      on_changed, nullptr, nullptr);
  g_dbus_connection_call(bus, kService, kPath, kInterface, "Read",
                         g_variant_new("(ss)", kNamespace, kName), G_VARIANT_TYPE("(v)"),
                         G_DBUS_CALL_FLAGS_NONE, kPatience, nullptr, on_read, nullptr);
}

} // namespace

void set_appearance(const std::string &choice) {
  follows_system = choice != "light" && choice != "dark";
  if (follows_system)
    g_bus_get(G_BUS_TYPE_SESSION, nullptr, on_bus, nullptr);
  else
    set_dark(choice == "dark");
}

} // namespace program
