// SPDX-License-Identifier: LGPL-2.1-or-later
// A clock whose time stands still until the test lets it pass. Then the threads that sleep on it
// wake one after the other, each when its time has come and the others have nothing left to do:
// nothing is late, however busy the machine is.
#pragma once

#include "other-threads.hpp"
#include "share/loop-clock.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <vector>

namespace test {

using namespace std::chrono_literals;

class VirtualClock : public haptic::LoopClock {
public:
  VirtualClock() = default;
  virtual ~VirtualClock() = default;

  std::int64_t now() const noexcept override { return now_; }
  std::int64_t boot_time() const noexcept override { return now_ + asleep_; }
  void sleep_until(std::int64_t when) noexcept override { sleep({.when = when, .is_loop = true}); }
  void wait_until(std::int64_t when, const std::stop_token &stop = {}) override {
    sleep({.when = when}, stop);
  }

  // The test's thread.

  /// Lets this much time pass.
  void advance(std::chrono::nanoseconds duration) {
    const std::int64_t end = now_ + duration.count();
    wait_for_other_threads();
    while (step(end) != Step::none) {
    }
    pass_to(end);
  }

  /// Lets time pass until the condition holds, at most `limit`. Returns whether it does.
  bool advance_until(const std::function<bool()> &condition,
                     std::chrono::nanoseconds limit = std::chrono::minutes(1)) {
    const std::int64_t end = now_ + limit.count();
    wait_for_other_threads();
    for (Step last = Step::other;; last = step(end)) {
      if (last != Step::loop && condition()) // the loop alone shows nothing
        return true;
      if (last == Step::none)
        return false;
    }
  }

  /// Makes a call on a thread of its own, and lets time pass only while the call waits for it.
  void run(const std::function<void()> &call) {
    std::atomic<bool> done = false;
    const std::jthread caller([&] {
      call();
      done = true;
    });
    for (wait_for_other_threads(); !done; wait_for_other_threads())
      if (step(kNever) == Step::none)
        std::this_thread::sleep_for(100us); // it waits for the machine
  }

  /// The machine sleeps for so long.
  void suspend(std::chrono::nanoseconds duration) { asleep_ += duration.count(); }

protected:
  // Of threads that wait in another way than by this clock.

  /// When the first of them is due, ns.
  virtual std::optional<std::int64_t> others_due() { return std::nullopt; }
  /// Wakes that one.
  virtual void wake_other() {}
  virtual void pass_to(std::int64_t now) { now_ = std::max(now_.load(), now); }

private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

  struct Sleeper {
    std::int64_t when = 0; // ns
    bool is_loop = false;
    std::thread::id thread = std::this_thread::get_id();
    bool woken = false;
    std::condition_variable_any wake = {};
  };

  enum class Step { none, loop, other };

  void sleep(Sleeper &&self, const std::stop_token &stop = {}) {
    std::unique_lock lock(mutex_);
    if (self.when <= now_)
      return;
    sleepers_.push_back(&self);
    fell_asleep_.notify_all();
    self.wake.wait(lock, stop, [&] { return self.woken; });
    std::erase(sleepers_, &self);
  }

  // Lets time pass until a thread is due, and that one run until it sleeps again.
  Step step(std::int64_t end) {
    std::unique_lock lock(mutex_);
    Sleeper *first = nullptr;
    for (Sleeper *sleeper : sleepers_) // of those due at the same time the loop is first
      if (!first || sleeper->when < first->when ||
          (sleeper->when == first->when && sleeper->is_loop && !first->is_loop))
        first = sleeper;
    const std::optional<std::int64_t> other = others_due();
    if (other && (!first || *other < first->when)) {
      if (*other > end)
        return Step::none;
      lock.unlock();
      pass_to(*other);
      wake_other();
    } else {
      if (!first || first->when > end)
        return Step::none;
      const bool is_loop = first->is_loop;
      const std::thread::id thread = first->thread;
      std::erase(sleepers_, first);
      pass_to(first->when);
      first->woken = true;
      first->wake.notify_all();
      // A loop wakes nobody else, so that there is no need to look at the others. Unless it ends.
      if (is_loop && fell_asleep_.wait_for(lock, 1ms, [&] {
            return std::ranges::find(sleepers_, thread, &Sleeper::thread) != sleepers_.end();
          }))
        return Step::loop;
      lock.unlock();
    }
    wait_for_other_threads();
    return Step::other;
  }

  std::atomic<std::int64_t> now_ = std::int64_t{1000} * 1'000'000'000; // ns
  std::atomic<std::int64_t> asleep_ = 0;                               // ns
  std::mutex mutex_;
  std::vector<Sleeper *> sleepers_; // mutex_
  std::condition_variable fell_asleep_;
};

} // namespace test
