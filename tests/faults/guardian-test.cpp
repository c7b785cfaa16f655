// SPDX-License-Identifier: LGPL-2.1-or-later
// The guardian, with a socket in the device's place: umockdev cannot lend its usbfs to another
// program. All else is real: the library's side, the helper program, processes that are killed.
// The tests ask what is on the wire in the end; the times are reported.
#include "guard/guardian-protocol.hpp"
#include "guard/guardian.hpp"
#include "loop-priority.hpp"
#include "report-line.hpp"
#include "stolen-time.hpp"

#include "spidar/error.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <poll.h>
#include <random>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace {

using namespace std::chrono_literals;
using namespace spidar;
using Watch = Guardian::Watch;
using Clock = std::chrono::steady_clock;

constexpr unsigned char kEndpoint = 0x02;
constexpr std::array<std::uint8_t, 32> kRestPacket = {0x52, 45};
constexpr std::array<std::uint8_t, 32> kForcePacket = {0x52, 255, 15};
constexpr std::array<std::uint8_t, 32> kNoticed = {0x77};

constexpr auto kForEver = 60s; // until a test gives up
constexpr auto kQuiet = 50ms;  // nobody writes that long while somebody drives
constexpr int kSilence = -1;
constexpr int kEnd = -2;

/// The wire to the motors: packets written to `device` are read at `motors`.
struct Wire {
  FileDescriptor device;
  FileDescriptor motors;
  Wire() {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
      std::abort();
    device.reset(ends[0]);
    motors.reset(ends[1]);
  }
  /// The first byte of the next packet and, in `second`, the second one; kSilence after `time`;
  /// kEnd when nobody holds the other end any more.
  int read(std::chrono::milliseconds time, std::uint8_t &second) const {
    pollfd wanted{.fd = motors.get(), .events = POLLIN, .revents = 0};
    if (poll(&wanted, 1, static_cast<int>(time.count())) != 1)
      return kSilence;
    std::array<std::uint8_t, 32> packet{};
    if (recv(motors.get(), packet.data(), packet.size(), 0) <= 0)
      return kEnd;
    second = packet[1];
    return packet[0];
  }
  /// Reads until `wanted` comes. False if it does not come at all.
  bool read_until(const std::array<std::uint8_t, 32> &wanted,
                  std::chrono::milliseconds patience = kForEver) const {
    std::uint8_t second = 0;
    int first = kSilence;
    do
      first = read(patience, second);
    while (first >= 0 && (first != wanted[0] || second != wanted[1]));
    return first >= 0;
  }
  /// Reads until nobody writes anything but the rest packet any more, or, after `patience`,
  /// anything at all. The time of the first of the last rest packets, or nothing.
  std::optional<Clock::time_point>
  time_of_rest(std::chrono::milliseconds patience = kForEver) const {
    std::optional<Clock::time_point> rest;
    std::uint8_t second = 0;
    while (!rest || Clock::now() - *rest < kQuiet) { // the guardian repeats it
      const int first = read(rest ? kQuiet : patience, second);
      if (first < 0)
        return rest;
      const bool is_rest = first == kRestPacket[0] && second == kRestPacket[1];
      if (!is_rest)
        rest.reset();
      else if (!rest)
        rest = Clock::now();
    }
    return rest;
  }
  /// Reads what is there already. Whether the last packet was the force packet; `before` if there
  /// is none.
  bool ends_with_force(bool before) const {
    std::uint8_t second = 0;
    for (int first = read(0ms, second); first >= 0; first = read(0ms, second))
      before = first == kForcePacket[0] && second == kForcePacket[1];
    return before;
  }
};

void write(int device, const std::array<std::uint8_t, 32> &packet) {
  send(device, packet.data(), packet.size(), MSG_NOSIGNAL);
}

