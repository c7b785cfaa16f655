// SPDX-License-Identifier: LGPL-2.1-or-later
#include "guardian.hpp"

#include "fail.hpp"
#include "guardian-protocol.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>

extern char **environ;

namespace spidar {

namespace {

constexpr auto kBetweenWords = std::chrono::milliseconds(3); // three of them within its patience
constexpr int kStartTime = 2000;                             // ms; a loaded machine starts slowly
constexpr int kEndTime = 200;                                // ms

struct SpawnActions {
  posix_spawn_file_actions_t actions{};
  posix_spawnattr_t attributes{};
  SpawnActions() {
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
  }
  ~SpawnActions() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnActions(const SpawnActions &) = delete;
  SpawnActions &operator=(const SpawnActions &) = delete;
};

[[noreturn]] void refuse(const std::string &reason) {
  fail(Cause::io, messages::kGuardian, guardian_path().c_str(), reason.c_str());
}

bool readable(int descriptor, int milliseconds) noexcept {
  pollfd wanted{.fd = descriptor, .events = POLLIN, .revents = 0};
  int ready = 0;
  do
    ready = poll(&wanted, 1, milliseconds);
  while (ready < 0 && errno == EINTR);
  return ready == 1;
}

/// Duplicates to a number above those that the guardian gets, so that no dup2() closes a source.
FileDescriptor duplicate(int descriptor) {
  FileDescriptor copy(fcntl(descriptor, F_DUPFD_CLOEXEC, kGuardianDevice + 1));
  if (copy.get() < 0)
    refuse(std::strerror(errno));
  return copy;
}

} // namespace

std::string guardian_path() {
  const char *told = secure_getenv("SPIDAR_GUARDIAN");
  return told ? told : SPIDAR_GUARDIAN_PATH;
}

Guardian::Guardian(int device, unsigned char endpoint, std::span<const std::uint8_t> packet) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    refuse(std::strerror(errno));
  socket_.reset(ends[0]);
  {
    const FileDescriptor theirs(ends[1]);
    start(device, theirs.get());
  } // only the guardian may hold its end, or its death would not close the socket
  std::array<std::uint8_t, 1 + kLargestGuardedPacket> order{endpoint};
  std::memcpy(order.data() + 1, packet.data(), packet.size());
  if (send(socket_.get(), order.data(), 1 + packet.size(), MSG_NOSIGNAL) < 0)
    refuse("it ended at once");
  await_ready();
}

void Guardian::start(int device, int control) {
  const FileDescriptor device_copy = duplicate(device);
  const FileDescriptor control_copy = duplicate(control);
  SpawnActions spawn;
  posix_spawn_file_actions_adddup2(&spawn.actions, control_copy.get(), kGuardianControl);
  posix_spawn_file_actions_adddup2(&spawn.actions, device_copy.get(), kGuardianDevice);
  // Its own session: the terminal sends it no Ctrl-C.
  posix_spawnattr_setflags(&spawn.attributes, POSIX_SPAWN_SETSID);
  std::string path = guardian_path();
  char *arguments[] = {path.data(), nullptr};
  pid_t started = 0;
  if (const int error = posix_spawn(&started, path.c_str(), &spawn.actions, &spawn.attributes,
                                    arguments, environ);
      error != 0)
    refuse(std::strerror(error));
  // It continues in a child of its own: this program gets no child that it does not expect.
  while (waitpid(started, nullptr, 0) < 0 && errno == EINTR) {
  }
}

void Guardian::await_ready() {
  std::array<std::uint8_t, 1 + sizeof process_> answer{};
  if (!readable(socket_.get(), kStartTime) ||
      recv(socket_.get(), answer.data(), answer.size(), 0) != static_cast<ssize_t>(answer.size()) ||
      answer[0] != kWatching)
    refuse("it does not answer");
  std::memcpy(&process_, answer.data() + 1, sizeof process_);
}

Guardian::~Guardian() {
  shutdown(socket_.get(), SHUT_WR);
  std::uint8_t word = 0;
  while (readable(socket_.get(), kEndTime) && recv(socket_.get(), &word, 1, 0) > 0) {
  }
}

bool Guardian::watch(bool force, Clock::time_point now) noexcept {
  std::uint8_t word = 0;
  const ssize_t received = recv(socket_.get(), &word, 1, MSG_DONTWAIT);
  let_go_ = let_go_ || (received == 1 && word == kLetGo);
  if (received == 0 || (received < 0 && errno == ECONNRESET))
    dead_ = true;
  if (dead_ || (force == force_ && now - last_word_ < kBetweenWords))
    return !dead_;
  const std::uint8_t state = force ? kForce : kRest;
  if (send(socket_.get(), &state, 1, MSG_DONTWAIT | MSG_NOSIGNAL) == 1) {
    last_word_ = now;
    force_ = force;
  } else if (errno == EPIPE || errno == ECONNRESET) {
    dead_ = true;
  }
  return !dead_;
}

} // namespace spidar
