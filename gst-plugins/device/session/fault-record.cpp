// SPDX-License-Identifier: LGPL-2.1-or-later
#include "session/fault-record.hpp"

#include "format-text.hpp"
#include "messages.hpp"
#include "safety/safety-chain.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <memory>
#include <span>
#include <system_error>
#include <unistd.h>

namespace haptic {
namespace {

using Ticks = std::span<const FlightRecorder::Tick>;

// At 1 kHz a file has up to 1 MB, and a loose plug has a fault every few seconds.
constexpr unsigned kMostFiles = 20; // of a process

// Of the process too: two may have a fault in the same second.
std::string file_name(unsigned number) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm local{};
  localtime_r(&now, &local);
  char text[32];
  std::strftime(text, sizeof text, "force-%Y%m%d-%H%M%S-", &local);
  return text + std::to_string(getpid()) + "-" + std::to_string(number) + ".csv";
}

// Returns the errno of what failed, or 0.
int write(Ticks ticks, const std::filesystem::path &path) {
  std::error_code error;
  std::filesystem::create_directories(path.parent_path(), error);
  if (error)
    return error.value();
  const std::unique_ptr<std::FILE, int (*)(std::FILE *)> file(std::fopen(path.c_str(), "wxe"),
                                                              std::fclose);
  if (!file)
    return errno;
  std::string text = std::string(kTickLogHeader) + '\n';
  for (const FlightRecorder::Tick &tick : ticks)
    append_row(text, tick.row);
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), file.get()) == text.size() &&
                       std::fflush(file.get()) == 0;
  return written ? 0 : errno;
}

int late_in_last_second(Ticks ticks) {
  return static_cast<int>(std::ranges::count_if(ticks, [&](const auto &tick) {
    return tick.late && ticks.back().row.mono - tick.row.mono < 1;
  }));
}

} // namespace

std::string write_fault_record(FlightRecorder &recorder, const std::string &folder) {
  static std::atomic<unsigned> files = 0;
  std::string told;
  recorder.take([&](std::uint32_t rules, Ticks ticks) {
    const unsigned number = ++files;
    if (number > kMostFiles)
      return;
    const std::filesystem::path path = std::filesystem::path(folder) / file_name(number);
    if (const int error = write(ticks, path))
      told = format_text(messages::kFaultNotRecorded, path.c_str(),
                         std::generic_category().message(error).c_str());
    else
      told = format_text(messages::kFaultRecorded, names_of_holds(rules).c_str(), path.c_str(),
                         late_in_last_second(ticks));
  });
  return told;
}

} // namespace haptic
