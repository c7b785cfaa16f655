// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace test {

/// Waits as long as it takes, within reason. Returns whether the condition came true.
inline bool eventually(const std::function<bool()> &condition) {
  for (int i = 0; i < 1000; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(5)))
    if (condition())
      return true;
  return false;
}

} // namespace test