/// Full force at 1 kHz until it is killed.
[[noreturn]] void drive(const Wire &wire) {
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  const test::AsTheLoop priority;
  for (auto next = Clock::now();;
       next = std::max(next + 1ms, Clock::now())) { // as the loop: no burst
    std::this_thread::sleep_until(next);
    const Watch watch = guardian.watch(true, Clock::now());
    if (watch == Watch::dead)
      _exit(1);
    const bool let_go = guardian.let_go();
    const bool may_pull = watch == Watch::kept && !let_go && !guardian.intervenes();
    write(wire.device.get(), may_pull ? kForcePacket : kNoticed);
  }
}

/// A process at full force, whose packets are on the wire already.
pid_t start_driver(Wire &wire) {
  const pid_t driver = fork();
  if (driver == 0) {
    wire.motors.reset();
    drive(wire);
  }
  wire.device.reset();
  EXPECT_TRUE(wire.read_until(kForcePacket));
  return driver;
}

void kill_and_wait(pid_t driver) {
  kill(driver, SIGKILL);
  waitpid(driver, nullptr, 0);
}

double milliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

std::string status_line(int process, const std::string &key) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(key + ":"))
      return line.substr(key.size() + 2);
  return "";
}

bool is_stopped(int process) {
  for (int i = 0; i < 10'000; ++i) {
    if (status_line(process, "State").starts_with("T"))
      return true;
    std::this_thread::sleep_for(1ms);
  }
  return false;
}

int rounds_wanted(int without) {
  const char *wanted = std::getenv("FEELING_WIND_KILLS");
  return wanted ? std::atoi(wanted) : without;
}

/// Stops `driver` at a random instant, lets it go on for a moment, and stops it again. The time for
/// which the motors had a force after that, ms; one that stays counts as kQuiet or more.
double force_after_two_stops(const Wire &wire, pid_t driver, std::mt19937 &random) {
  const auto wait_up_to = [&](unsigned microseconds) {
    std::this_thread::sleep_for(std::chrono::microseconds(random() % microseconds));
  };
  wait_up_to(3000); // three ticks
  kill(driver, SIGSTOP);
  wire.ends_with_force(true);
  if (!wire.read_until(kRestPacket, 1s)) { // stopped before it could tell of its force
    kill(driver, SIGCONT);
    return milliseconds(1s);
  }
  wait_up_to(6000); // longer than from one rest to the next
  kill(driver, SIGCONT);
  wait_up_to(300); // it has had most of a tick to do when it was stopped
  kill(driver, SIGSTOP);
  const auto begin = Clock::now();
  EXPECT_TRUE(is_stopped(driver));
  const bool was_force = wire.ends_with_force(false);
  bool force = was_force;
  while (force && Clock::now() - begin < kQuiet) {
    std::this_thread::sleep_for(100us);
    force = wire.ends_with_force(force);
  }
  const auto end = Clock::now();
  kill(driver, SIGCONT);
  return was_force ? milliseconds(end - begin) : 0;
}

/// Stops the driver at a random instant, round by round: nothing but the rest packet may be on the
/// wire in the end. Returns the time to it in the slowest round, ms. For the sake of that time, a
/// round in which the hypervisor took the processors away is played again.
double slowest_rest(int signal_number, unsigned seed) {
  const int rounds = rounds_wanted(40);
  std::mt19937 random(seed);
  const test::AsTheLoop priority; // the watch in the test must not be what is late
  double slowest = 0;
  int played_again = 0;
  for (int round = 0; round < rounds && !testing::Test::HasFailure(); ++round) {
    const long stolen = test::stolen_time();
    Wire wire;
    const pid_t driver = start_driver(wire);
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 8000));
    const auto begin = Clock::now();
    kill(driver, signal_number);
    const auto rest = wire.time_of_rest();
    EXPECT_TRUE(rest) << "the motors are not at rest in the end";
    kill_and_wait(driver);
    if (test::stolen_time() != stolen && played_again < 50) {
      ++played_again;
      --round;
    } else if (rest) {
      slowest = std::max(slowest, milliseconds(*rest - begin));
    }
  }
  test::report("played-again", played_again);
  return slowest;
}

