// SPDX-License-Identifier: LGPL-2.1-or-later
// Prints what a test measured, one line each, for tests/faults/usb-report.sh to judge. A test does
// not: times depend on what else the machine does.
#pragma once

#include <cstdio>
#include <string>

namespace test {

inline void report(const std::string &name, double value) {
  std::printf("measured %s %.6g\n", name.c_str(), value);
}

} // namespace test
