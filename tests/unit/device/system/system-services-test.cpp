// SPDX-License-Identifier: LGPL-2.1-or-later
// What a session asks of the machine over D-Bus, with a bus of the test and services that the test
// plays. Without a dbus-daemon only the tests without a bus run.
#include "system/system-services.hpp"

#include "eventually.hpp"
#include "format-text.hpp"
#include "messages.hpp"
#include "session/haptic-session.hpp"
#include "system/dbus.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <future>
#include <gio/gunixfdlist.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <mutex>
#include <poll.h>
#include <string>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

namespace system_services_test {

using namespace std::chrono_literals;
using haptic::BusAddresses;
using haptic::RealTimeAnswer;
using haptic::SystemServices;
using test::eventually;
namespace dbus = haptic::dbus;

constexpr const char *kInterfaces = R"(
<node>
  <interface name="org.freedesktop.RealtimeKit1">
    <method name="MakeThreadRealtime"><arg type="t" direction="in"/><arg type="u" direction="in"/></method>
    <property name="MaxRealtimePriority" type="i" access="read"/>
    <property name="RTTimeUSecMax" type="x" access="read"/>
  </interface>
  <interface name="org.freedesktop.portal.Realtime">
    <method name="MakeThreadRealtimeWithPID"><arg type="t" direction="in"/><arg type="t" direction="in"/><arg type="u" direction="in"/></method>
    <property name="MaxRealtimePriority" type="i" access="read"/>
    <property name="RTTimeUSecMax" type="x" access="read"/>
  </interface>
  <interface name="org.freedesktop.login1.Manager">
    <method name="Inhibit"><arg type="s" direction="in"/><arg type="s" direction="in"/><arg type="s" direction="in"/><arg type="s" direction="in"/><arg type="h" direction="out"/></method>
    <signal name="PrepareForSleep"><arg type="b"/></signal>
  </interface>
</node>)";

bool has_bus() {
  const std::unique_ptr<gchar, decltype(&g_free)> found(g_find_program_in_path("dbus-daemon"),
                                                        g_free);
  return found != nullptr;
}

// rtkit, the portal and logind, on a thread of their own.
class Machine {
public:
  explicit Machine(const std::string &address) : context_(g_main_context_new()) {
    g_main_context_push_thread_default(context_.get());
    bus_ = dbus::connect(address, nullptr);
    g_main_context_pop_thread_default(context_.get());
    node_ = g_dbus_node_info_new_for_xml(kInterfaces, nullptr);
  }
  ~Machine() {
    ending_ = true;
    g_main_context_wakeup(context_.get());
    thread_ = {};
    g_dbus_node_info_unref(node_);
    for (const int file : {lock_[0], lock_[1]})
      if (file >= 0)
        close(file);
  }

  void offer(const dbus::Service &service) {
    static const GDBusInterfaceVTable kFunctions = {on_call, on_get, nullptr, {}};
    g_main_context_push_thread_default(context_.get());
    g_dbus_connection_register_object(bus_.get(), service.path,
                                      g_dbus_node_info_lookup_interface(node_, service.interface),
                                      &kFunctions, this, nullptr, nullptr);
    g_main_context_pop_thread_default(context_.get());
    // That of another test may not have left the bus yet: each takes the name and lets it be taken.
    const dbus::VariantPtr owner(
        g_dbus_connection_call_sync(bus_.get(), "org.freedesktop.DBus", "/", "org.freedesktop.DBus",
                                    "RequestName", g_variant_new("(su)", service.name, 3U), nullptr,
                                    G_DBUS_CALL_FLAGS_NONE, 5000, nullptr, nullptr));
    EXPECT_TRUE(owner);
  }
  void run() {
    thread_ = std::jthread([this] {
      while (!ending_)
        g_main_context_iteration(context_.get(), TRUE);
    });
  }

