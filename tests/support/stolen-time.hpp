// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether the hypervisor of a virtual machine took the processors away: nobody is in time then.
#pragma once

#include <fstream>
#include <string>

namespace test {

/// Time stolen since the machine started, in hundredths of a second.
inline long stolen_time() {
  std::ifstream file("/proc/stat");
  std::string word;
  long value = 0;
  file >> word; // "cpu"
  for (int column = 0; column < 8; ++column)
    file >> value;
  return value;
}

} // namespace test
