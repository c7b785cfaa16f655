// SPDX-License-Identifier: LGPL-2.1-or-later
// What a test measured, in a line that tests/faults/usb-report.sh collects.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>
#include <string>

namespace test {

inline void report(const std::string &name, double value) {
  std::printf("measured %s %.6g\n", name.c_str(), value);
}

/// A limit of time holds where nothing else runs: usb-report.sh says so with $FEELING_WIND_TIMING.
/// Among other tests only what takes twenty times as long is wrong for sure.
inline void expect_in_time(double value, double limit) {
  constexpr double kAmongOthers = 20;
  EXPECT_LE(value, std::getenv("FEELING_WIND_TIMING") ? limit : kAmongOthers * limit);
}

inline void expect_in_time(const std::string &name, double value, double limit) {
  report(name, value);
  expect_in_time(value, limit);
}

} // namespace test
