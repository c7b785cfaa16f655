// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace test {

/// Waits as long as it takes: the limit is the test runner's. Returns true.
inline bool eventually(const std::function<bool()> &condition) {
  while (!condition())
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return true;
}

} // namespace test