  void prepare_for_sleep(bool sleeps) {
    g_dbus_connection_emit_signal(bus_.get(), nullptr, "/org/freedesktop/login1",
                                  "org.freedesktop.login1.Manager", "PrepareForSleep",
                                  g_variant_new("(b)", gboolean{sleeps}), nullptr);
    g_dbus_connection_flush_sync(bus_.get(), nullptr, nullptr);
  }
  /// Whether a call waits, while the thread does not run.
  bool is_called() const { return g_main_context_pending(context_.get()); }
  /// Whether the machine may sleep: the lock was taken and every copy of it is closed.
  bool may_sleep() const {
    pollfd end{.fd = lock_[0], .events = POLLIN, .revents = 0};
    return inhibitors > 0 && poll(&end, 1, 0) > 0 && (end.revents & POLLHUP);
  }
  std::vector<std::string> calls() const {
    const std::lock_guard lock(mutex_);
    return calls_;
  }

  std::atomic<bool> refuses = false;
  std::atomic<int> inhibitors = 0; // locks handed out

private:
  static void on_call(GDBusConnection *, const gchar *, const gchar *, const gchar *,
                      const gchar *method, GVariant *arguments, GDBusMethodInvocation *invocation,
                      gpointer machine) {
    auto *self = static_cast<Machine *>(machine);
    const std::unique_ptr<gchar, decltype(&g_free)> text(g_variant_print(arguments, FALSE), g_free);
    {
      const std::lock_guard lock(self->mutex_);
      self->calls_.push_back(std::string(method) + text.get());
    }
    if (self->refuses)
      g_dbus_method_invocation_return_error_literal(invocation, G_DBUS_ERROR,
                                                    G_DBUS_ERROR_ACCESS_DENIED, "refused");
    else if (std::string(method) == "Inhibit")
      self->hand_out_lock(invocation);
    else
      g_dbus_method_invocation_return_value(invocation, nullptr);
  }
  static GVariant *on_get(GDBusConnection *, const gchar *, const gchar *, const gchar *,
                          const gchar *property, GError **, gpointer) {
    return std::string(property) == "MaxRealtimePriority" ? g_variant_new_int32(20)
                                                          : g_variant_new_int64(150'000);
  }
  void hand_out_lock(GDBusMethodInvocation *invocation) {
    for (const int file : {lock_[0], lock_[1]})
      if (file >= 0)
        close(file);
    ASSERT_EQ(pipe(lock_), 0);
    GUnixFDList *files = g_unix_fd_list_new_from_array(&lock_[1], 1); // which owns it
    g_dbus_method_invocation_return_value_with_unix_fd_list(invocation, g_variant_new("(h)", 0),
                                                            files);
    g_dbus_connection_flush_sync(bus_.get(), nullptr, nullptr);
    g_object_unref(files);
    lock_[1] = -1;
    ++inhibitors;
  }

  dbus::ContextPtr context_;
  dbus::ConnectionPtr bus_;
  GDBusNodeInfo *node_ = nullptr;
  mutable std::mutex mutex_;
  std::vector<std::string> calls_; // mutex_
  int lock_[2] = {-1, -1};
  std::atomic<bool> ending_ = false;
  std::jthread thread_;
};

constexpr dbus::Service kRtkit = {"org.freedesktop.RealtimeKit1", "/org/freedesktop/RealtimeKit1",
                                  "org.freedesktop.RealtimeKit1"};
constexpr dbus::Service kPortal = {"org.freedesktop.portal.Desktop",
                                   "/org/freedesktop/portal/desktop",
                                   "org.freedesktop.portal.Realtime"};
constexpr dbus::Service kLogind = {"org.freedesktop.login1", "/org/freedesktop/login1",
                                   "org.freedesktop.login1.Manager"};

class Services : public ::testing::Test {
protected:
  static void SetUpTestSuite() {
    if (!has_bus())
      return;
    daemon = g_test_dbus_new(G_TEST_DBUS_NONE);
    g_test_dbus_up(daemon);
  }
  static void TearDownTestSuite() {
    if (!daemon)
      return;
    g_test_dbus_stop(daemon);
    g_object_unref(daemon);
  }
  void SetUp() override {
    if (!daemon)
      GTEST_SKIP() << "needs dbus-daemon (Debian: dbus-daemon)";
  }
  static std::string address() { return g_test_dbus_get_bus_address(daemon); }

public:
  inline static GTestDBus *daemon = nullptr;
};

TEST(ServicesWithoutABus, Refuse) {
  for (const BusAddresses &buses :
       {BusAddresses{}, BusAddresses{"unix:path=/nowhere/bus", "unix:path=/nowhere/bus"},
        BusAddresses{"nonsense", "nonsense"}}) {
    SystemServices services([] {}, buses);
    services.request_real_time(gettid());
    EXPECT_TRUE(eventually([&] { return services.real_time_answer() != RealTimeAnswer::pending; }));
    EXPECT_EQ(services.real_time_answer(), RealTimeAnswer::refused);
  }
}

TEST_F(Services, RtkitIsAskedForTheThreadWithinItsLimits) {
  Machine machine(address());
  machine.offer(kRtkit);
  machine.run();
  SystemServices services([] {}, {address(), ""});
  services.request_real_time(4711);
  EXPECT_TRUE(eventually([&] { return services.real_time_answer() != RealTimeAnswer::pending; }));
  EXPECT_EQ(services.real_time_answer(), RealTimeAnswer::granted);
  EXPECT_EQ(machine.calls(), std::vector<std::string>{"MakeThreadRealtime(4711, 20)"});
  rlimit limit{};
  getrlimit(RLIMIT_RTTIME, &limit);
  EXPECT_LE(limit.rlim_max, 150'000U); // or rtkit refuses
}

TEST_F(Services, WithoutRtkitThePortalIsAsked) {
  Machine machine(address());
  machine.offer(kPortal);
  machine.run();
  SystemServices services([] {}, {address(), address()});
  services.request_real_time(4711);
  EXPECT_TRUE(eventually([&] { return services.real_time_answer() != RealTimeAnswer::pending; }));
  EXPECT_EQ(services.real_time_answer(), RealTimeAnswer::granted);
  EXPECT_EQ(machine.calls(), std::vector<std::string>{"MakeThreadRealtimeWithPID(" +
                                                      std::to_string(getpid()) + ", 4711, 20)"});
}

TEST_F(Services, ARefusalIsAnAnswer) {
  Machine machine(address());
  machine.refuses = true;
  machine.offer(kRtkit);
  machine.offer(kPortal);
  machine.run();
  SystemServices services([] {}, {address(), address()});
  services.request_real_time(4711);
  EXPECT_TRUE(eventually([&] { return services.real_time_answer() != RealTimeAnswer::pending; }));
  EXPECT_EQ(services.real_time_answer(), RealTimeAnswer::refused);
  EXPECT_EQ(machine.calls().size(), 2U); // both were asked
}

TEST_F(Services, ABusWithoutServicesIsARefusal) {
  SystemServices services([] {}, {address(), address()});
  services.request_real_time(4711);
  EXPECT_TRUE(eventually([&] { return services.real_time_answer() != RealTimeAnswer::pending; }));
  EXPECT_EQ(services.real_time_answer(), RealTimeAnswer::refused);
}

// The end comes before the time limit of a call that was made earlier.
TEST_F(Services, AServiceThatDoesNotAnswerDelaysNoEnd) {
  Machine machine(address());
  machine.offer(kRtkit); // and never runs
  Machine other(address());
  other.offer(kPortal); // nor this one
  const dbus::CancellablePtr cancellable(g_cancellable_new());
  const auto earlier = std::async(std::launch::async, [&] {
    const auto bus = dbus::connect(address(), nullptr);
    dbus::call(bus.get(), kPortal, kPortal.interface, "MakeThreadRealtimeWithPID",
               g_variant_new("(ttu)", guint64{1}, guint64{1}, guint32{1}), cancellable.get());
  });
  ASSERT_TRUE(eventually([&] { return other.is_called(); }));
  {
    SystemServices services([] {}, {address(), ""});
    services.request_real_time(4711);
    ASSERT_TRUE(eventually([&] { return machine.is_called(); })); // it waits
    EXPECT_EQ(services.real_time_answer(), RealTimeAnswer::pending);
  }
  EXPECT_EQ(earlier.wait_for(0s), std::future_status::timeout);
  g_cancellable_cancel(cancellable.get());
}

TEST_F(Services, TheMachineSleepsOnceOnSleepHasReturnedAndTheLockIsTakenAgainWhenItIsAwake) {
  Machine machine(address());
  machine.offer(kLogind);
  machine.run();
  std::atomic<int> sleeps = 0;
  std::atomic<bool> returns = false;
  SystemServices services(
      [&] {
        ++sleeps;
        eventually([&] { return returns.load(); });
      },
      {address(), ""});
  ASSERT_TRUE(eventually([&] { return machine.inhibitors == 1; }));
  EXPECT_EQ(machine.calls().front().rfind("Inhibit('sleep', 'Feeling Wind', ", 0), 0U);
  EXPECT_FALSE(machine.may_sleep());
  machine.prepare_for_sleep(true);
  ASSERT_TRUE(eventually([&] { return sleeps == 1; }));
  EXPECT_FALSE(machine.may_sleep());
  returns = true;
  EXPECT_TRUE(eventually([&] { return machine.may_sleep(); }));
  machine.prepare_for_sleep(false);
  EXPECT_TRUE(eventually([&] { return machine.inhibitors == 2; }));
  EXPECT_FALSE(machine.may_sleep());
}

// A client that keeps the texts of the notices.
class Notices final : public haptic::SessionClient {
public:
  void on_notice(const haptic::Notice &notice) override {
    const std::lock_guard lock(mutex_);
    texts_.push_back(notice.text);
  }
  bool on_point(const haptic::PointerPosition & /*point*/) override { return false; }
  void on_armed_changed() override {}
  std::optional<haptic::ClockReading> read_clocks() override { return std::nullopt; }
  bool has(const std::string &text) const {
    const std::lock_guard lock(mutex_);
    return std::ranges::find(texts_, text) != texts_.end();
  }

private:
  mutable std::mutex mutex_;
  std::vector<std::string> texts_; // mutex_
};

// A session whose force is on.
class PlayingSession {
public:
  PlayingSession() {
    setenv("DBUS_SYSTEM_BUS_ADDRESS", g_test_dbus_get_bus_address(Services::daemon), 1);
    const haptic::DeviceChoice choice{.device = "none"};
    EXPECT_TRUE(session.open(choice));
    EXPECT_TRUE(session.prepare({.choice = choice}));
    session.start_loop();
    session.play();
    EXPECT_TRUE(becomes_true([&] { return !session.silent(); }));
  }
  ~PlayingSession() {
    session.stop_loop();
    session.end_run();
    unsetenv("DBUS_SYSTEM_BUS_ADDRESS");
  }
  /// Waits as eventually() does; meanwhile samples arrive, so that no force goes off for the lack
  /// of them.
  bool becomes_true(const std::function<bool()> &condition) {
    haptic::MotionSample sample;
    sample.velocity_x = 100;
    sample.confidence = 1;
    sample.interval = 700'000'000; // ns: stale after 2 s
    sample.frame_width = 352;
    sample.frame_height = 288;
    return eventually([&] {
      session.loop().submit(sample);
      session.round(haptic::monotonic_now());
      return condition();
    });
  }
  void expect_off() const {
    EXPECT_TRUE(session.silent());
    EXPECT_FALSE(session.is_armed());
    EXPECT_TRUE(notices.has(haptic::messages::kAboutToSleep));
  }

  Notices notices;
  haptic::HapticSession session{notices};
};

TEST_F(Services, ASessionTakesTheForceOffBeforeTheMachineSleeps) {
  Machine machine(address());
  machine.offer(kLogind);
  machine.run();
  PlayingSession playing;
  ASSERT_TRUE(
      playing.becomes_true([&] { return machine.inhibitors == 1 && !playing.session.silent(); }));
  machine.prepare_for_sleep(true);
  EXPECT_TRUE(playing.becomes_true([&] { return machine.may_sleep(); }));
  playing.expect_off();
}

TEST_F(Services, WithoutALockTheForceIsStillTakenOff) {
  Machine machine(address());
  machine.refuses = true;
  machine.offer(kLogind);
  machine.run();
  PlayingSession playing;
  ASSERT_TRUE(playing.becomes_true(
      [&] { return machine.calls().size() == 1 && !playing.session.silent(); }));
  machine.prepare_for_sleep(true);
  EXPECT_TRUE(playing.becomes_true([&] {
    return playing.notices.has(haptic::messages::kAboutToSleep) && playing.session.silent();
  }));
  playing.expect_off();
}

// The kernel gives neither real-time priority nor locked memory to threads that start meanwhile.
class Unprivileged {
public:
  Unprivileged() {
    getrlimit(RLIMIT_RTPRIO, &priority_);
    getrlimit(RLIMIT_MEMLOCK, &memory_);
    set(RLIMIT_RTPRIO, {.rlim_cur = 0, .rlim_max = priority_.rlim_max});
    set(RLIMIT_MEMLOCK, {.rlim_cur = 0, .rlim_max = memory_.rlim_max});
    syscall(SYS_capget, &header_, before_.data());
    auto without = before_;
    for (const unsigned privilege : {CAP_SYS_NICE, CAP_IPC_LOCK, CAP_SYS_RESOURCE})
      without[0].effective &= ~(1U << privilege);
    EXPECT_EQ(syscall(SYS_capset, &header_, without.data()), 0);
  }
  ~Unprivileged() {
    syscall(SYS_capset, &header_, before_.data());
    set(RLIMIT_RTPRIO, priority_);
    set(RLIMIT_MEMLOCK, memory_);
  }
  Unprivileged(const Unprivileged &) = delete;
  Unprivileged &operator=(const Unprivileged &) = delete;

private:
  static void set(int resource, const rlimit &limit) {
    EXPECT_EQ(setrlimit(static_cast<__rlimit_resource_t>(resource), &limit), 0);
  }

  __user_cap_header_struct header_{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> before_{};
  rlimit priority_{};
  rlimit memory_{};
};

TEST_F(Services, ASessionSaysThatTheLimitOfRtkitHoldsForTheProcessAndStays) {
  Machine machine(address());
  machine.offer(kRtkit);
  machine.run();
  const Unprivileged unprivileged;
  PlayingSession playing;
  EXPECT_TRUE(
      playing.becomes_true([&] { return playing.notices.has(haptic::messages::kPriorityOnLoan); }));
  rlimit limit{};
  getrlimit(RLIMIT_RTTIME, &limit);
  limit.rlim_max += 1;
  EXPECT_EQ(setrlimit(RLIMIT_RTTIME, &limit), -1) << "the message says that nobody can";
}

TEST_F(Services, ASessionNamesWhatOfItsMemoryIsNotLocked) {
  Machine machine(address());
  machine.refuses = true;
  machine.offer(kRtkit);
  machine.run();
  const Unprivileged unprivileged;
  PlayingSession playing;
  const haptic::RealTimeThread &thread = playing.session.loop().thread();
  ASSERT_TRUE(eventually([&] { return thread.priority_error() >= 0; }));
  if (thread.memory_error() == 0)
    GTEST_SKIP() << "a sanitizer locks no memory, and says that it did";
  const std::string refused = std::generic_category().message(EPERM);
  EXPECT_TRUE(playing.becomes_true([&] {
    return playing.notices.has(
        haptic::format_text(haptic::messages::kNoRealTime, refused.c_str(), refused.c_str()));
  }));
}

// VmLck of this process, bytes.
std::size_t locked_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmLck:"))
      return 1024 * std::stoul(line.substr(6));
  return 0;
}

// docs/threads.md says so.
TEST_F(Services, TheLoopLocksItsObjectAnd64KibOfItsStackAndNothingElse) {
  munlockall(); // what the loops of other tests have left behind
  const std::size_t before = locked_memory();
  PlayingSession playing;
  const haptic::RealTimeThread &thread = playing.session.loop().thread();
  ASSERT_TRUE(eventually([&] { return thread.priority_error() >= 0; }));
  if (thread.memory_error() != 0 || locked_memory() == before)
    GTEST_SKIP() << "the kernel refuses locked memory, or a sanitizer locks none";
  const std::size_t promised = sizeof(haptic::HapticLoop) + 65536;
  const std::size_t locked = locked_memory() - before;
  EXPECT_GE(locked, promised);
  EXPECT_LE(locked, promised + 4 * static_cast<std::size_t>(getpagesize()));
}

} // namespace system_services_test
