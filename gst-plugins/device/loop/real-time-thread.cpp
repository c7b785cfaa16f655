// SPDX-License-Identifier: LGPL-2.1-or-later
#include "loop/real-time-thread.hpp"

#include "share/real-time-priority.hpp"

#include <cerrno>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

namespace haptic {
namespace {

// Touches and locks the stack as deep as the body ever needs it, so that no tick waits for a page.
[[gnu::noinline]] int lock_stack() noexcept {
  constexpr std::size_t kDepth = 65536;
  volatile char stack[kDepth];
  for (std::size_t i = 0; i < kDepth; i += 1024)
    stack[i] = 0;
  return mlock(const_cast<char *>(stack), kDepth) == 0 ? 0 : errno;
}

int lock_memory(std::span<const std::byte> memory) noexcept {
  if (const int error = lock_stack(); error != 0)
    return error;
  return mlock(memory.data(), memory.size()) == 0 ? 0 : errno;
}

int schedule(int policy, int priority) noexcept {
  const sched_param wanted{.sched_priority = priority};
  return pthread_setschedparam(pthread_self(), policy, &wanted);
}

} // namespace

void RealTimeThread::start(const Callbacks &callbacks, std::span<const std::byte> memory,
                           const std::function<void(const std::stop_token &)> &body) {
  priority_error_ = -1;
  // The thread has its own callbacks: `entered` may end it and start another one.
  thread_ = CallbackThread(callbacks.keeper, [=, this](CallbackThread::Self &self) {
    if (callbacks.entered && !self.call_out(callbacks.entered))
      return;
    number_ = gettid();
    memory_error_ = lock_memory(memory);
    // At normal priority the kernel delays a wake-up by up to 50 us to save power by default.
    prctl(PR_SET_TIMERSLACK, 1UL);
    priority_error_ = schedule(SCHED_FIFO, kRealTimePriority);
    body(self.stop_token());
    schedule(SCHED_OTHER, 0);
    if (callbacks.left)
      callbacks.left();
  });
}

} // namespace haptic
