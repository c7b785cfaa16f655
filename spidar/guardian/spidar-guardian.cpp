// SPDX-License-Identifier: LGPL-2.1-or-later
// spidar-guardian: puts the motors at rest if the process that drives them dies or hangs. Started
// by guardian.hpp, or by systemd for a connection to its socket. It uses the kernel only, allocates
// nothing while it watches, and may do nothing but write to the device that it was given.
#include "guard/guardian-protocol.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <grp.h>
#include <initializer_list>
#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace spidar;

namespace {

constexpr int kRealTimePriority = 51; // above the loop that it watches
constexpr unsigned kWriteTime = 5;    // ms for one attempt
constexpr timespec kBetweenAttempts{.tv_sec = 0, .tv_nsec = 1'000'000};
constexpr int kWritesAtTheEnd = 2; // a controller may lose one
constexpr int kAttemptsAtRest = 10;
constexpr uid_t kNobody = 65534;

enum class Written {
  delivered,
  refused, ///< the device takes nothing now
  gone     ///< there is no device any more
};

class Motors {
public:
  /// Receives the order and, from a process that did not start us, the device. False without one.
  bool receive_order() {
    std::array<unsigned char, sizeof(GuardianOrder) + kLargestGuardedPacket> bytes{};
    alignas(cmsghdr) std::array<unsigned char, CMSG_SPACE(sizeof(int))> extra{};
    iovec part{.iov_base = bytes.data(), .iov_len = bytes.size()};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = extra.data();
    message.msg_controllen = extra.size();
    const ssize_t size = recvmsg(kGuardianControl, &message, 0);
    if (size < 1)
      return false;
    accept_device(message);
    GuardianOrder order;
    version_matches_ = bytes[0] == order.version;
    if (!version_matches_)
      return true;
    if (size <= static_cast<ssize_t>(sizeof order))
      return false;
    std::memcpy(&order, bytes.data(), sizeof order);
    endpoint_ = order.endpoint;
    patience_ = order.patience;
    size_ = static_cast<unsigned>(size) - static_cast<unsigned>(sizeof order);
    std::memcpy(packet_, bytes.data() + sizeof order, size_);
    struct stat status = {};
    if (fstat(kGuardianDevice, &status) != 0)
      return false;
    is_socket_ = S_ISSOCK(status.st_mode);
    return true;
  }

  bool version_matches() const noexcept { return version_matches_; }
  int patience() const noexcept { return patience_; }

  Written rest() noexcept {
    if (write()) {
      ++delivered_;
      return Written::delivered;
    }
    switch (errno) {
    case ENODEV:
    case ESHUTDOWN:
    case ECONNRESET:
    case ENOTCONN:
    case ENOTTY: // the four after these: no attempt can ever succeed
    case EBADF:
    case EINVAL:
    case ENOENT:
      return Written::gone;
    case EPIPE:
      if (is_socket_)
        return Written::gone;
      ioctl(kGuardianDevice, USBDEVFS_CLEAR_HALT, &endpoint_);
      return Written::refused;
    default:
      return Written::refused;
    }
  }

  std::uint32_t delivered() const noexcept { return delivered_; }

private:
  static void accept_device(msghdr &message) {
    const cmsghdr *header = CMSG_FIRSTHDR(&message);
    if (!header || header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_RIGHTS)
      return;
    int device = -1;
    std::memcpy(&device, CMSG_DATA(header), sizeof device);
    if (device == kGuardianDevice)
      return;
    dup2(device, kGuardianDevice);
    close(device);
  }

  bool write() noexcept {
    if (is_socket_)
      return send(kGuardianDevice, packet_, size_, MSG_NOSIGNAL | MSG_DONTWAIT) ==
             static_cast<ssize_t>(size_);
    usbdevfs_bulktransfer transfer{
        .ep = endpoint_, .len = size_, .timeout = kWriteTime, .data = packet_};
    return ioctl(kGuardianDevice, USBDEVFS_BULK, &transfer) == static_cast<int>(size_);
  }

