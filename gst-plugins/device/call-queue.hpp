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
  std::mutex mutex_;
  std::condition_variable idle_; // in_pool_ became false
  std::deque<Call> calls_; // mutex_
  bool in_pool_ = false;   // mutex_; a thread of the pool makes calls
};

} // namespace haptic