void fill(int device) {
  while (send(device, kForcePacket.data(), kForcePacket.size(), MSG_NOSIGNAL | MSG_DONTWAIT) > 0) {
  }
}

/// Calls watch() at the same force until `wanted()`. False if it never is.
template <class Wanted>
bool watch_until(Guardian &guardian, bool force, Wanted wanted) {
  for (const auto end = Clock::now() + kForEver; Clock::now() < end;) {
    guardian.watch(force, Clock::now());
    if (wanted())
      return true;
    std::this_thread::sleep_for(1ms);
  }
  return false;
}

/// A program in the guardian's place, for the time of a test.
class Helper {
public:
  explicit Helper(const std::string &path) : real_(guardian_path()) {
    setenv("SPIDAR_GUARDIAN", path.c_str(), 1);
  }
  ~Helper() { setenv("SPIDAR_GUARDIAN", real_.c_str(), 1); }
  Helper(const Helper &) = delete;
  Helper &operator=(const Helper &) = delete;

  static std::string script(const std::string &lines) {
    std::string path = "/tmp/guardian-XXXXXX";
    const FileDescriptor file(mkstemp(path.data()));
    const std::string text = "#!/bin/sh\n" + lines + "\n";
    EXPECT_EQ(::write(file.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
    fchmod(file.get(), 0700);
    return path;
  }

private:
  std::string real_;
};

std::string refusal_by(const std::string &path) {
  const Wire wire;
  const Helper helper(path);
  try {
    const Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  } catch (const Error &error) {
    EXPECT_EQ(error.cause(), Cause::io);
    EXPECT_NE(std::string(error.what()).find(path), std::string::npos);
    return error.what();
  }
  ADD_FAILURE() << path;
  return "";
}

/// The order of a program, without a descriptor of the device.
std::vector<std::uint8_t> bare_order() {
  const GuardianOrder head{.endpoint = kEndpoint};
  std::vector<std::uint8_t> order(sizeof head + kRestPacket.size());
  std::memcpy(order.data(), &head, sizeof head);
  std::copy(kRestPacket.begin(), kRestPacket.end(), order.begin() + sizeof head);
  return order;
}

/// Plays systemd: starts the guardian, or another program, for each connection to the user's
/// socket.
class Service {
public:
  explicit Service(const std::string &program = guardian_path())
      : real_(guardian_path()), program_(program) {
    std::string folder = "/tmp/guardian-service-XXXXXX";
    folder_ = mkdtemp(folder.data());
    const sockaddr_un address = address_of_socket();
    listener_.reset(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    EXPECT_EQ(bind(listener_.get(), reinterpret_cast<const sockaddr *>(&address), sizeof address),
              0);
    EXPECT_EQ(listen(listener_.get(), 4), 0);
    setenv("XDG_RUNTIME_DIR", folder_.c_str(), 1);
    unsetenv("SPIDAR_GUARDIAN");
    systemd_ = fork();
    if (systemd_ == 0)
      serve();
    listener_.reset();
  }
  ~Service() {
    end();
    unsetenv("XDG_RUNTIME_DIR");
    setenv("SPIDAR_GUARDIAN", real_.c_str(), 1);
    std::filesystem::remove_all(folder_);
  }
  Service(const Service &) = delete;
  Service &operator=(const Service &) = delete;

  FileDescriptor connection() const {
    const sockaddr_un address = address_of_socket();
    FileDescriptor socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    EXPECT_EQ(connect(socket.get(), reinterpret_cast<const sockaddr *>(&address), sizeof address),
              0);
    return socket;
  }

  /// Nobody listens any more; the socket stays in its folder.
  void end() {
    if (systemd_ != 0) {
      kill(systemd_, SIGKILL);
      waitpid(systemd_, nullptr, 0);
    }
    systemd_ = 0;
  }

private:
  sockaddr_un address_of_socket() const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::snprintf(address.sun_path, sizeof address.sun_path, "%s/%s", folder_.c_str(),
                  kGuardianSocket);
    return address;
  }

  [[noreturn]] void serve() const {
    signal(SIGCHLD, SIG_IGN);
    for (;;) {
      const int connection = accept(listener_.get(), nullptr, nullptr);
      if (fork() != 0) {
        close(connection);
        continue;
      }
      setsid();
      if (connection != kGuardianControl)
        dup2(connection, kGuardianControl);
      close_range(kGuardianControl + 1, ~0U, 0);
      setenv("LISTEN_FDS", "1", 1);
      setenv("LISTEN_PID", std::to_string(getpid()).c_str(), 1);
      execl(program_.c_str(), program_.c_str(), nullptr);
      _exit(1);
    }
  }

  std::string real_;
  std::string program_;
  std::string folder_;
  FileDescriptor listener_;
  pid_t systemd_ = 0;
};

/// A cgroup of version 2 with room for the program and, beside it, the guardian.
class Cgroups {
public:
  Cgroups() {
    for (const char *mount : {"/sys/fs/cgroup", "/sys/fs/cgroup/unified"}) {
      const std::string group =
          std::string(mount) + own_path() + "/guardian-test-" + std::to_string(getpid());
      if (std::filesystem::exists(std::string(mount) + "/cgroup.procs") &&
          mkdir(group.c_str(), 0755) == 0)
        group_ = group;
    }
    usable_ = !group_.empty() && mkdir((group_ + "/program").c_str(), 0755) == 0 &&
              access((group_ + "/program/cgroup.kill").c_str(), W_OK) == 0;
  }
  ~Cgroups() {
    for (const char *name : {"/program", "/spidar-guardian", ""})
      for (int i = 0; i < 2000 && rmdir((group_ + name).c_str()) != 0 && errno == EBUSY; ++i)
        std::this_thread::sleep_for(1ms);
  }
  Cgroups(const Cgroups &) = delete;
  Cgroups &operator=(const Cgroups &) = delete;

  bool usable() const noexcept { return usable_; }
  bool enter() const { return put("/program/cgroup.procs", "0"); }
  bool kill_program() const { return put("/program/cgroup.kill", "1"); }
  bool freeze_program(bool frozen) const {
    return put("/program/cgroup.freeze", frozen ? "1" : "0");
  }

private:
  static std::string own_path() {
    std::ifstream file("/proc/self/cgroup");
    for (std::string line; std::getline(file, line);)
      if (line.starts_with("0::/"))
        return line == "0::/" ? "" : line.substr(3);
    return "";
  }
  bool put(const char *name, const char *text) const {
    std::ofstream file(group_ + name);
    file << text << std::flush;
    return file.good();
  }

  std::string group_;
  bool usable_ = false;
};

} // namespace

TEST(Guardian, F1_KilledAtFullForceTheMotorsEndAtRest) {
  test::report("kill-to-rest-ms", slowest_rest(SIGKILL, 1));
}

TEST(Guardian, F2_StoppedAtFullForceTheMotorsEndAtRest) {
  test::report("stop-to-rest-ms", slowest_rest(SIGSTOP, 2));
}

// In real time, since the number of losses is what counts: FEELING_WIND_KILLS=10000 for a note.
TEST(GuardianInRealTime, F2_StoppedTwiceAtRandomNoForceIsLeft) {
  const int rounds = rounds_wanted(200);
  std::mt19937 random(11);
  const test::AsTheLoop priority;
  Wire wire;
  const pid_t driver = start_driver(wire);
  double slowest = 0;
  int left = 0;
  int late = 0;
  for (int round = 0; round < rounds; ++round) {
    const double lasted = force_after_two_stops(wire, driver, random);
    slowest = std::max(slowest, lasted);
    left += lasted >= milliseconds(kQuiet);
    late += lasted > 15;
  }
  kill_and_wait(driver);
  test::report("double-stops", rounds);
  test::report("double-stop-to-rest-ms", slowest);
  test::report("double-stops-later-than-15-ms", late);
  EXPECT_EQ(left, 0) << "of " << rounds;
}

TEST(Guardian, F2_AProcessThatContinuesLearnsThatTheMotorsWereAtRest) {
  Wire wire;
  const pid_t driver = start_driver(wire);
  kill(driver, SIGSTOP);
  ASSERT_TRUE(wire.time_of_rest());
  kill(driver, SIGCONT);
  // One packet may have been under way when it was stopped.
  std::uint8_t second = 0;
  int packet = wire.read(kForEver, second);
  if (packet == kForcePacket[0])
    packet = wire.read(kForEver, second);
  EXPECT_EQ(packet, kNoticed[0]);
  // And it is guarded as before.
  kill_and_wait(driver);
  EXPECT_TRUE(wire.time_of_rest());
}

TEST(Guardian, F2_StoppedAgainJustAfterItWroteWhatItHadDecidedBeforeTheMotorsEndAtRest) {
  Wire wire;
  const pid_t driver = fork();
  if (driver == 0) {
    wire.motors.reset();
    Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
    guardian.watch(true, Clock::now());
    kill(getpid(), SIGSTOP);
    write(wire.device.get(), kForcePacket);
    kill(getpid(), SIGSTOP);
  }
  wire.device.reset();
  EXPECT_TRUE(is_stopped(driver));
  EXPECT_TRUE(wire.read_until(kRestPacket));
  kill(driver, SIGCONT);
  EXPECT_TRUE(wire.read_until(kForcePacket));
  EXPECT_TRUE(wire.time_of_rest(1s)) << "the motors keep the force";
  kill_and_wait(driver);
}

TEST(Guardian, F3_ADeadGuardianIsNoticed) {
  const Wire wire;
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  const test::AsTheLoop priority;
  ASSERT_EQ(guardian.watch(true, Clock::now()), Watch::kept);
  kill(guardian.process(), SIGKILL);
  const auto begin = Clock::now();
  Watch watch = Watch::kept;
  while (watch != Watch::dead && Clock::now() - begin < kForEver) {
    std::this_thread::sleep_for(1ms);
    watch = guardian.watch(true, Clock::now());
  }
  EXPECT_EQ(watch, Watch::dead);
  test::report("dead-guardian-noticed-ms", milliseconds(Clock::now() - begin));
}

TEST(Guardian, F3_AStoppedGuardianIsNoticedWithinTenTicks) {
  const Wire wire;
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  ASSERT_TRUE(watch_until(guardian, false, [] { return true; }));
  kill(guardian.process(), SIGSTOP);
  ASSERT_TRUE(is_stopped(guardian.process()));
  // Time is that of the ticks: 1 ms each.
  int ticks = 0;
  Clock::time_point now = Clock::now();
  while (guardian.watch(true, now) != Watch::silent && ticks < 1000) {
    now += 1ms;
    ++ticks;
  }
  EXPECT_LE(ticks, 10);
  for (int tick = 0; tick < 2000; ++tick)
    ASSERT_EQ(guardian.watch(false, now += 1ms), Watch::silent);
  kill(guardian.process(), SIGCONT);
  EXPECT_TRUE(watch_until(guardian, false,
                          [&] { return guardian.watch(false, Clock::now() + 1h) == Watch::kept; }));
}

TEST(Guardian, ItTriesUntilTheDeviceTakesThePacketAndOnlyThenSaysSo) {
  const Wire wire;
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  fill(wire.device.get());
  guardian.watch(true, Clock::now());
  std::this_thread::sleep_for(150ms); // more than it once had attempts for
  EXPECT_EQ(guardian.watch(true, Clock::now()), Watch::kept);
  EXPECT_FALSE(guardian.let_go());
  EXPECT_TRUE(guardian.intervenes());
  EXPECT_EQ(guardian.delivered(), 0);
  EXPECT_TRUE(wire.read_until(kRestPacket));
  EXPECT_TRUE(watch_until(guardian, true, [&] { return guardian.delivered() > 0; }));
  EXPECT_TRUE(guardian.let_go());
}

TEST(Guardian, KilledWhileTheDeviceTakesNothingTheMotorsEndAtRest) {
  Wire wire;
  const pid_t driver = fork();
  if (driver == 0) {
    Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
    guardian.watch(true, Clock::now());
    fill(wire.device.get());
    kill(getpid(), SIGSTOP);
  }
  ASSERT_TRUE(is_stopped(driver));
  wire.device.reset();
  kill_and_wait(driver);
  std::this_thread::sleep_for(200ms); // more than it once had attempts for
  EXPECT_TRUE(wire.time_of_rest());
}

enum class Fault { killed, frozen };

/// Kills or freezes the cgroup of a program at full force, with whatever else is in it.
void expect_rest(const Cgroups &groups, Fault fault, const std::string &name) {
  Wire wire;
  const pid_t driver = fork();
  if (driver == 0) {
    wire.motors.reset();
    if (!groups.enter())
      _exit(1);
    drive(wire);
  }
  wire.device.reset();
  ASSERT_TRUE(wire.read_until(kForcePacket));
  const auto begin = Clock::now();
  ASSERT_TRUE(fault == Fault::killed ? groups.kill_program() : groups.freeze_program(true));
  const auto rest = wire.time_of_rest();
  groups.freeze_program(false);
  kill_and_wait(driver);
  ASSERT_TRUE(rest);
  test::report(name, milliseconds(*rest - begin));
}

TEST(Guardian, TheHelperOutlivesTheProgramsCgroupWhereItMayLeaveIt) {
  const Cgroups groups;
  if (!groups.usable())
    GTEST_SKIP() << "no cgroup of version 2 may be made here";
  for (int round = 0; round < rounds_wanted(5) && !HasFatalFailure(); ++round) {
    expect_rest(groups, Fault::killed, "cgroup-kill-to-rest-ms");
    expect_rest(groups, Fault::frozen, "cgroup-freeze-to-rest-ms");
  }
}

TEST(Guardian, TheUsersServiceOutlivesTheProgramsCgroup) {
  const Cgroups groups;
  if (!groups.usable())
    GTEST_SKIP() << "no cgroup of version 2 may be made here";
  const Service service;
  for (int round = 0; round < rounds_wanted(5) && !HasFatalFailure(); ++round) {
    expect_rest(groups, Fault::killed, "service-cgroup-kill-to-rest-ms");
    expect_rest(groups, Fault::frozen, "service-cgroup-freeze-to-rest-ms");
  }
}

TEST(Guardian, TheUsersServiceIsPreferredAndOutlivesTheProgramsSession) {
  const Service service;
  for (int round = 0; round < rounds_wanted(5); ++round) {
    Wire wire;
    const pid_t driver = fork();
    if (driver == 0) {
      wire.motors.reset();
      setsid();
      drive(wire);
    }
    wire.device.reset();
    ASSERT_TRUE(wire.read_until(kForcePacket));
    const auto begin = Clock::now();
    kill(-driver, SIGKILL);
    const auto rest = wire.time_of_rest();
    ASSERT_TRUE(rest);
    test::report("service-kill-to-rest-ms", milliseconds(*rest - begin));
    waitpid(driver, nullptr, 0);
  }
}

/// What a program learns whose helper is `helper`, since the service does not watch.
std::string remark_with_helper(const std::string &helper) {
  setenv("SPIDAR_GUARDIAN", helper.c_str(), 1);
  const Wire wire;
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket, Guardian::kPatience, true);
  EXPECT_EQ(guardian.watch(false, Clock::now()), Watch::kept) << "the helper watches";
  return guardian.remark();
}

