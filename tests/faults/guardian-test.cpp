// SPDX-License-Identifier: LGPL-2.1-or-later
// The guardian, with a socket in the device's place: umockdev cannot lend its usbfs to another
// program. All else is real: the library's side, the helper program, processes that are killed.
// The tests ask what is on the wire in the end; the times are reported.
#include "guardian-protocol.hpp"
#include "guardian.hpp"
#include "loop-priority.hpp"
#include "report-line.hpp"
#include "stolen-time.hpp"

#include "spidar/error.hpp"

#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <poll.h>
#include <random>
#include <sys/socket.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <vector>

namespace {

using namespace std::chrono_literals;
using namespace spidar;
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
  bool read_until(const std::array<std::uint8_t, 32> &wanted) const {
    std::uint8_t second = 0;
    int first = kSilence;
    do
      first = read(kForEver, second);
    while (first >= 0 && (first != wanted[0] || second != wanted[1]));
    return first >= 0;
  }
  /// Reads until nobody writes any more. The time of the last packet if that is the rest packet, or
  /// nothing.
  std::optional<Clock::time_point> time_of_rest() const {
    std::optional<Clock::time_point> rest;
    std::uint8_t second = 0;
    for (;;) {
      const int first = read(rest ? kQuiet : kForEver, second);
      if (first < 0)
        return rest;
      const bool is_rest = first == kRestPacket[0] && second == kRestPacket[1];
      if (!is_rest)
        rest.reset();
      else if (!rest) // the guardian repeats it at its end
        rest = Clock::now();
    }
  }
};

void write(int device, const std::array<std::uint8_t, 32> &packet) {
  send(device, packet.data(), packet.size(), MSG_NOSIGNAL);
}

/// Full force at 1 kHz until it is killed.
[[noreturn]] void drive(const Wire &wire) {
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  const test::AsTheLoop priority;
  for (auto next = Clock::now();; next += 1ms) {
    std::this_thread::sleep_until(next);
    if (!guardian.watch(true, Clock::now()))
      _exit(1);
    write(wire.device.get(), guardian.let_go() ? kNoticed : kForcePacket);
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

/// Stops the driver at a random instant, round by round: nothing but the rest packet may be on the
/// wire in the end. Returns the time to it in the slowest round, ms. For the sake of that time, a
/// round in which the hypervisor took the processors away is played again.
double slowest_rest(int signal_number, unsigned seed) {
  const char *wanted = std::getenv("FEELING_WIND_KILLS");
  const int rounds = wanted ? std::atoi(wanted) : 40;
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

std::string status_line(int process, const std::string &key) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(key + ":"))
      return line.substr(key.size() + 2);
  return "";
}

} // namespace

TEST(Guardian, F1_KilledAtFullForceTheMotorsEndAtRest) {
  test::report("kill-to-rest-ms", slowest_rest(SIGKILL, 1));
}

TEST(Guardian, F2_StoppedAtFullForceTheMotorsEndAtRest) {
  test::report("stop-to-rest-ms", slowest_rest(SIGSTOP, 2));
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

TEST(Guardian, F3_ADeadGuardianIsNoticed) {
  const Wire wire;
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  const test::AsTheLoop priority;
  ASSERT_TRUE(guardian.watch(true, Clock::now()));
  kill(guardian.process(), SIGKILL);
  const auto begin = Clock::now();
  bool alive = true;
  while (alive && Clock::now() - begin < kForEver) {
    std::this_thread::sleep_for(1ms);
    alive = guardian.watch(true, Clock::now());
  }
  EXPECT_FALSE(alive);
  test::report("dead-guardian-noticed-ms", milliseconds(Clock::now() - begin));
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
  ASSERT_TRUE(guardian.watch(false, Clock::now()));
  std::uint8_t second = 0;
  EXPECT_EQ(wire.read(kQuiet, second), kSilence);
  EXPECT_TRUE(guardian.watch(false, Clock::now()));
  EXPECT_FALSE(guardian.let_go());
}

TEST(Guardian, SignalsOfTheTerminalAreNotForIt) {
  const Wire wire;
  Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP})
    kill(guardian.process(), number);
  std::this_thread::sleep_for(20ms);
  EXPECT_TRUE(guardian.watch(false, Clock::now()));
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

TEST(Guardian, ThatIsNoneOrSaysNothingIsRefused) {
  const Wire wire;
  const std::string real = guardian_path();
  for (const char *path : {"/nowhere", "/bin/true"}) {
    setenv("SPIDAR_GUARDIAN", path, 1);
    try {
      const Guardian guardian(wire.device.get(), kEndpoint, kRestPacket);
      ADD_FAILURE() << path;
    } catch (const Error &error) {
      EXPECT_EQ(error.cause(), Cause::io);
      EXPECT_NE(std::string(error.what()).find(path), std::string::npos);
    }
  }
  setenv("SPIDAR_GUARDIAN", real.c_str(), 1);
}
