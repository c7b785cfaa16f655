// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include "share/callback-thread.hpp"

#include <atomic>
#include <cstddef>
#include <functional>
#include <span>
#include <stop_token>

namespace haptic {

/// Runs at real-time priority if it may, and never waits for a page of what it needs.
class RealTimeThread {
public:
  struct Callbacks {
    std::function<void()> entered; ///< called in the thread before its body; it may end the thread
    CallbackThread::Keeper keeper; ///< what lives while `entered` runs
    std::function<void()> left;    ///< and after the body
  };

  /// `memory` is locked, with the stack, before the body begins. Throws std::system_error.
  void start(const Callbacks &callbacks, std::span<const std::byte> memory,
             const std::function<void(const std::stop_token &)> &body);
  /// As CallbackThread::end().
  void end() noexcept { thread_.end(); }

  // Any thread. Of the last start().

  /// 0 with real-time priority, else the errno of the refusal; -1 until the thread runs.
  int priority_error() const noexcept { return priority_error_.load(); }
  /// Kernel's number of the thread, once priority_error() is not -1.
  int number() const noexcept { return number_.load(); }
  /// 0 when the memory cannot be swapped out, else the errno of the refusal.
  int memory_error() const noexcept { return memory_error_.load(); }

private:
  std::atomic<int> number_ = 0;
  std::atomic<int> priority_error_ = -1;
  std::atomic<int> memory_error_ = 0;
  CallbackThread thread_; // last: ends before what it uses
};

} // namespace haptic
