// SPDX-License-Identifier: LGPL-2.1-or-later
// spidar-check: walks through the promises of docs/safety.md on one device, and writes a report.
#include "check-guardian.hpp"
#include "check-machine.hpp"
#include "check-report.hpp"
#include "device-name.hpp"
#include "tool.hpp"

#include <array>
#include <csignal>
#include <iostream>
#include <sched.h>

using namespace spidar_check;
using spidar_tools::Choice;
namespace messages = spidar::messages;

namespace {

constexpr double kLeastForce = 0.05; // N
constexpr double kMostForce = 1;
constexpr double kDrive = 30;     // s; a second process is killed long before
constexpr double kShortest = 0.1; // s, of a measurement of the machine
constexpr double kLongest = 3600;

enum Status { kAllWell = 0, kFailed = 1, kWrongOptions = 2 };

struct Settings {
  Choice choice;
  double force = 0.2; ///< N
  bool may_pull = false;
  bool interactive = false;
  bool machine = false;
  double seconds = 10; ///< of each measurement of the machine
  std::string report;  ///< file, or empty

  bool simulated() const { return choice.device == "sim"; }
};

/// False if the answer is "n", or if there is nobody to answer.
bool ask(const std::string &question) {
  std::cout << question << " (n: no)\n" << std::flush;
  std::string answer;
  return std::getline(std::cin, answer) && answer != "n" && answer != "no";
}

/// No Ctrl-C leaves a force behind while there is no guardian, and no Ctrl-Z lets one stand.
class SignalsBlocked {
public:
  SignalsBlocked() {
    sigset_t set;
    sigemptyset(&set);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU})
      sigaddset(&set, number);
    pthread_sigmask(SIG_BLOCK, &set, &before_);
  }
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked &) = delete;
  SignalsBlocked &operator=(const SignalsBlocked &) = delete;

private:
  sigset_t before_{};
};

Unit open_unit(const Settings &settings) {
  const Choice &choice = settings.choice;
  const spidar::Geometry geometry = spidar::load_geometry(choice.geometry);
  std::shared_ptr<Timer> timer = std::make_shared<MachineTime>();
  if (settings.simulated())
    timer = std::make_shared<SimulatedTime>();
  return {spidar::open_controller(choice.device, geometry, choice.sim_hand), geometry, timer};
}

struct Promise {
  const char *name;
  const char *why; ///< nothing was measured
};

void list(const Report &report, std::initializer_list<Promise> promises) {
  for (const Promise &promise : promises)
    report({promise.name, Verdict::not_testable, promise.why});
}

/// Promises that no program with this device alone can check.
void list_others(const Report &report) {
  constexpr const char *kOfLibrary = "libspidar and hapticsink do this, their tests check it";
  constexpr const char *kOfSink = "hapticsink does this, its tests check it";
  constexpr const char *kFault = "needs a fault; spidar-emulator makes it";
  list(report, {{"force on the grip", kOfLibrary},
                {"force over any minute", kOfLibrary},
                {"torque", kOfLibrary},
                {"change of the force", kOfLibrary},
                {"work on the hand", kOfLibrary},
                {"speed of the grip under a force", kOfLibrary},
                {"the video stops, stalls, ends, is paused or sought in, shows another scene or "
                 "nothing measurable",
                 kOfSink},
                {"the grip is let go", kOfLibrary},
                {"a law shakes the hand", kOfSink},
                {"release", kOfLibrary},
                {"three exchanges fail", kFault},
                {"counts jump", kFault},
                {"a string slips", kFault},
                {"the program is stopped again before it has noticed",
                 "needs a stop at a given instant; the tests of the guardian make it"},
                {"the device takes no data", kFault},
                {"the machine goes to sleep", kOfSink},
                {"with dead-man=button, the button is released", kOfSink},
                {"a tick comes more than 10 ms late", kOfLibrary}});
}

/// Promises that need a force, with the reason why there was none.
void list_without_force(const Report &report, const char *why) {
  list(report, {{"the force is the commanded one", why},
                {"the tension of each string", why},
                {"a number that is not finite counts as zero", why},
                {"the program hangs or is stopped under a force", why},
                {"the guardian hangs, or takes no more commands", why},
                {"the guardian is killed", why},
                {"the program is killed or crashes", why},
                {"program and guardian are killed together", why}});
}

