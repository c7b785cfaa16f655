// SPDX-License-Identifier: LGPL-2.1-or-later
// Delays the sleep of the machine until the force is zero: logind's delay inhibitor.
#pragma once

#include "system/dbus.hpp"

#include <functional>

namespace haptic {

/// For the thread whose default context its constructor finds; the signals come there.
class SleepInhibitor {
public:
  /// `on_sleep` is called when the machine is about to sleep, which it does once the call returns
  /// (or after logind's InhibitDelayMaxSec, 5 s by default). Without logind nothing happens.
  SleepInhibitor(GDBusConnection *system_bus, std::function<void()> on_sleep,
                 GCancellable *cancellable);
  ~SleepInhibitor();
  SleepInhibitor(const SleepInhibitor &) = delete;
  SleepInhibitor &operator=(const SleepInhibitor &) = delete;

private:
  void take();
  void release();
  void on_signal(bool sleeps) noexcept;

  GDBusConnection *bus_;
  std::function<void()> on_sleep_;
  GCancellable *cancellable_;
  guint subscription_ = 0;
  int lock_ = -1; // file; logind waits until it is closed
};

} // namespace haptic
