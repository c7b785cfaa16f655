// SPDX-License-Identifier: LGPL-2.1-or-later
// The machine a time was measured on.
#pragma once

#include <fstream>
#include <string>

namespace test {

/// As /proc/cpuinfo names it.
inline std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name"))
      return line.substr(line.find(':') + 2);
  return "unknown processor";
}

} // namespace test
