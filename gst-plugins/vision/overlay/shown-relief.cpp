// SPDX-License-Identifier: LGPL-2.1-or-later
#include "overlay/shown-relief.hpp"

#include "glue/exception-barrier.hpp"
#include "glue/gst-raii.hpp"

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

  void chain(GstObject *parent, GstBuffer *buffer) {
    const ReadableBuffer readable(buffer);
    if (!readable)
      return;
    const std::uint64_t time =
        gst_segment_to_running_time(&segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
    if (!relief.add(readable.bytes(), time))
      GST_WARNING_OBJECT(parent, "%" GST_PTR_FORMAT " is no relief", static_cast<void *>(buffer));
  }

  void handle(GstEvent *event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_SEGMENT)
      gst_event_copy_segment(event, &segment);
    else if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) {
      gst_segment_init(&segment, GST_FORMAT_TIME);
      relief.clear();
    }
  }

  ShownRelief &relief;
  GstSegment segment{};
};

ReliefStream &stream_of(GstPad *pad) {
  return *static_cast<ReliefStream *>(gst_pad_get_element_private(pad));
}

} // namespace

GstPadTemplate *shown_relief_template() {
  static GstStaticPadTemplate relief = GST_STATIC_PAD_TEMPLATE(
      "relief", GST_PAD_SINK, GST_PAD_REQUEST, GST_STATIC_CAPS(HAPTIC_RELIEF_CAPS));
  return gst_static_pad_template_get(&relief);
}

GstPad *add_shown_relief_pad(GstElement *element, GstPadTemplate *of, ShownRelief &relief) {
  if (GST_ELEMENT_CAST(element)->numsinkpads > 1)
    return nullptr;
  auto stream = std::make_unique<ReliefStream>(relief);
  GstPad *pad = gst_pad_new_from_template(of, "relief");
  gst_pad_set_element_private(pad, stream.get());
  g_object_set_data_full(G_OBJECT(pad), "shown-relief", stream.release(),
                         [](gpointer data) { delete static_cast<ReliefStream *>(data); });
  gst_pad_set_chain_function(pad, [](GstPad *self, GstObject *parent, GstBuffer *buffer) {
    const GstFlowReturn result = guarded(parent, GST_FLOW_ERROR, [&] {
      stream_of(self).chain(parent, buffer);
      return GST_FLOW_OK;
    });
    gst_buffer_unref(buffer);
    return result;
  });
  gst_pad_set_event_function(pad, [](GstPad *self, GstObject *parent, GstEvent *event) -> gboolean {
    guarded(parent, [&] { stream_of(self).handle(event); });
    gst_event_unref(event); // the end of the stream is that of the pad `sink`
    return TRUE;
  });
  gst_pad_set_activatemode_function(
      pad, [](GstPad *self, GstObject *parent, GstPadMode mode, gboolean active) -> gboolean {
        if (!active)
          guarded(parent, [&] { stream_of(self).relief.clear(); });
        return mode == GST_PAD_MODE_PUSH;
      });
  gst_pad_set_active(pad, GST_STATE(element) > GST_STATE_READY);
  gst_element_add_pad(element, pad);
  return pad;
}

} // namespace haptic