/// What the checks without and with a force have found out.
struct Session {
  std::shared_ptr<const Record> record; ///< of the device, also after it was closed
  bool pulled = false;                  ///< it was allowed to
};

Session check_open_unit(const Settings &settings, Output &output, const Report &report) {
  Unit unit = open_unit(settings);
  output.describe_unit(unit);
  const bool usable = check_answers(unit, report);
  if (settings.interactive)
    check_hand(unit, ask, report);
  else
    list(report, {{"the pose follows the hand", "asked for with --ask only"}});
  const bool may =
      usable &&
      (settings.may_pull ||
       ask(spidar::formatted("Hold the grip in the centre. It will pull with %.2f N in every "
                             "direction. Press Enter when you are ready.",
                             settings.force)));
  if (!may) {
    list_without_force(report, usable ? "it may not pull" : "without a pose it must not pull");
    return {unit.shared_record(), false};
  }
  check_force(unit, settings.force, report);
  if (!settings.simulated()) {
    check_hang(unit, settings.force, report);
    const SignalsBlocked blocked;
    check_guardian_hangs(unit, settings.force, signal_guardian, report);
  }
  return {unit.shared_record(), true};
}

/// The faults that end with the device closed. None may be open.
void check_ends(const Settings &settings, const Session &session, const Report &report) {
  {
    const SignalsBlocked blocked;
    Unit unit = open_again([&] { return open_unit(settings); });
    check_guardian_dies(unit, settings.force, signal_guardian, report);
  }
  OtherProgram program;
  program.drive = [&](const std::function<void()> &pulls) {
    Unit unit = open_again([&] { return open_unit(settings); });
    unit.run(0.4, {settings.force, 0, 0});
    pulls();
    unit.run(kDrive, {settings.force, 0, 0});
  };
  program.open = [&] { open_unit(settings); };
  program.mean_exchange = session.record->mean();
  check_kill(program, settings.interactive ? Ask(ask) : Ask(), report);
}

void check_cable(const Settings &settings, const Report &report) {
  if (!settings.interactive)
    return list(report, {{"the USB cable is pulled", "asked for with --ask only"}});
  Unit unit = open_again([&] { return open_unit(settings); });
  check_unplug(unit, ask, report);
}

void check_all(const Settings &settings, Output &output, const Report &report) {
  constexpr const char *kNone = "a simulated device has none";
  const Session session = check_open_unit(settings, output, report);
  check_close(*session.record, report);
  if (settings.simulated()) {
    list(report, {{"the USB cable is pulled", kNone}});
    if (session.pulled) // else these are listed already
      list(report, {{"the program hangs or is stopped under a force", kNone},
                    {"the guardian hangs, or takes no more commands", kNone},
                    {"the guardian is killed", kNone},
                    {"the program is killed or crashes", kNone},
                    {"program and guardian are killed together", kNone}});
    return;
  }
  if (session.pulled)
    check_ends(settings, session, report);
  check_cable(settings, report);
}

Status check(const Settings &settings) {
  Output output;
  const Report report = [&output](const Finding &finding) { output.add(finding); };
  adopt_guardians();
  const sched_param priority{.sched_priority = kRealTimePriority};
  if (!settings.simulated())
    sched_setscheduler(0, SCHED_FIFO, &priority); // without it, it may be late
  output.describe_machine();
  output.describe_settings(
      spidar::formatted("device %s, force %.2f N", settings.choice.device.c_str(), settings.force));
  try {
    check_all(settings, output, report);
  } catch (const spidar::Error &error) {
    if (error.cause() == spidar::Cause::argument)
      throw;
    report({"the device can be driven", Verdict::fail, error.what()});
  }
  list_others(report);
  output.summary();
  if (!settings.report.empty())
    output.save(settings.report);
  return output.failed() ? kFailed : kAllWell;
}

// ---- The machine

std::string figures(const TimedTicks &ticks) {
  std::string text =
      spidar::formatted("99.9 %% of the ticks began up to %.3f ms late, the latest %.3f ms",
                        1e3 * ticks.lateness.usual, 1e3 * ticks.lateness.worst);
  if (ticks.round_trip)
    text += spidar::formatted(", and 99.9 %% of the exchanges took up to %.3f ms",
                              1e3 * *ticks.round_trip);
  return text;
}