  unsigned char packet_[kLargestGuardedPacket]{};
  unsigned size_ = 0;
  unsigned endpoint_ = 0;
  int patience_ = kGuardianPatience; ///< ms of silence under a force
  std::uint32_t delivered_ = 0;
  bool is_socket_ = false;
  bool version_matches_ = false;
};

// Ignores signals.
void ignore_signals() {
  for (const int number :
       {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1, SIGUSR2})
    signal(number, SIG_IGN);
}

// Closes the program's files: a pipe on its output must end with the program.
void leave_files(bool service) {
  const int nothing = open("/dev/null", O_RDWR);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    dup2(nothing, standard);
  close_range(service ? kGuardianDevice : kGuardianDevice + 1, ~0U, 0);
  if (chdir("/") != 0)
    _exit(1);
}

// Whether systemd started us with a connection to our socket, as sd_listen_fds(3) describes it.
bool is_service() {
  const char *process = std::getenv("LISTEN_PID");
  const char *count = std::getenv("LISTEN_FDS");
  return process && count && std::strtol(process, nullptr, 10) == getpid() &&
         std::strcmp(count, "1") == 0;
}

bool write_file(const char *path, const char *text) {
  const int file = open(path, O_WRONLY | O_CLOEXEC);
  if (file < 0)
    return false;
  const auto size = static_cast<ssize_t>(std::strlen(text));
  const bool written = write(file, text, static_cast<std::size_t>(size)) == size;
  close(file);
  return written;
}

// The path of our cgroup below the mount point, of cgroup v2; false if there is none.
bool own_cgroup(std::array<char, 512> &path) {
  FILE *file = std::fopen("/proc/self/cgroup", "re");
  if (!file)
    return false;
  std::array<char, 512> line{};
  bool found = false;
  while (!found && std::fgets(line.data(), line.size(), file))
    found = std::strncmp(line.data(), "0::/", 4) == 0;
  std::fclose(file);
  if (!found)
    return false;
  line[std::strcspn(line.data(), "\n")] = '\0';
  std::snprintf(path.data(), path.size(), "%s", line.data() + 3);
  return true;
}

// Moves to a cgroup beside the program's where this user may, so that killing the program's does
// not kill us. A cgroup with controllers may hold no processes, so first the group above, then a
// new one in it.
void leave_cgroup() {
  std::array<char, 512> group{};
  if (!own_cgroup(group))
    return;
  char *last = std::strrchr(group.data(), '/');
  if (std::strcmp(group.data(), "/") == 0)
    return;
  *last = '\0';
  for (const char *mount : {"/sys/fs/cgroup", "/sys/fs/cgroup/unified"}) {
    std::array<char, 640> path{};
    std::snprintf(path.data(), path.size(), "%s%s/spidar-guardian", mount, group.data());
    if (mkdir(path.data(), 0755) != 0 && errno != EEXIST)
      continue;
    std::snprintf(path.data(), path.size(), "%s%s/spidar-guardian/cgroup.procs", mount,
                  group.data());
    if (write_file(path.data(), "0"))
      return;
  }
}

// Sets the priority first: that may need the privileges.
void drop_privileges() {
  const sched_param priority{.sched_priority = kRealTimePriority};
  sched_setscheduler(0, SCHED_FIFO, &priority); // without it, it is only slower
  mlockall(MCL_CURRENT | MCL_FUTURE);
  if (geteuid() == 0 && (setgroups(0, nullptr) != 0 || setresgid(kNobody, kNobody, kNobody) != 0 ||
                         setresuid(kNobody, kNobody, kNobody) != 0))
    setgroups(0, nullptr); // in a container that has no such user it stays who it is
  const rlimit none{0, 0};
  for (const auto resource : {RLIMIT_NPROC, RLIMIT_FSIZE, RLIMIT_CORE})
    setrlimit(resource, &none);
  const rlimit one{1, 1}; // poll() needs one; no further descriptor can be opened
  setrlimit(RLIMIT_NOFILE, &one);
  prctl(PR_SET_DUMPABLE, 0);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
}

bool notify(std::uint8_t kind, std::uint32_t value) {
  const GuardianNotice notice{.kind = kind, .value = value};
  return send(kGuardianControl, &notice, sizeof notice, MSG_NOSIGNAL | MSG_DONTWAIT) ==
         sizeof notice;
}

// Watches until the process ends. Returns whether a force may be left.
bool watch(Motors &motors) {
  bool force = false;
  bool writing = false;
  for (;;) {
    pollfd control{.fd = kGuardianControl, .events = POLLIN, .revents = 0};
    const int patience = writing ? 0 : motors.patience();
    const int ready = poll(&control, 1, force ? patience : -1);
    if (ready < 0 && errno == EINTR)
      continue;
    if (ready == 0) {
      if (!writing)
        notify(kWriting, motors.delivered());
      writing = true;
      const Written written = motors.rest();
      if (written == Written::refused) {
        nanosleep(&kBetweenAttempts, nullptr);
        continue;
      }
      notify(written == Written::delivered ? kLetGo : kHere, motors.delivered());
      force = writing = false;
      continue;
    }
    unsigned char word = 0;
    if (ready < 0 || recv(kGuardianControl, &word, 1, 0) != 1)
      return force; // it has ended
    force = word == kForce;
    writing = writing && force;
    notify(writing ? kWriting : kHere, motors.delivered());
  }
}

// Writes the rest packet until it was delivered, or the device is gone.
void end_at_rest(Motors &motors, bool force) {
  int delivered = 0;
  for (int attempt = 0; delivered < kWritesAtTheEnd; ++attempt) {
    const Written written = motors.rest();
    if (written == Written::gone)
      return;
    if (written == Written::delivered) {
      ++delivered;
      continue;
    }
    // At rest already, or for the second one, a limit: a device that takes nothing stays claimed.
    if ((!force || delivered > 0) && attempt >= kAttemptsAtRest)
      return;
    nanosleep(&kBetweenAttempts, nullptr);
  }
}

} // namespace

int main() {
  const bool service = is_service();
  ignore_signals();
  leave_files(service);
  if (!service && fork() != 0)
    _exit(0); // the starting process keeps no child
  Motors motors;
  if (!motors.receive_order())
    return 1;
  if (!motors.version_matches()) {
    notify(kOtherVersion, 0);
    return 1;
  }
  if (!service) // which has a cgroup of its own
    leave_cgroup();
  drop_privileges();
  bool force = false;
  if (notify(kWatching, static_cast<std::uint32_t>(getpid())))
    force = watch(motors);
  end_at_rest(motors, force);
  _exit(0);
}
