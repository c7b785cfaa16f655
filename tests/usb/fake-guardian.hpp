// SPDX-License-Identifier: LGPL-2.1-or-later
// The user's guardian service in the test's process, since only this process sees a device on
// MockBus: as it is, or played by the test, which says what it does and when.
#pragma once

#include "guarded-motors.hpp"
#include "mock-unit.hpp"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <gtest/gtest.h>
#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>

namespace test {

/// The socket of the user's guardian service, in a folder of its own.
class ServiceSocket {
public:
  ServiceSocket() {
    std::string folder = "/tmp/fake-guardian-XXXXXX";
    folder_ = mkdtemp(folder.data());
    if (const char *helper = std::getenv("SPIDAR_GUARDIAN"))
      helper_ = helper;
    unsetenv("SPIDAR_GUARDIAN");
    setenv("XDG_RUNTIME_DIR", folder_.c_str(), 1);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, (folder_ + "/" + spidar::kGuardianSocket).c_str());
    listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr *>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listener_, 1), 0);
  }
  ~ServiceSocket() {
    close(listener_);
    std::filesystem::remove_all(folder_);
    unsetenv("XDG_RUNTIME_DIR");
    setenv("SPIDAR_GUARDIAN", helper_.c_str(), 1);
  }
  ServiceSocket(const ServiceSocket &) = delete;
  ServiceSocket &operator=(const ServiceSocket &) = delete;

  int get() const noexcept { return listener_; }

private:
  std::string folder_;
  std::string helper_;
  int listener_ = -1;
};

/// As the real one has, where it is allowed.
inline void take_priority_of_guardian() {
  const sched_param priority{.sched_priority = 51};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
}

/// What the real guardian does, in a thread of this process: it can write to a device on MockBus.
class ThreadedGuardian {
public:
  ThreadedGuardian() : thread_([this](const std::stop_token &stop) { run(stop); }) {}
  ~ThreadedGuardian() {
    thread_.request_stop();
    shutdown(socket_.get(), SHUT_RDWR);
    shutdown(control_, SHUT_RDWR); // of a device that a failed test has left open
  }
  ThreadedGuardian(const ThreadedGuardian &) = delete;
  ThreadedGuardian &operator=(const ThreadedGuardian &) = delete;

private:
  void run(const std::stop_token &stop) {
    take_priority_of_guardian();
    while (!stop.stop_requested()) {
      control_ = accept(socket_.get(), nullptr, nullptr);
      if (control_ < 0)
        continue;
      spidar::GuardedMotors motors(control_, -1);
      if (motors.receive_order())
        motors.guard();
      close(control_.exchange(-1));
    }
  }

  ServiceSocket socket_;
  std::atomic<int> control_ = -1;
  std::jthread thread_;
};

class FakeGuardian {
public:
  FakeGuardian() : thread_([this](const std::stop_token &stop) { run(stop); }) {}
  FakeGuardian(const FakeGuardian &) = delete;
  FakeGuardian &operator=(const FakeGuardian &) = delete;

  /// As if it was stopped: from the return on it reads and answers nothing.
  void stop() {
    stopped_ = true;
    while (!quiet_)
      std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  void go_on() { stopped_ = false; }
  /// As if it was killed.
  void die() { shutdown(control_, SHUT_RDWR); }

  /// What the driver has told last. Waits until it is `word`.
  bool is_told(std::uint8_t word) const {
    for (int i = 0; i < 100'000 && told_ != word; ++i)
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    return told_ == word;
  }

  // The parts of an intervention.
  void announce() {
    ++intervention_;
    notify(spidar::kResting);
  }
  void write(MockUnit &unit) {
    unit.use([&](emulator::Unit &u) { u.firmware().receive(rest_, emulator::Clock::now()); });
    ++delivered_;
  }
  void finish() { notify(spidar::kHere); }
  /// Nothing of it was delivered, and the driver has put the motors at rest meanwhile.
  void give_up() { notify(spidar::kHere); }
  void intervene(MockUnit &unit, int packets = 1) {
    for (int i = 0; i < packets; ++i) {
      announce();
      write(unit);
      finish();
    }
  }

  /// From now on it intervenes as the real one does: when it hears nothing under a force.
  void guard(MockUnit &unit) { guarded_ = &unit; }
  int interventions() const { return interventions_; }

private:
  using Clock = std::chrono::steady_clock;

  void intervene_after_silence() {
    MockUnit *unit = guarded_;
    if (!unit || control_ < 0 || told_ != spidar::kForce ||
        Clock::now() - heard_ < std::chrono::milliseconds(spidar::kGuardianPatience))
      return;
    intervene(*unit);
    told_ = spidar::kRest;
    ++interventions_;
  }

  void notify(std::uint8_t kind, std::uint32_t value) {
    const spidar::GuardianNotice notice{
        .kind = kind, .intervention = intervention_, .value = value};
    send(control_, &notice, sizeof notice, MSG_NOSIGNAL);
  }
  void notify(std::uint8_t kind) {
    resting_ = kind == spidar::kResting;
    notify(kind, delivered_);
  }

  static bool readable(int socket) {
    pollfd wanted{.fd = socket, .events = POLLIN, .revents = 0};
    return poll(&wanted, 1, 0) == 1;
  }

  void run(const std::stop_token &stop) {
    take_priority_of_guardian();
    while (!stop.stop_requested()) {
      quiet_ = stopped_.load();
      if (control_ < 0 ? !readable(socket_.get()) : quiet_ || !readable(control_)) {
        intervene_after_silence();
        std::this_thread::sleep_for(std::chrono::microseconds(100));
      } else if (control_ < 0)
        accept_process();
      else
        read_word();
    }
    if (control_ >= 0)
      close(control_);
  }

  void accept_process() {
    delivered_ = 0;
    const int control = accept(socket_.get(), nullptr, nullptr);
    std::array<std::uint8_t, 600> order{};
    const ssize_t size = recv(control, order.data(), order.size(), 0);
    const auto *begin = order.data() + sizeof(spidar::GuardianOrder);
    rest_.assign(begin, static_cast<const std::uint8_t *>(order.data()) + size);
    control_ = control;
    notify(spidar::kWatching, static_cast<std::uint32_t>(getpid()));
  }

  void read_word() {
    spidar::GuardianWord word;
    if (recv(control_, &word, sizeof word, 0) == sizeof word) {
      told_ = word.state;
      heard_ = Clock::now();
      notify(resting_ ? spidar::kResting : spidar::kHere, delivered_);
      return;
    }
    close(control_);
    control_ = -1;
  }

  ServiceSocket socket_;
  std::atomic<int> control_ = -1;
  std::atomic<bool> stopped_ = false;
  std::atomic<bool> quiet_ = false;
  std::atomic<bool> resting_ = false;
  std::atomic<std::uint8_t> intervention_ = 0;
  std::atomic<int> told_ = -1;
  std::atomic<MockUnit *> guarded_ = nullptr;
  std::atomic<int> interventions_ = 0;
  Clock::time_point heard_{}; ///< of the thread
  std::atomic<std::uint32_t> delivered_ = 0;
  Bytes rest_;
  std::jthread thread_;
};

} // namespace test
