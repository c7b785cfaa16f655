// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usb/usb-holder.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace spidar {

namespace fs = std::filesystem;

namespace {

/// How often `process` has `path` open.
int has_open(const fs::path &process, const std::string &path) {
  int times = 0;
  std::error_code error;
  for (fs::directory_iterator entry(process / "fd", error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code unreadable;
    if (fs::read_symlink(entry->path(), unreadable).string().ends_with(path))
      ++times;
  }
  return times;
}

std::string name_of(const fs::path &process) {
  std::string name;
  std::getline(std::ifstream(process / "comm"), name);
  return name;
}

} // namespace

// This program first: it is the one that can be told for sure, since what another program has open
// may be a device of that name on another bus (in a container, in a test).
std::string holder_of(const std::string &path) {
  if (has_open("/proc/self", path) > 1) // the attempt to open it counts as one
    return "this program already";
  std::string guardian;
  std::error_code error;
  for (fs::directory_iterator entry("/proc", error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string number = entry->path().filename().string();
    if (!std::all_of(number.begin(), number.end(), [](unsigned char c) { return std::isdigit(c); }))
      continue;
    if (number == std::to_string(getpid()) || has_open(entry->path(), path) == 0)
      continue;
    const std::string name = name_of(entry->path());
    std::string holder = name;
    holder.append(" (process ").append(number).append(")");
    if (name != "spidar-guardian") // works for another program
      return holder;
    guardian = std::move(holder);
  }
  if (!guardian.empty())
    return guardian;
  return "a program of another user ('sudo fuser " + path + "' names it)";
}

} // namespace spidar
