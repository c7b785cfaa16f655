// SPDX-License-Identifier: LGPL-2.1-or-later
// Requests for key fields: the event GstForceKeyUnit, which encoders of video know too, and which
// rtpsession turns into a full intra request of RTCP (RFC 5104, section 3.5.1) and back.
#pragma once

#include <gst/gst.h>
#include <mutex>
#include <optional>
#include <set>

namespace haptic {

/// Makes a request for the encoder's source pad. The next field from this running time on (ns) is
/// to be a key field; at once without a time.
inline GstEvent *make_key_request(GstClockTime running_time) {
  return gst_event_new_custom(GST_EVENT_CUSTOM_UPSTREAM,
                              gst_structure_new("GstForceKeyUnit", "running-time",
                                                GST_TYPE_CLOCK_TIME, running_time, "all-headers",
                                                G_TYPE_BOOLEAN, TRUE, nullptr));
}

/// Asks a sender for what is needed to go on, by a request at the sink pad of a receiver.
class KeyAsker {
public:
  /// What came at `time` (ns) cannot be read for want of a key field. One request is sent, and
  /// again after kRepeat.
  void ask(GstPad *sink, GstClockTime time) {
    if (asked_ && (!GST_CLOCK_TIME_IS_VALID(time) || (time >= *asked_ && time - *asked_ < kRepeat)))
      return;
    asked_ = GST_CLOCK_TIME_IS_VALID(time) ? time : 0;
    gst_pad_push_event(sink, make_key_request(GST_CLOCK_TIME_NONE));
  }

private:
  // A request or its answer may be lost. rtpsession sends one within 200 ms.
  static constexpr GstClockTime kRepeat = 500 * GST_MSECOND;

  std::optional<GstClockTime> asked_;
};

/// The requests that wait for their time. For any thread.
class KeyRequests {
public:
  /// Of more than `most` the earliest are forgotten.
  explicit KeyRequests(std::size_t most = 1024) : most_(most) {}

  /// Returns false if the event is none.
  bool add(GstEvent *event) {
    const GstStructure *structure = gst_event_get_structure(event);
    if (!structure || !gst_structure_has_name(structure, "GstForceKeyUnit"))
      return false;
    GstClockTime time = 0;
    if (!gst_structure_get_clock_time(structure, "running-time", &time) ||
        !GST_CLOCK_TIME_IS_VALID(time))
      time = 0;
    const std::lock_guard lock(mutex_);
    times_.insert(time);
    if (times_.size() > most_)
      times_.erase(times_.begin());
    return true;
  }

  /// Returns whether one was for this running time or before. Forgets those.
  bool is_due(GstClockTime running_time) {
    const std::lock_guard lock(mutex_);
    const auto later = times_.upper_bound(running_time + kTolerance);
    const bool due = later != times_.begin();
    times_.erase(times_.begin(), later);
    return due;
  }

  void clear() {
    const std::lock_guard lock(mutex_);
    times_.clear();
  }

private:
  static constexpr GstClockTime kTolerance = GST_MSECOND; // a container may round a time

  const std::size_t most_;
  std::mutex mutex_;
  std::set<GstClockTime> times_; // the mutex
};

} // namespace haptic
