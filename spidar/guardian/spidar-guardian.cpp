// SPDX-License-Identifier: LGPL-2.1-or-later
// spidar-guardian: puts the motors at rest if the process that drives them dies or hangs. Started
// by guardian.hpp, or by systemd for a connection to its socket. It uses the kernel only, allocates
// nothing while it watches, and may do nothing but use the device that it was given.
#include "guarded-motors.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <grp.h>
#include <initializer_list>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

using namespace spidar;

namespace {

constexpr int kRealTimePriority = 51; // above the loop that it watches
constexpr uid_t kNobody = 65534;

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

} // namespace

int main() {
  const bool service = is_service();
  ignore_signals();
  leave_files(service);
  if (!service && fork() != 0)
    _exit(0); // the starting process keeps no child
  GuardedMotors motors(kGuardianControl, service ? -1 : kGuardianDevice);
  if (!motors.receive_order())
    return 1;
  if (!service) // which has a cgroup of its own
    leave_cgroup();
  drop_privileges();
  motors.guard();
  _exit(0);
}
