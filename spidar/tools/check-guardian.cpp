// SPDX-License-Identifier: LGPL-2.1-or-later
#include "check-guardian.hpp"

#include "fail.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace spidar_check {

using namespace std::chrono_literals;
using spidar::formatted;
namespace messages = spidar::messages;

namespace {

constexpr auto kStart = 10s; // opening, and a late machine
constexpr auto kPromised = 5ms;
constexpr int kKills = 3; // until one was in time: the machine may have been late

constexpr const char *kKilled = "the program is killed or crashes";
constexpr const char *kTogether = "program and guardian are killed together";

std::string contents(const std::string &file) {
  std::ifstream stream(file);
  std::string text;
  std::getline(stream, text, '\0'); // nothing of a process that ends meanwhile
  return text;
}

/// Of a line of /proc/PID/stat: the state and the parent, behind the name in brackets.
bool lives_below(const std::string &stat, pid_t parent) {
  char state = 0;
  int of = 0;
  const auto name_end = stat.rfind(')');
  return name_end != std::string::npos &&
         // The kernel wrote it. NOLINTNEXTLINE(bugprone-unchecked-string-to-number-conversion)
         std::sscanf(stat.c_str() + name_end + 1, " %c %d", &state, &of) == 2 && of == parent &&
         state != 'Z';
}

class Driver {
public:
  explicit Driver(const OtherProgram &program) {
    int ends[2];
    if (pipe(ends) != 0)
      return;
    results_ = ends[0];
    std::fflush(nullptr);
    process_ = fork();
    if (process_ == 0)
      drive(program, ends[1]);
    setpgid(process_, process_);
    close(ends[1]);
  }
  ~Driver() {
    end();
    close(results_);
  }
  Driver(const Driver &) = delete;
  Driver &operator=(const Driver &) = delete;

  bool pulls() const {
    pollfd readable{.fd = results_, .events = POLLIN, .revents = 0};
    char word = 0;
    return poll(&readable, 1, static_cast<int>(std::chrono::milliseconds(kStart).count())) == 1 &&
           read(results_, &word, 1) == 1;
  }
  /// Kills its process group.
  void end() {
    if (process_ > 0) {
      kill(-process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
    process_ = -1;
  }
  /// Its guardian: the only other child. Nothing for a service.
  std::optional<pid_t> guardian() const {
    for (const pid_t child : children())
      if (child != process_)
        return child;
    return std::nullopt;
  }

private:
  [[noreturn]] static void drive(const OtherProgram &program, int results) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    try {
      program.drive([results] {
        if (write(results, "p", 1) != 1)
          _exit(1);
      });
    } catch (const std::exception &) {
      // The end of the pipe says it.
    }
    _exit(1);
  }

  pid_t process_ = -1;
  int results_ = -1;
};

Finding together(std::optional<pid_t> guardian) {
  if (!guardian)
    return {kTogether, Verdict::not_testable,
            "the guardian is a user service: what ends this program does not end it"};
  const std::string theirs = contents(formatted("/proc/%d/cgroup", *guardian));
  if (!theirs.empty() && theirs != contents("/proc/self/cgroup"))
    return {kTogether, Verdict::pass, "the guardian is in a cgroup of its own"};
  return {kTogether, Verdict::not_testable,
          "the guardian shares the program's cgroup: only the user service survives its end"};
}

/// One kill: a finding that ends the check, or the time until the guardian had finished (0 for a
/// service, whose end is not seen).
struct Kill {
  std::optional<Finding> failed;
  Clock::duration taken{};
  std::optional<pid_t> guardian;
  Finding together{kTogether, Verdict::not_testable, "no guardian was found"};
};

Kill kill_once(const OtherProgram &program, bool felt) {
  Kill result;
  Driver driver(program);
  if (!driver.pulls()) {
    result.failed = {kKilled, Verdict::not_testable, "a second process could not drive the device"};
    return result;
  }
  if (felt)
    std::this_thread::sleep_for(program.felt);
  result.guardian = driver.guardian();
  result.together = together(result.guardian);
  const auto begin = Clock::now();
  driver.end();
  if (result.guardian) {
    const auto ended = await_end(*result.guardian, program.patience);
    if (!ended || !ended->well) {
      result.failed =
          verdict(kKilled, false, ended ? "the guardian crashed" : "the guardian has not finished",
                  messages::kCheckGuardian);
      return result;
    }
    result.taken = ended->time - begin;
  }
  try {
    open_again(program.open, program.patience);
  } catch (const spidar::Error &error) {
    result.failed = {kKilled, Verdict::fail, error.what()};
  }
  return result;
}

Finding judge(const Kill &kill, Clock::duration mean_exchange) {
  if (kill.failed)
    return *kill.failed;
  if (!kill.guardian)
    return {kKilled, Verdict::pass, "the guardian service had released the device"};
  return in_time(kKilled, kill.taken, kPromised, mean_exchange, {});
}

} // namespace

void adopt_guardians() {
  prctl(PR_SET_CHILD_SUBREAPER, 1);
}

std::vector<pid_t> children() {
  std::vector<pid_t> found;
  std::error_code none;
  for (const auto &entry : std::filesystem::directory_iterator("/proc", none)) {
    const std::string name = entry.path().filename();
    pid_t process = 0; // stays so if the name is no number
    std::from_chars(name.data(), name.data() + name.size(), process);
    if (process > 0 && lives_below(contents(entry.path() / "stat"), getpid()) &&
        contents(entry.path() / "comm").starts_with("spidar-guardian"))
      found.push_back(process);
  }
  return found;
}

bool signal_guardian(int number) {
  const std::vector<pid_t> guardians = children();
  return guardians.size() == 1 && kill(guardians.front(), number) == 0;
}

std::optional<End> await_end(pid_t child, std::chrono::milliseconds patience) {
  const auto descriptor = static_cast<int>(syscall(SYS_pidfd_open, child, 0));
  pollfd ended{.fd = descriptor, .events = POLLIN, .revents = 0};
  const bool seen = poll(&ended, 1, static_cast<int>(patience.count())) == 1;
  const auto now = Clock::now();
  close(descriptor);
  int status = 0;
  if (!seen || waitpid(child, &status, WNOHANG) != child)
    return std::nullopt;
  return End{now, WIFEXITED(status) && WEXITSTATUS(status) == 0};
}

void check_kill(const OtherProgram &program, const Ask &ask, const Report &report) {
  std::optional<Kill> best;
  int kills = 0;
  while (kills < kKills) {
    ++kills;
    Kill kill = kill_once(program, static_cast<bool>(ask));
    const bool failed = kill.failed.has_value();
    if (failed || !best || kill.taken < best->taken)
      best = std::move(kill);
    if (failed || best->taken <= kPromised || ask)
      break;
  }
  Finding finding = judge(*best, program.mean_exchange);
  if (kills > 1 && !best->failed)
    finding.figure = formatted("best of %d kills: ", kills) + finding.figure;
  if (ask && !best->failed && finding.verdict != Verdict::fail &&
      !ask("The program was killed. Press Enter if the pull stopped at once; n if not."))
    finding = verdict(kKilled, false, finding.figure, messages::kCheckGuardian);
  report(finding);
  report(best->together);
}

} // namespace spidar_check