TEST(Guardian, AServiceThatDoesNotStartIsReplacedByTheHelperWithARemark) {
  const std::string real = guardian_path();
  const std::string older = Helper::script(R"(printf '\003\001\000\000\000' >&3; sleep 1)");
  for (const std::string &program : {std::string("/nowhere"), std::string("/bin/false"), older}) {
    const Service service(program); // with a masked template systemd closes the connection too
    EXPECT_NE(remark_with_helper(real).find("unmask"), std::string::npos) << program;
  }
  std::filesystem::remove(older);
  Service service;
  EXPECT_EQ(remark_with_helper(real), "") << "it watches";
  service.end();
  EXPECT_NE(remark_with_helper(real).find("Connection refused"), std::string::npos);
}

TEST(Guardian, WithoutADeviceItDoesNotSayThatItWatches) {
  const Service service;
  const FileDescriptor connection = service.connection();
  const std::vector<std::uint8_t> order = bare_order();
  ASSERT_EQ(send(connection.get(), order.data(), order.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(order.size()));
  pollfd answer{.fd = connection.get(), .events = POLLIN, .revents = 0};
  ASSERT_EQ(poll(&answer, 1, static_cast<int>(std::chrono::milliseconds(kForEver).count())), 1);
  GuardianNotice notice;
  EXPECT_EQ(recv(connection.get(), &notice, sizeof notice, 0), 0) << "it has ended";
}

TEST(Guardian, WithoutAServiceThereIsNothingToRemark) {
  EXPECT_EQ(remark_with_helper(guardian_path()), "");
}

TEST(Guardian, TheMotorsAreAtRestWhenItIsSentAway) {
  Wire wire;
  {
    const Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
    wire.device.reset();
  }
  std::uint8_t second = 0;
  EXPECT_EQ(wire.read(kForEver, second), kRestPacket[0]);
  EXPECT_EQ(wire.read(kForEver, second), kRestPacket[0]);
  EXPECT_EQ(wire.read(kForEver, second), kEnd);
}

TEST(Guardian, ItDoesNotMeddleWhileThereIsNoForce) {
  const Wire wire;
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  ASSERT_EQ(guardian.watch(false, Clock::now()), Watch::kept);
  std::uint8_t second = 0;
  EXPECT_EQ(wire.read(kQuiet, second), kSilence);
  EXPECT_EQ(guardian.watch(false, Clock::now()), Watch::kept);
  EXPECT_FALSE(guardian.let_go());
}

TEST(Guardian, ADriverWhoseExchangesMayTakeLongerGetsTheTime) {
  const Wire wire;
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket, 1s);
  ASSERT_EQ(guardian.watch(true, Clock::now()), Watch::kept);
  std::uint8_t second = 0;
  EXPECT_EQ(wire.read(kQuiet, second), kSilence);
  EXPECT_EQ(wire.read(kForEver, second), kRestPacket[0]);
}

