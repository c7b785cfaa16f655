// SPDX-License-Identifier: LGPL-2.1-or-later
// The guardian: another process drives the device, and is killed or stopped.
#include "device-name.hpp"
#include "promises.hpp"

#include <csignal>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace spidar_check {

using namespace std::chrono_literals;
using spidar::Vector3;
namespace messages = spidar::messages;

namespace {

constexpr char kPulls = 'p';
constexpr char kInterrupted = 'i';
constexpr auto kStart = 10s; // opening, and a late machine
constexpr auto kPause = 300ms;
constexpr auto kFelt = 2s; // a person notices the pull
constexpr auto kPatience = 5s;
constexpr double kDrive = 30; // s at most

/// The guardian keeps the device until it has set minimum tension. Throws what opening it throws in
/// the end.
void open_again(const spidar_tools::Choice &choice, const spidar::Geometry &geometry) {
  for (const auto begin = Clock::now();;) {
    try {
      spidar::open_controller(choice.device, geometry, choice.sim_hand);
      return;
    } catch (const spidar::Error &) {
      if (Clock::now() - begin > kPatience)
        throw;
    }
    std::this_thread::sleep_for(1ms);
  }
}

/// The driving process.
[[noreturn]] void drive(const spidar_tools::Choice &choice, double force, int results) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  try {
    open_again(choice, spidar::load_geometry(choice.geometry));
    Unit unit(choice);
    const Vector3 wanted(force, 0, 0);
    unit.run(0.4, wanted);
    const int before = unit.interruptions();
    bool told = write(results, &kPulls, 1) == 1;
    for (int tick = 0; told && tick < static_cast<int>(kDrive * 1e3); ++tick) {
      unit.run(1e-3, wanted);
      if (unit.interruptions() > before) {
        told = write(results, &kInterrupted, 1) == 1;
        break;
      }
    }
  } catch (const std::exception &) {
    // The end of the pipe says it.
  }
  _exit(0);
}

class Driver {
public:
  Driver(const spidar_tools::Choice &choice, double force) {
    int ends[2];
    if (pipe(ends) != 0)
      return;
    results_ = ends[0];
    std::fflush(nullptr);
    process_ = fork();
    if (process_ == 0)
      drive(choice, force, ends[1]);
    close(ends[1]);
  }
  ~Driver() {
    signal(SIGCONT);
    end();
    close(results_);
  }
  Driver(const Driver &) = delete;
  Driver &operator=(const Driver &) = delete;

  bool reports(char wanted, std::chrono::milliseconds time) const {
    pollfd readable{.fd = results_, .events = POLLIN, .revents = 0};
    char word = 0;
    return poll(&readable, 1, static_cast<int>(time.count())) == 1 &&
           read(results_, &word, 1) == 1 && word == wanted;
  }
  void signal(int number) const {
    if (process_ > 0)
      kill(process_, number);
  }
  /// Kills it, unless it has ended.
  void end() {
    signal(SIGKILL);
    if (process_ > 0)
      waitpid(process_, nullptr, 0);
    process_ = -1;
  }

private:
  pid_t process_ = -1;
  int results_ = -1;
};

Finding check_kill(const spidar_tools::Choice &choice, double force, const Ask &ask) {
  constexpr const char *kPromise = "the guardian lets go when the program is killed";
  Driver driver(choice, force);
  if (!driver.reports(kPulls, kStart))
    return {kPromise, Verdict::not_testable, "a second process could not drive the device"};
  if (ask)
    std::this_thread::sleep_for(kFelt);
  const auto begin = Clock::now();
  driver.end();
  try {
    open_again(choice, spidar::load_geometry(choice.geometry));
  } catch (const spidar::Error &error) {
    return {kPromise, Verdict::fail, error.what()};
  }
  const double taken = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  const std::string figure = spidar::formatted(
      "it had released the device when it was opened again, %.0f ms later", taken);
  if (ask && !ask("The program was killed. Press Enter if the pull stopped at once; n if not."))
    return {kPromise, Verdict::fail, figure + ". " + messages::kCheckGuardian};
  return {kPromise, Verdict::pass, figure};
}

Finding check_stop(const spidar_tools::Choice &choice, double force) {
  constexpr const char *kPromise = "the guardian lets go when the program hangs";
  Driver driver(choice, force);
  if (!driver.reports(kPulls, kStart))
    return {kPromise, Verdict::not_testable, "a second process could not drive the device"};
  driver.signal(SIGSTOP);
  std::this_thread::sleep_for(kPause);
  driver.signal(SIGCONT);
  if (!driver.reports(kInterrupted, kPatience))
    return {kPromise, Verdict::fail, messages::kCheckGuardian};
  return {kPromise, Verdict::pass,
          spidar::formatted("it reported that, after a stop of %d ms",
                            static_cast<int>(kPause.count()))};
}

} // namespace

void check_guardian(const spidar_tools::Choice &choice, double force, const Ask &ask,
                    const Report &report) {
  report(check_stop(choice, force));
  report(check_kill(choice, force, ask));
}

} // namespace spidar_check
