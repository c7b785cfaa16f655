// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/relief-pad.hpp"

#include "glue/gst-raii.hpp"
#include "glue/relief-pad.hpp"

#include <algorithm>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>

namespace haptic {
namespace {

constexpr std::int64_t kLook = 5'000'000;            // ns, between two looks at the clock
constexpr std::uint64_t kLongestAhead = 750'000'000; // ns, as SampleIntake
constexpr double kAheadIntervals = 1.5;

// The parent's lock is never held here.
class ReliefPad {
public:
  ReliefPad(HapticSession &session, PresentationTime &time) : session_(session), time_(time) {
    gst_segment_init(&segment_, GST_FORMAT_TIME);
    flush_.request_stop(); // until activated
  }

  GstFlowReturn chain(GstObject *, GstBuffer *buffer) {
    const auto due = wait_for(GST_BUFFER_PTS(buffer));
    if (!due)
      return GST_FLOW_FLUSHING;
    session_.accept_relief(ReadableBuffer(buffer).bytes(),
                           GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_GAP), *due);
    return GST_FLOW_OK;
  }

  void handle(GstEvent *event) {
    switch (GST_EVENT_TYPE(event)) {
    case GST_EVENT_SEGMENT:
      gst_event_copy_segment(event, &segment_);
      break;
    case GST_EVENT_GAP:
      accept_gap(event);
      break;
    case GST_EVENT_FLUSH_START:
      set_flushing(true);
      session_.drop_reliefs();
      break;
    case GST_EVENT_FLUSH_STOP:
      gst_segment_init(&segment_, GST_FORMAT_TIME);
      session_.drop_reliefs(); // one that chain() was about to hand over
      set_flushing(false);
      break;
    default:
      break;
    }
  }

  void set_active(bool active) { set_flushing(!active); }

private:
  void set_flushing(bool flushing) {
    const std::lock_guard lock(mutex_);
    if (flushing)
      flush_.request_stop();
    else
      flush_ = {};
  }

  void accept_gap(GstEvent *event) {
    GstClockTime pts = GST_CLOCK_TIME_NONE;
    gst_event_parse_gap(event, &pts, nullptr);
    if (const auto due = wait_for(pts))
      session_.accept_relief({}, true, *due);
  }

  // Returns when a relief is due, once it may be handed over; nothing if the pad is flushing.
  std::optional<std::int64_t> wait_for(GstClockTime pts) {
    const std::int64_t due = time_.of(segment_, pts);
    if (due != kAtOnce && !wait_until(due - ahead()))
      return std::nullopt;
    return due;
  }

  std::int64_t ahead() const {
    const double intervals = kAheadIntervals * static_cast<double>(session_.reliefs().interval());
    return static_cast<std::int64_t>(std::min(intervals, static_cast<double>(kLongestAhead)));
  }

  // Returns false if the pad is flushing.
  bool wait_until(std::int64_t running) {
    const std::stop_token flush = flushing();
    LoopClock &clock = session_.clock();
    while (!flush.stop_requested() &&
           (session_.is_paused() || !time_.is_known() || session_.running_time() < running))
      clock.wait_until(clock.now() + kLook, flush);
    return !flush.stop_requested();
  }

  std::stop_token flushing() {
    const std::lock_guard lock(mutex_);
    return flush_.get_token();
  }

  HapticSession &session_;
  PresentationTime &time_;
  GstSegment segment_{}; // streaming thread
  std::mutex mutex_;
  std::stop_source flush_; // mutex_; the pad is flushing if its stop is requested
};

} // namespace

GstPad *add_relief_pad(GstElement *element, GstPadTemplate *of, HapticSession &session,
                       PresentationTime &time) {
  return add_stream_pad(element, of, std::make_unique<ReliefPad>(session, time));
}

void remove_relief_pad(GstElement *element, GstPad *pad, HapticSession &session) {
  gst_pad_set_active(pad, FALSE); // returns after chain()
  session.drop_reliefs();
  gst_element_remove_pad(element, pad);
}

} // namespace haptic
