// SPDX-License-Identifier: LGPL-2.1-or-later
// What a session asks of the machine over D-Bus, from a thread of its own: real-time priority, and
// a moment before it sleeps. Where there is no bus or no service, nothing happens.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace haptic {

/// Empty where there is none.
struct BusAddresses {
  std::string system;
  std::string session;
};

/// Returns the addresses of this machine's buses. Starts none.
BusAddresses bus_addresses();

enum class RealTimeAnswer { pending, granted, refused };

class SystemServices {
public:
  /// `on_sleep` is called in the thread of this object: SleepInhibitor. Throws std::system_error.
  explicit SystemServices(std::function<void()> on_sleep, BusAddresses buses = bus_addresses());
  ~SystemServices();
  SystemServices(const SystemServices &) = delete;
  SystemServices &operator=(const SystemServices &) = delete;

  /// Once: asks rtkit, then the portal, to give this thread of the process real-time priority. Does
  /// not wait.
  void request_real_time(int thread) noexcept;
  /// The answer comes within seconds.
  RealTimeAnswer real_time_answer() const noexcept;

private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

} // namespace haptic