/// The device at minimum tension, or nothing if there is none.
std::unique_ptr<spidar::Device> open_at_rest(const Settings &settings, Output &output) {
  try {
    auto device = spidar_tools::open_device(settings.choice);
    device->rest();
    output.line(device->description());
    return device;
  } catch (const spidar::Error &error) {
    if (settings.choice.device_named || error.cause() == spidar::Cause::argument)
      throw;
    output.line(std::string("No exchange was measured. ") + error.what());
    return nullptr;
  }
}

Status check_machine(const Settings &settings) {
  Output output;
  output.describe_machine();
  const auto device = open_at_rest(settings, output);
  std::function<bool()> exchange;
  if (device && !settings.simulated())
    exchange = [&] { return device->exchange(spidar::monotonic_time()); };
  const TimedTicks idle = time_ticks(settings.seconds, exchange);
  output.line(spidar::formatted("real-time priority: %s", idle.priority ? "yes" : "no"));
  output.line(spidar::formatted("idle for %g s: %s", settings.seconds, figures(idle).c_str()));
  const BusyProcessors busy;
  const TimedTicks loaded = time_ticks(settings.seconds, exchange);
  output.line(spidar::formatted("%zu processors busy for %g s: %s", busy.count(), settings.seconds,
                                figures(loaded).c_str()));
  if (device && !device->connected())
    spidar::fail(spidar::Cause::io, messages::kToolSilent);
  const spidar::MachineVerdict verdict = spidar::judge_machine(
      {.priority = idle.priority && loaded.priority,
       .lateness = idle.lateness,
       .loaded = loaded.lateness,
       .round_trip = exchange ? std::max(idle.round_trip, loaded.round_trip) : std::nullopt,
       .device =
           device ? device->limits() : limits_of(spidar::load_geometry(settings.choice.geometry))});
  output.line(verdict.text);
  if (!settings.report.empty())
    output.save(settings.report);
  return verdict.fitness == spidar::Fitness::unfit ? kFailed : kAllWell;
}

} // namespace

int main(int argc, char **argv) {
  Settings settings;
  const char *report = nullptr;
  gboolean yes = FALSE;
  gboolean interactive = FALSE;
  gboolean machine = FALSE;
  const GOptionEntry own[] = {
      {"force", 'f', 0, G_OPTION_ARG_DOUBLE, &settings.force,
       "how much the device pulls, 0.05 to 1 N (default: 0.2)", "N"},
      {"yes", 'y', 0, G_OPTION_ARG_NONE, &yes, "pull without asking first", nullptr},
      {"ask", 'a', 0, G_OPTION_ARG_NONE, &interactive,
       "also check what needs a person: moving the grip, pulling the cable", nullptr},
      {"machine", 'm', 0, G_OPTION_ARG_NONE, &machine,
       "check the machine instead: whether its ticks are in time, also while all processors are "
       "busy. It pulls with minimum tension only",
       nullptr},
      {"seconds", 's', 0, G_OPTION_ARG_DOUBLE, &settings.seconds,
       "with --machine: how long it measures each time, 0.1 to 3600 s (default: 10)", "S"},
      {"report", 'r', 0, G_OPTION_ARG_FILENAME, &report, "also write the report to this file",
       "FILE"},
      {}};
  spidar_tools::Options options(
      "",
      "Checks on one SPIDAR-G what docs/safety.md promises, at a low force, and says for each "
      "promise: pass, FAIL or not testable.\n\nExample: spidar-check --device sim --yes",
      own,
      "Exit status: 0 no promise failed and the machine is fit, 1 one failed or the machine is not "
      "fit, 2 wrong options.");
  if (!options.parse(argc, argv))
    return kWrongOptions;
  settings.choice = options.choice();
  settings.may_pull = yes != FALSE;
  settings.interactive = interactive != FALSE;
  settings.machine = machine != FALSE;
  settings.report = report ? report : "";
  try {
    if (!(settings.force >= kLeastForce && settings.force <= kMostForce))
      spidar::fail(spidar::Cause::argument, messages::kCheckForce);
    if (!(settings.seconds >= kShortest && settings.seconds <= kLongest))
      spidar::fail(spidar::Cause::argument, messages::kCheckSeconds);
    return settings.machine ? check_machine(settings) : check(settings);
  } catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kWrongOptions;
  }
}
