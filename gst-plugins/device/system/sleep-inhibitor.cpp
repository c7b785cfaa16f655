// SPDX-License-Identifier: LGPL-2.1-or-later
#include "system/sleep-inhibitor.hpp"

#include <exception>
#include <gio/gunixfdlist.h>
#include <unistd.h>
#include <utility>

namespace haptic {
namespace {

// systemd's "Inhibitor Locks" and org.freedesktop.login1(5).
constexpr dbus::Service kLogind = {"org.freedesktop.login1", "/org/freedesktop/login1",
                                   "org.freedesktop.login1.Manager"};

} // namespace

SleepInhibitor::SleepInhibitor(GDBusConnection *system_bus, std::function<void()> on_sleep,
                               GCancellable *cancellable)
    : bus_(system_bus), on_sleep_(std::move(on_sleep)), cancellable_(cancellable) {
  subscription_ = g_dbus_connection_signal_subscribe(
      bus_, kLogind.name, kLogind.interface, "PrepareForSleep", kLogind.path, nullptr,
      G_DBUS_SIGNAL_FLAGS_NONE,
      [](GDBusConnection *, const gchar *, const gchar *, const gchar *, const gchar *,
         GVariant *arguments, gpointer self) {
        gboolean sleeps = FALSE;
        if (!g_variant_is_of_type(arguments, G_VARIANT_TYPE("(b)")))
          return;
        g_variant_get(arguments, "(b)", &sleeps);
        static_cast<SleepInhibitor *>(self)->on_signal(sleeps);
      },
      this, nullptr);
  take();
}

SleepInhibitor::~SleepInhibitor() {
  g_dbus_connection_signal_unsubscribe(bus_, subscription_);
  release();
}

void SleepInhibitor::take() {
  if (lock_ >= 0)
    return;
  GUnixFDList *files = nullptr;
  const dbus::VariantPtr reply(g_dbus_connection_call_with_unix_fd_list_sync(
      bus_, kLogind.name, kLogind.path, kLogind.interface, "Inhibit",
      g_variant_new("(ssss)", "sleep", "Feeling Wind", "The force fades to zero first", "delay"),
      G_VARIANT_TYPE("(h)"), G_DBUS_CALL_FLAGS_NONE, dbus::kTimeLimit, nullptr, &files,
      cancellable_, nullptr));
  if (reply && files) {
    gint32 index = 0;
    g_variant_get(reply.get(), "(h)", &index);
    lock_ = g_unix_fd_list_get(files, index, nullptr);
  }
  if (files)
    g_object_unref(files);
}

void SleepInhibitor::release() {
  if (lock_ >= 0)
    close(std::exchange(lock_, -1));
}

void SleepInhibitor::on_signal(bool sleeps) noexcept {
  try {
    if (!sleeps)
      return take();
    on_sleep_();
  } catch (const std::exception &) { // the machine may sleep all the same
  }
  release();
}

} // namespace haptic
