// SPDX-License-Identifier: LGPL-2.1-or-later
// The priority that the loop has where it is allowed: a busy machine is no news.
#pragma once

#include <pthread.h>
#include <sched.h>

namespace test {

class AsTheLoop {
public:
  AsTheLoop() { set(SCHED_FIFO, 50); }
  ~AsTheLoop() { set(SCHED_OTHER, 0); }
  AsTheLoop(const AsTheLoop &) = delete;
  AsTheLoop &operator=(const AsTheLoop &) = delete;

private:
  static void set(int policy, int priority) {
    const sched_param wanted{.sched_priority = priority};
    pthread_setschedparam(pthread_self(), policy, &wanted); // harmless where it is not allowed
  }
};

} // namespace test