TEST(Guardian, SignalsOfTheTerminalAreNotForIt) {
  const Wire wire;
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP})
    kill(guardian.process(), number);
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(guardian.watch(false, Clock::now()), Watch::kept);
  EXPECT_NE(getsid(guardian.process()), getsid(0));
}

TEST(Guardian, ItHasNoRightsThatItDoesNotNeed) {
  const Wire wire;
  const Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  EXPECT_EQ(status_line(guardian.process(), "NoNewPrivs"), "1");
  EXPECT_EQ(status_line(guardian.process(), "CapEff"), "0000000000000000");
  if (geteuid() == 0) {
    EXPECT_EQ(status_line(guardian.process(), "Uid").substr(0, 5), "65534");
  }
}

TEST(Guardian, LeavesNoChildToTheProgram) {
  const Wire wire;
  const Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(Guardian, ThatIsMissingOrEndsOrIsOfAnotherVersionIsRefusedWithACure) {
  EXPECT_NE(refusal_by("/nowhere").find("Install the guardian"), std::string::npos);
  EXPECT_NE(refusal_by("/bin/true").find("Start the program again"), std::string::npos);
  const std::string killed = Helper::script("kill -9 $$");
  EXPECT_NE(refusal_by(killed).find("ended while it started"), std::string::npos);
  // What version 1 answers: a byte, and its process number.
  const std::string older = Helper::script(R"(printf '\003\001\000\000\000' >&3; sleep 1 &)");
  EXPECT_NE(refusal_by(older).find("same package"), std::string::npos);
  std::filesystem::remove(killed);
  std::filesystem::remove(older);
}
