// SPDX-License-Identifier: LGPL-2.1-or-later
#include "guard/guardian.hpp"

#include "fail.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>

extern char **environ;

namespace spidar {

namespace {

constexpr auto kBetweenWords = std::chrono::microseconds(1500); // every second tick of 1 ms
// After at most two ticks of 1 ms without a word: a stopped guardian is noticed within 10 ms.
constexpr auto kAnswerTime = std::chrono::milliseconds(4);
constexpr int kStartTime = 2000; // ms; a loaded machine starts slowly
constexpr int kEndTime = 200;    // ms
constexpr int kMostUnanswered = 3;
constexpr int kMostNotices = 32; // a call

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

FileDescriptor make_socket() {
  return FileDescriptor(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
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

bool guardian_service_wanted() {
  return !secure_getenv("SPIDAR_GUARDIAN");
}

Guardian::Guardian(int device, unsigned char endpoint, std::span<const std::uint8_t> packet,
                   std::chrono::milliseconds patience, bool use_service,
                   unsigned char reply_endpoint) {
  static_assert(kPatience.count() == kGuardianPatience);
  const GuardianOrder head{.endpoint = endpoint,
                           .patience = static_cast<std::uint16_t>(patience.count()),
                           .reply_endpoint = reply_endpoint};
  std::array<std::uint8_t, sizeof head + kLargestGuardedPacket> bytes{};
  std::memcpy(bytes.data(), &head, sizeof head);
  std::memcpy(bytes.data() + sizeof head, packet.data(), packet.size());
  const std::span<const std::uint8_t> order(bytes.data(), sizeof head + packet.size());
  if (use_service && connect_to_service(device, order))
    return;
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    refuse(std::strerror(errno));
  socket_.reset(ends[0]);
  {
    const FileDescriptor theirs(ends[1]);
    start_helper(device, theirs.get());
  } // only the guardian may hold its end, or its death would not close the socket
  if (send(socket_.get(), order.data(), order.size(), MSG_NOSIGNAL) < 0 || !await_ready())
    fail(Cause::io, messages::kGuardianEnded, guardian_path().c_str());
}

/// False if the user has no such service, or it does not watch.
bool Guardian::connect_to_service(int device, std::span<const std::uint8_t> order) {
  const char *folder = secure_getenv("XDG_RUNTIME_DIR");
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = std::string(folder ? folder : "") + "/" + kGuardianSocket;
  if (!folder || path.size() >= sizeof address.sun_path)
    return false;
  std::memcpy(address.sun_path, path.c_str(), path.size() + 1);
  socket_ = make_socket();
  const bool connected =
      connect(socket_.get(), reinterpret_cast<const sockaddr *>(&address), sizeof address) == 0;
  if (!connected && errno == ENOENT)
    return false;
  ucred peer{};
  socklen_t size = sizeof peer;
  if (connected && (getsockopt(socket_.get(), SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0 ||
                    (peer.uid != geteuid() && peer.uid != 0)))
    return false;
  if (connected && send_order(device, order) && service_watches())
    return true;
  if (remark_.empty())
    remark_ = formatted(messages::kGuardianService, connected ? "it ends" : std::strerror(errno));
  return false;
}

/// Sends the order with the device.
bool Guardian::send_order(int device, std::span<const std::uint8_t> order) const {
  iovec part{.iov_base = const_cast<std::uint8_t *>(order.data()), .iov_len = order.size()};
  alignas(cmsghdr) std::array<unsigned char, CMSG_SPACE(sizeof(int))> extra{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = extra.data();
  message.msg_controllen = extra.size();
  cmsghdr *header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET;
  header->cmsg_type = SCM_RIGHTS;
  header->cmsg_len = CMSG_LEN(sizeof device);
  std::memcpy(CMSG_DATA(header), &device, sizeof device);
  return sendmsg(socket_.get(), &message, MSG_NOSIGNAL) >= 0;
}

bool Guardian::service_watches() {
  try {
    return await_ready();
  } catch (const Error &) {
    remark_ = formatted(messages::kGuardianService, "it is of another version, or too slow");
    return false;
  }
}

void Guardian::start_helper(int device, int control) {
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

/// False if it has ended. Throws Error (io) if it is of no use.
bool Guardian::await_ready() {
  GuardianNotice notice;
  if (!readable(socket_.get(), kStartTime))
    fail(Cause::io, messages::kGuardianSilent, guardian_path().c_str());
  const ssize_t size = recv(socket_.get(), &notice, sizeof notice, 0);
  if (size <= 0)
    return false;
  if (size != sizeof notice || notice.kind != kWatching || notice.version != kGuardianVersion)
    fail(Cause::io, messages::kGuardianVersion, guardian_path().c_str());
  process_ = static_cast<int>(notice.value);
  return true;
}

bool Guardian::end() noexcept {
  if (socket_.get() < 0)
    return true;
  shutdown(socket_.get(), SHUT_WR);
  GuardianNotice notice;
  bool has_ended = false;
  while (!has_ended && readable(socket_.get(), kEndTime))
    has_ended = recv(socket_.get(), &notice, sizeof notice, 0) <= 0;
  socket_.reset();
  return has_ended;
}

void Guardian::read_notices() noexcept {
  for (int i = 0; i < kMostNotices && !dead_; ++i) {
    GuardianNotice notice;
    const ssize_t size = recv(socket_.get(), &notice, sizeof notice, MSG_DONTWAIT);
    if (size == 0 || (size < 0 && errno == ECONNRESET))
      dead_ = true;
    if (size != sizeof notice)
      return;
    unanswered_ = 0;
    intervenes_ = notice.kind == kResting;
    intervention_ = notice.intervention;
    const std::uint32_t delivered = notice.value - std::exchange(delivered_before_, notice.value);
    let_go_ = let_go_ || delivered != 0;
    delivered_ += delivered;
    replies_ += notice.replies - std::exchange(replies_before_, notice.replies);
  }
}

Guardian::Watch Guardian::watch(bool force, Clock::time_point now) noexcept {
  read_notices();
  const GuardianWord word{.state = force ? kForce : kRest, .intervention = intervention_};
  const bool news = word.state != told_.state || word.intervention != told_.intervention;
  if (!dead_ && (news || unsent_ || now - last_word_ >= kBetweenWords)) {
    unsent_ = send(socket_.get(), &word, sizeof word, MSG_DONTWAIT | MSG_NOSIGNAL) != sizeof word;
    if (unsent_ && (errno == EPIPE || errno == ECONNRESET))
      dead_ = true;
    if (!unsent_)
      told_ = word;
    if (unanswered_++ == 0)
      first_unanswered_ = now;
    last_word_ = now;
  }
  if (dead_)
    return Watch::dead;
  // Several, so that a process that stood still itself reads the answer before it judges.
  const bool silent = unanswered_ >= kMostUnanswered && now - first_unanswered_ >= kAnswerTime;
  // It would not expect a force that it was not told of.
  return silent || unsent_ ? Watch::silent : Watch::kept;
}

} // namespace spidar
