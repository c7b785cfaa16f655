// SPDX-License-Identifier: LGPL-2.1-or-later
#include "system/system-services.hpp"

#include "system/dbus.hpp"
#include "system/real-time-service.hpp"
#include "system/sleep-inhibitor.hpp"

#include <atomic>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

namespace haptic {

BusAddresses bus_addresses() {
  const char *system = std::getenv("DBUS_SYSTEM_BUS_ADDRESS");
  const char *session = std::getenv("DBUS_SESSION_BUS_ADDRESS");
  const char *runtime = std::getenv("XDG_RUNTIME_DIR");
  BusAddresses buses;
  buses.system = system ? system : "unix:path=/run/dbus/system_bus_socket";
  std::error_code error;
  if (session)
    buses.session = session;
  else if (runtime && std::filesystem::exists(std::string(runtime) + "/bus", error))
    buses.session = std::string("unix:path=") + runtime + "/bus";
  return buses;
}

struct SystemServices::Implementation {
  Implementation(std::function<void()> on_sleep, BusAddresses the_buses)
      : sleep(std::move(on_sleep)), buses(std::move(the_buses)), context(g_main_context_new()),
        cancellable(g_cancellable_new()), thread([this] { run(); }) {}

  ~Implementation() {
    ending = true;
    g_cancellable_cancel(cancellable.get()); // ends a call
    g_main_context_wakeup(context.get());
  }

  void run() noexcept {
    g_main_context_push_thread_default(context.get());
    try {
      serve();
    } catch (const std::exception &) {
      answer = RealTimeAnswer::refused;
    }
    g_main_context_pop_thread_default(context.get());
  }

  void serve() {
    const dbus::ConnectionPtr system = dbus::connect(buses.system, cancellable.get());
    std::optional<SleepInhibitor> inhibitor;
    if (system)
      inhibitor.emplace(system.get(), sleep, cancellable.get());
    while (!ending) {
      if (const int wanted = request.exchange(0))
        answer =
            is_granted(system.get(), wanted) ? RealTimeAnswer::granted : RealTimeAnswer::refused;
      g_main_context_iteration(context.get(), TRUE);
    }
  }

  bool is_granted(GDBusConnection *system, int wanted) {
    if (system && request_from_rtkit(system, wanted, cancellable.get()))
      return true;
    const dbus::ConnectionPtr session = dbus::connect(buses.session, cancellable.get());
    return session && request_from_portal(session.get(), wanted, cancellable.get());
  }

  const std::function<void()> sleep;
  const BusAddresses buses;
  const dbus::ContextPtr context;
  const dbus::CancellablePtr cancellable;
  std::atomic<int> request = 0; // thread for which the priority is asked; 0: none
  std::atomic<RealTimeAnswer> answer = RealTimeAnswer::pending;
  std::atomic<bool> ending = false;
  std::jthread thread; // last: ends before what it uses
};

SystemServices::SystemServices(std::function<void()> on_sleep, BusAddresses buses)
    : implementation_(std::make_unique<Implementation>(std::move(on_sleep), std::move(buses))) {}

SystemServices::~SystemServices() = default;

void SystemServices::request_real_time(int thread) noexcept {
  implementation_->request = thread;
  g_main_context_wakeup(implementation_->context.get());
}

RealTimeAnswer SystemServices::real_time_answer() const noexcept {
  return implementation_->answer;
}

} // namespace haptic
