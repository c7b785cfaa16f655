// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/call-queue.hpp"

#include "glue/exception-barrier.hpp"

#include <chrono>
#include <utility>

namespace haptic {

namespace {

// That a thread waits for one call of another thread.
constexpr auto kLimit = std::chrono::milliseconds(100);

thread_local const CallQueue *making_calls_of = nullptr;

} // namespace

CallQueue::Time &CallQueue::machine_time() {
  static Time time;
  return time;
}

// The limit is one for each call: it begins anew when another thread has begun a further one. What
// drain() has once waited for in vain it does not wait for again.
void CallQueue::wait_until_free(std::unique_lock<std::mutex> &lock, Wait *wait) {
  // A call that has begun after its last one has waited for that one.
  const auto is_free = [&] { return calling_ == 0 || (wait && begun_ > wait->last); };
  if (!wait) {
    changed_.wait(lock, is_free);
    return;
  }
  while (!is_free()) {
    if (begun_ != wait->number) {
      wait->number = begun_;
      wait->deadline = time_.now() + wait->limit;
    }
    if (!time_.wait_until(changed_, lock, wait->deadline,
                          [&] { return is_free() || begun_ != wait->number; }))
      return;
  }
}

std::optional<CallQueue::Call> CallQueue::next(Wait *wait) {
  std::unique_lock lock(mutex_);
  wait_until_free(lock, wait);
  if (calls_.empty() || (wait && begun_ >= wait->last)) {
    if (!wait) {
      in_pool_ = false;
      changed_.notify_all();
    }
    return std::nullopt;
  }
  Call call = std::move(calls_.front());
  calls_.pop_front();
  ++calling_;
  ++begun_;
  if (wait)
    wait->number = begun_; // its own call gives the others no more time
  return call;
}

void CallQueue::make_calls(Wait *wait) {
  const CallQueue *before = std::exchange(making_calls_of, this);
  while (const std::optional<Call> call = next(wait)) {
    guarded(owner_, [&] { (*call)(); });
    const std::lock_guard lock(mutex_);
    --calling_;
    changed_.notify_all();
  }
  making_calls_of = before;
}

void CallQueue::add(Call call) {
  {
    const std::lock_guard lock(mutex_);
    calls_.push_back(std::move(call));
    if (std::exchange(in_pool_, true))
      return;
  }
  gst_element_call_async( // which holds a reference to the element
      owner_,
      [](GstElement *element, gpointer queue) {
        guarded(element, [&] { static_cast<CallQueue *>(queue)->make_calls(nullptr); });
      },
      this, nullptr);
}

void CallQueue::drain() {
  const bool within_call = making_calls_of == this; // whose handler has changed the state
  Wait wait{.limit = within_call ? Clock::duration::zero() : kLimit};
  {
    const std::lock_guard lock(mutex_);
    wait.last = begun_ + calls_.size();
  }
  make_calls(&wait);
}

void CallQueue::finish() {
  drain();
  std::unique_lock lock(mutex_);
  if (making_calls_of != this)
    time_.wait_until(changed_, lock, time_.now() + kLimit, [this] { return !in_pool_; });
}

} // namespace haptic
