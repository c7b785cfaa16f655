// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/shown-relief.hpp"

#include "glue/gst-raii.hpp"
#include "glue/relief-pad.hpp"
#include "glue/segment-time.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace haptic {

bool ShownRelief::add(std::span<const std::uint8_t> bytes, std::uint64_t time) {
  if (!unpack_relief_field(bytes, arriving_))
    return false;
  const std::lock_guard lock(mutex_);
  Dated &place = ring_[count_++ % ring_.size()];
  std::swap(place.relief, arriving_); // keeps the memory of both
  place.time = time;
  return true;
}

void ShownRelief::clear() {
  const std::lock_guard lock(mutex_);
  count_ = 0;
}

const ShownRelief::Dated *ShownRelief::find(std::uint64_t time) const {
  const Dated *found = nullptr;
  for (std::size_t back = 1; back <= std::min(count_, ring_.size()); ++back) {
    found = &ring_[(count_ - back) % ring_.size()];
    if (time == GST_CLOCK_TIME_NONE || found->time == GST_CLOCK_TIME_NONE || found->time <= time)
      break;
  }
  return found;
}

bool ShownRelief::read_at(std::uint64_t time, const std::function<void(const ReliefField &)> &use) {
  const std::lock_guard lock(mutex_);
  const Dated *found = find(time);
  if (!found)
    return false;
  if (time != GST_CLOCK_TIME_NONE && found->time != GST_CLOCK_TIME_NONE && found->time < time &&
      time - found->time > kLongest)
    return false;
  use(found->relief);
  return true;
}

namespace {

// Streaming thread of the pad.
struct ReliefStream {
  explicit ReliefStream(ShownRelief &into) : relief(into) {
    gst_segment_init(&segment, GST_FORMAT_TIME);
  }

  GstFlowReturn chain(GstObject *parent, GstBuffer *buffer) {
    const ReadableBuffer readable(buffer);
    if (!readable)
      return GST_FLOW_OK;
    const std::uint64_t time = running_time_of(segment, GST_BUFFER_PTS(buffer));
    if (!relief.add(readable.bytes(), time))
      GST_WARNING_OBJECT(parent, "%" GST_PTR_FORMAT " is no relief", static_cast<void *>(buffer));
    return GST_FLOW_OK;
  }

  void handle(GstEvent *event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT)
      gst_event_copy_segment(event, &segment);
    else if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) {
      gst_segment_init(&segment, GST_FORMAT_TIME);
      relief.clear();
    }
  }

  void set_active(bool active) {
    if (!active)
      relief.clear();
  }

  ShownRelief &relief;
  GstSegment segment{};
};

} // namespace

GstPad *add_shown_relief_pad(GstElement *element, GstPadTemplate *of, ShownRelief &relief) {
  return add_stream_pad(element, of, std::make_unique<ReliefStream>(relief));
}

} // namespace haptic
