// SPDX-License-Identifier: LGPL-2.1-or-later
// Calls of application code (handlers of `notify`, of bus messages) on behalf of threads from which
// a handler must not change the state: those that a state change ends, and the streaming thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <gst/gst.h>
#include <mutex>
#include <optional>

namespace haptic {

/// Makes the calls one after the other, from a thread of GStreamer's pool. It belongs to an
/// element, which lives until the calls are made.
class CallQueue {
public:
  using Call = std::function<void()>;
  using Clock = std::chrono::steady_clock;

  /// What passes while it waits. Tests have one of their own.
  class Time {
  public:
    virtual ~Time() = default;
    virtual Clock::time_point now() const { return Clock::now(); }
    /// Waits for `changed` until `done()`, at most until `deadline`. Returns done().
    virtual bool wait_until(std::condition_variable &changed, std::unique_lock<std::mutex> &lock,
                            Clock::time_point deadline, const std::function<bool()> &done) {
      return changed.wait_until(lock, deadline, done);
    }
  };
  static Time &machine_time();

  /// `time` outlives the queue.
  explicit CallQueue(GstElement *owner, Time &time = machine_time()) : owner_(owner), time_(time) {}

  void add(Call call);
  /// Makes the calls that are left, in the present thread, after those that another thread makes.
  /// It waits for each of those at most a tenth of a second, since a handler may itself wait for
  /// the present thread. Calls that are added meanwhile are the pool's: they cannot hold it up.
  void drain();
  /// The same, and waits at most as long again until the pool's thread makes none.
  void finish();

private:
  // How long drain() waits for a call of another thread, and until when for the one of that number.
  struct Wait {
    Clock::duration limit;
    std::uint64_t last = 0; // the number of the last call that drain() is for
    std::uint64_t number = 0;
    Clock::time_point deadline;
  };

  // A null `wait`: the pool's thread, which has the time.
  std::optional<Call> next(Wait *wait);
  void wait_until_free(std::unique_lock<std::mutex> &lock, Wait *wait);
  void make_calls(Wait *wait);

  GstElement *owner_;
  Time &time_;
  // Guards the members below. A thread of the pool makes calls while in_pool_ is true. changed_ is
  // notified when that or calling_ falls.
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Call> calls_;
  bool in_pool_ = false;
  int calling_ = 0;         // calls under way; more than one where drain() has waited in vain
  std::uint64_t begun_ = 0; // calls so far: the number of the newest one
};

} // namespace haptic
