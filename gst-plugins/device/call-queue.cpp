// SPDX-License-Identifier: LGPL-2.1-or-later
#include "call-queue.hpp"

#include "exception-barrier.hpp"

#include <utility>

namespace haptic {

std::optional<CallQueue::Call> CallQueue::next(bool in_pool) {
  const std::lock_guard lock(mutex_);
  if (calls_.empty()) {
    in_pool_ = in_pool_ && !in_pool;
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
        guarded(element, [&] { static_cast<CallQueue *>(queue)->make_calls(true); });
      },
      this, nullptr);
}

void CallQueue::drain() {
  make_calls(false);
}

} // namespace haptic
