// SPDX-License-Identifier: LGPL-2.1-or-later
#include "call-queue.hpp"

#include "exception-barrier.hpp"

#include <chrono>
#include <utility>

namespace haptic {

namespace {

thread_local const CallQueue *making_calls_of = nullptr; // in the pool

} // namespace

std::optional<CallQueue::Call> CallQueue::next(bool in_pool) {
  const std::lock_guard lock(mutex_);
  if (calls_.empty()) {
    if (in_pool) {
      in_pool_ = false;
      idle_.notify_all();
    }
    return std::nullopt;
  }
  Call call = std::move(calls_.front());
  calls_.pop_front();
  return call;
}

void CallQueue::make_calls(bool in_pool) {
  while (const std::optional<Call> call = next(in_pool))
    guarded(owner_, [&] { (*call)(); });
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
        making_calls_of = static_cast<CallQueue *>(queue);
        guarded(element, [&] { static_cast<CallQueue *>(queue)->make_calls(true); });
        making_calls_of = nullptr;
      },
      this, nullptr);
}

void CallQueue::drain() {
  make_calls(false);
}

void CallQueue::finish() {
  constexpr auto kLimit = std::chrono::milliseconds(100);
  drain();
  std::unique_lock lock(mutex_);
  if (making_calls_of != this)
    idle_.wait_for(lock, kLimit, [this] { return !in_pool_; });
}

} // namespace haptic
