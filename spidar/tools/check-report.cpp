// SPDX-License-Identifier: LGPL-2.1-or-later
#include "check-report.hpp"

#include "fail.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <iostream>
#include <memory>
#include <sched.h>
#include <spidar/spidar.h>
#include <spidar/usb.hpp>
#include <sys/utsname.h>

namespace spidar_check {

using spidar::formatted;

namespace {

/// Replaces the path of the home folder by ~.
std::string without_home(const std::string &text) {
  const char *home = std::getenv("HOME");
  const std::string folder = home ? home : "";
  if (folder.size() < 2)
    return text;
  std::string result;
  std::size_t begin = 0;
  for (auto at = text.find(folder); at != std::string::npos; at = text.find(folder, begin)) {
    result.append(text, begin, at - begin).push_back('~');
    begin = at + folder.size();
  }
  return result.append(text, begin, std::string::npos);
}

template <class Numbers>
std::string list(const char *name, const Numbers &numbers) {
  std::string text = name;
  for (const double number : numbers)
    text += formatted(" %g", number);
  return text;
}

} // namespace

void Output::line(const std::string &text) {
  const std::string shown = without_home(text);
  std::cout << shown << '\n' << std::flush;
  text_ += shown + "\n";
}

void Output::add(const Finding &finding) {
  constexpr const char *kNames[] = {"pass", "FAIL", "not testable"};
  const auto verdict = static_cast<std::size_t>(finding.verdict);
  ++counts_[verdict];
  line(formatted("%-12s  %s: %s", kNames[verdict], finding.promise, finding.figure.c_str()));
}

void Output::describe_machine() {
  std::array<char, 32> time{};
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::strftime(time.data(), time.size(), "%Y-%m-%d %H:%M:%S UTC", &parts);
  utsname system{};
  uname(&system);
  line(formatted("spidar-check %s, libspidar %s, %s, %s %s %s", SPIDAR_VERSION, spidar_version(),
                 time.data(), system.sysname, system.release, system.machine));
}

void Output::describe_settings(const std::string &settings) {
  line(formatted("%s, longest exchange %lld ms, real-time priority %s", settings.c_str(),
                 static_cast<long long>(spidar::usb_exchange_timeout().count()),
                 sched_getscheduler(0) == SCHED_FIFO ? "yes" : "no"));
}

void Output::describe_unit(const Unit &unit) {
  const spidar::Geometry &geometry = unit.geometry();
  line(unit.description());
  if (const std::string remark = unit.remark(); !remark.empty())
    line(remark);
  line(formatted("geometry %s, dac-limit %d, tension-min %g N, tension-max %g N",
                 geometry.name.c_str(), geometry.dac_limit, geometry.tension_min,
                 geometry.tension_max));
  line(list("metres-per-count", geometry.metres_per_count));
  line(list("volts-per-newton", geometry.volts_per_newton));
}

void Output::summary() {
  line(formatted("%d pass, %d fail, %d not testable", counts_[0], counts_[1], counts_[2]));
}

void Output::save(const std::string &path) const {
  const std::unique_ptr<std::FILE, int (*)(std::FILE *)> file(std::fopen(path.c_str(), "w"),
                                                              std::fclose);
  if (!file || std::fputs(text_.c_str(), file.get()) < 0 || std::fflush(file.get()) != 0)
    spidar::fail(spidar::Cause::argument, spidar::messages::kCheckReport, path.c_str(),
                 std::strerror(errno));
}

} // namespace spidar_check
