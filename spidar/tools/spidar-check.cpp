// SPDX-License-Identifier: LGPL-2.1-or-later
// spidar-check: walks through the promises of docs/safety.md on one device, and writes a report.
#include "fail.hpp"
#include "promises.hpp"

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <iostream>
#include <spidar/spidar.h>
#include <sys/utsname.h>

using namespace spidar_check;
using spidar_tools::Choice;
namespace messages = spidar::messages;

namespace {

constexpr double kLeastForce = 0.05; // N
constexpr double kMostForce = 1;

enum Status { kAllWell = 0, kFailed = 1, kWrongOptions = 2 };

struct Settings {
  Choice choice;
  double force = 0.2; ///< N
  bool may_pull = false;
  bool interactive = false;
  std::string report; ///< file, or empty
};

/// What is printed, and written to the report in the end.
class Output {
public:
  void line(const std::string &text) {
    std::cout << text << std::endl;
    text_ += text + "\n";
  }
  void add(const Finding &finding) {
    constexpr const char *kNames[] = {"pass", "FAIL", "not testable"};
    const auto verdict = static_cast<std::size_t>(finding.verdict);
    ++counts_[verdict];
    line(spidar::formatted("%-12s  %s: %s", kNames[verdict], finding.promise,
                           finding.figure.c_str()));
  }
  void summary() {
    line(
        spidar::formatted("%d pass, %d fail, %d not testable", counts_[0], counts_[1], counts_[2]));
  }
  bool failed() const { return counts_[1] > 0; }

  void save(const std::string &path) const {
    const std::unique_ptr<std::FILE, int (*)(std::FILE *)> file(std::fopen(path.c_str(), "w"),
                                                                std::fclose);
    if (!file || std::fputs(text_.c_str(), file.get()) < 0 || std::fflush(file.get()) != 0)
      spidar::fail(spidar::Cause::argument, messages::kCheckReport, path.c_str(),
                   std::strerror(errno));
  }

private:
  std::string text_;
  std::array<int, 3> counts_{};
};

/// False if the answer is "n", or if there is nobody to answer.
bool ask(const std::string &question) {
  std::cout << question << " (n: no)" << std::endl;
  std::string answer;
  return std::getline(std::cin, answer) && answer != "n" && answer != "no";
}

void describe(Output &output, const Settings &settings) {
  std::array<char, 32> time{};
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::strftime(time.data(), time.size(), "%Y-%m-%d %H:%M:%S UTC", &parts);
  utsname system{};
  uname(&system);
  output.line(spidar::formatted("spidar-check %s, libspidar %s, %s, %s %s %s", SPIDAR_VERSION,
                                spidar_version(), time.data(), system.sysname, system.release,
                                system.machine));
  output.line(spidar::formatted("device %s, geometry %s, force %.2f N",
                                settings.choice.device.c_str(), settings.choice.geometry.c_str(),
                                settings.force));
}

/// Promises that no program on this device can check, each with the reason.
void list_others(const Report &report) {
  constexpr const char *kOfSink = "hapticsink does this: meson test --suite faults";
  for (const char *promise :
       {"the force fades when the video stops", "the force goes off when the grip is let go",
        "force, torque, their change and their work are limited",
        "the force fades after the machine slept"})
    report({promise, Verdict::not_testable, kOfSink});
}

/// What needs a real device or an emulated one. None may be open.
void check_usb(const Settings &settings, const Report &report, bool pulled) {
  const bool simulated = settings.choice.device == "sim";
  const char *why = simulated ? "a simulated device has none" : "it may not pull";
  if (simulated || !pulled) {
    report({"the guardian lets go when the program hangs", Verdict::not_testable, why});
    report({"the guardian lets go when the program is killed", Verdict::not_testable, why});
  } else {
    check_guardian(settings.choice, settings.force, settings.interactive ? Ask(ask) : Ask(),
                   report);
  }
  if (simulated || !settings.interactive) {
    report({"a pulled cable is noticed", Verdict::not_testable,
            simulated ? "a simulated device has none" : "asked for with --ask only"});
    return;
  }
  Unit unit(settings.choice);
  check_unplug(unit, ask, report);
}

/// Returns what the device was sent, also while it was closed. `pulled`: it was allowed to.
std::shared_ptr<const Record> check_open_unit(const Settings &settings, Output &output,
                                              const Report &report, bool &pulled) {
  Unit unit(settings.choice);
  output.line(unit.description());
  check_answers(unit, report);
  if (settings.interactive)
    check_hand(unit, ask, report);
  else
    report({"the pose follows the hand", Verdict::not_testable, "asked for with --ask only"});
  pulled = settings.may_pull ||
           ask(spidar::formatted("Hold the grip in the centre. It will pull with %.2f N in every "
                                 "direction. Press Enter when you are ready.",
                                 settings.force));
  if (pulled)
    check_force(unit, settings.force, report);
  else
    report({"the force is the commanded one", Verdict::not_testable, "it may not pull"});
  return unit.shared_record();
}

Status check(const Settings &settings) {
  Output output;
  const Report report = [&output](const Finding &finding) { output.add(finding); };
  describe(output, settings);
  bool pulled = false;
  try {
    check_close(*check_open_unit(settings, output, report, pulled), report);
    check_usb(settings, report, pulled);
    list_others(report);
  } catch (const spidar::Error &error) {
    if (error.cause() == spidar::Cause::argument)
      throw;
    report({"the device can be driven", Verdict::fail, error.what()});
  }
  output.summary();
  if (!settings.report.empty())
    output.save(settings.report);
  return output.failed() ? kFailed : kAllWell;
}

} // namespace

int main(int argc, char **argv) {
  Settings settings;
  const char *report = nullptr;
  gboolean yes = FALSE;
  gboolean interactive = FALSE;
  const GOptionEntry own[] = {
      {"force", 'f', 0, G_OPTION_ARG_DOUBLE, &settings.force,
       "with how much it pulls, 0.05 to 1 N; 0.2 without this option", "N"},
      {"yes", 'y', 0, G_OPTION_ARG_NONE, &yes, "pull without asking", nullptr},
      {"ask", 'a', 0, G_OPTION_ARG_NONE, &interactive,
       "check also what needs a person: moving the grip, pulling the cable", nullptr},
      {"report", 'r', 0, G_OPTION_ARG_FILENAME, &report, "write what is printed to this file too",
       "FILE"},
      {}};
  spidar_tools::Options options(
      "",
      "Checks on one SPIDAR-G what docs/safety.md promises, at a low force, and says for each "
      "promise: pass, FAIL or not testable.",
      own, "Exit status: 0 no promise failed, 1 one failed, 2 wrong options.");
  if (!options.parse(argc, argv))
    return kWrongOptions;
  settings.choice = options.choice();
  settings.may_pull = yes != FALSE;
  settings.interactive = interactive != FALSE;
  settings.report = report ? report : "";
  try {
    if (!(settings.force >= kLeastForce && settings.force <= kMostForce))
      spidar::fail(spidar::Cause::argument, messages::kCheckForce);
    return check(settings);
  } catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kWrongOptions;
  }
}
