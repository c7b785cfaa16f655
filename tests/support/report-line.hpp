// What a test measured, in a line that tests/faults/usb-report.sh collects.
#pragma once

#include <cstdio>
#include <string>

namespace test {

inline void report(const std::string &name, double value) {
  std::printf("measured %s %.6g\n", name.c_str(), value);
}

} // namespace test
