// SPDX-License-Identifier: LGPL-2.1-or-later
// spidar-guardian: puts the motors at rest if the process that drives them dies or hangs. Started
// by guardian.hpp. It uses the kernel only, allocates nothing while it watches, and may do nothing
// but write to the device that it was given.
#include "guardian-protocol.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>
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
constexpr unsigned kWriteTime = 20;   // ms for one attempt
constexpr int kAttempts = 50;
constexpr int kWritesAtTheEnd = 2; // a controller may lose one
constexpr uid_t kNobody = 65534;

class Motors {
public:
  bool receive_order() {
    unsigned char order[1 + kLargestGuardedPacket];
    const ssize_t size = recv(kGuardianControl, order, sizeof order, 0);
    if (size < 2)
      return false;
    endpoint_ = order[0];
    size_ = static_cast<unsigned>(size - 1);
    std::memcpy(packet_, order + 1, size_);
    struct stat status = {};
    is_socket_ = fstat(kGuardianDevice, &status) == 0 && S_ISSOCK(status.st_mode);
    return true;
  }

  void rest() noexcept {
    for (int attempt = 0; attempt < kAttempts && !write(); ++attempt) {
      if (errno == ENODEV || errno == ESHUTDOWN || errno == ENOTTY)
        return; // unplugged: nothing is left to be done
      if (errno == EPIPE && !is_socket_)
        ioctl(kGuardianDevice, USBDEVFS_CLEAR_HALT, &endpoint_);
    }
  }

private:
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
  bool is_socket_ = false;
};

// Ignores signals.
void ignore_signals() {
  for (const int number :
       {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGTSTP, SIGTTIN, SIGTTOU, SIGUSR1, SIGUSR2})
    signal(number, SIG_IGN);
}

// Closes the program's files: a pipe on its output must end with the program.
void leave_files() {
  const int nothing = open("/dev/null", O_RDWR);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    dup2(nothing, standard);
  close_range(kGuardianDevice + 1, ~0U, 0);
  if (chdir("/") != 0)
    _exit(1);
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

bool say_ready() {
  const pid_t self = getpid();
  unsigned char answer[1 + sizeof self] = {kWatching};
  std::memcpy(answer + 1, &self, sizeof self);
  return send(kGuardianControl, answer, sizeof answer, MSG_NOSIGNAL) == sizeof answer;
}

void watch(Motors &motors) {
  bool force = false;
  for (;;) {
    pollfd control{.fd = kGuardianControl, .events = POLLIN, .revents = 0};
    const int ready = poll(&control, 1, force ? kGuardianPatience : -1);
    if (ready < 0 && errno == EINTR)
      continue;
    if (ready == 0) {
      motors.rest();
      send(kGuardianControl, &kLetGo, 1, MSG_NOSIGNAL | MSG_DONTWAIT);
      force = false;
      continue;
    }
    unsigned char word = 0;
    if (ready < 0 || recv(kGuardianControl, &word, 1, 0) != 1)
      return; // it has ended
    force = word == kForce;
  }
}

} // namespace

int main() {
  ignore_signals();
  leave_files();
  if (fork() != 0)
    _exit(0); // the starting process keeps no child
  Motors motors;
  if (!motors.receive_order())
    return 1;
  drop_privileges();
  if (say_ready())
    watch(motors);
  for (int i = 0; i < kWritesAtTheEnd; ++i)
    motors.rest();
  _exit(0);
}
