// SPDX-License-Identifier: LGPL-2.1-or-later
// Calls of application code (handlers of `notify`, of bus messages) on behalf of threads from which
// a handler must not change the state: those that a state change ends, and the streaming thread.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <gst/gst.h>
#include <mutex>
#include <optional>

namespace haptic {

/// Makes the calls in order, from a thread of GStreamer's pool. It belongs to an element, which
/// lives until the calls are made.
class CallQueue {
public:
  using Call = std::function<void()>;

  explicit CallQueue(GstElement *owner) : owner_(owner) {}

  void add(Call call);
  /// Makes the calls that are left, in the present thread.
  void drain();
  /// The same, and waits until the pool's thread makes none: for at most a tenth of a second, since
  /// a handler may itself wait for the present thread.
  void finish();

private:
  std::optional<Call> next(bool in_pool);
  void make_calls(bool in_pool);

  GstElement *owner_;
  // Guards calls_ and in_pool_. A thread of the pool makes calls while in_pool_ is true; idle_ is
  // notified when it becomes false.
  std::mutex mutex_;
  std::condition_variable idle_;
  std::deque<Call> calls_;
  bool in_pool_ = false;
};

} // namespace haptic
