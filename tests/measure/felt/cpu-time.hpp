// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <ctime>

namespace test {

/// The processor time that this thread has spent.
inline double cpu_microseconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

} // namespace test
