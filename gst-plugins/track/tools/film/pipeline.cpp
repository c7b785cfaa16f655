// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/pipeline.hpp"

#include <gst/pbutils/pbutils.h>

namespace haptic {
namespace {

GstClockTime time_of(const GstBuffer *buffer) {
  return GST_BUFFER_PTS_IS_VALID(buffer) ? GST_BUFFER_PTS(buffer) : GST_BUFFER_DTS(buffer);
}

} // namespace

std::optional<GstSegment> segment_of(GstPad *pad) {
  const EventPtr event(gst_pad_get_sticky_event(pad, GST_EVENT_SEGMENT, 0));
  if (!event)
    return std::nullopt;
  const GstSegment *segment = nullptr;
  gst_event_parse_segment(event.get(), &segment);
  return *segment;
}

GstClockTime running_time_of(GstPad *pad, const GstBuffer *buffer) {
  const auto segment = segment_of(pad);
  return segment ? gst_segment_to_running_time(&*segment, GST_FORMAT_TIME, time_of(buffer))
                 : GST_CLOCK_TIME_NONE;
}

GstClockTime stream_time_of(GstPad *pad, const GstBuffer *buffer) {
  const auto segment = segment_of(pad);
  return segment ? gst_segment_to_stream_time(&*segment, GST_FORMAT_TIME, time_of(buffer))
                 : GST_CLOCK_TIME_NONE;
}

MessagePtr wait_for(GstElement *pipeline, GstMessageType wanted, const Poll &poll) {
  const BusPtr bus(gst_element_get_bus(pipeline));
  std::string missing;
  for (;;) {
    MessagePtr message(gst_bus_timed_pop_filtered(
        bus.get(), kPollTime,
        static_cast<GstMessageType>(wanted | GST_MESSAGE_ERROR | GST_MESSAGE_ELEMENT)));
    poll();
    if (!message)
      continue;
    const GstMessageType type = GST_MESSAGE_TYPE(message.get());
    const bool is_own = GST_MESSAGE_SRC(message.get()) == GST_OBJECT(pipeline);
    if (type == GST_MESSAGE_ERROR)
      throw TrackFileError(missing.empty() || is_own ? error_of(message.get()) : missing);
    if ((type & wanted) != 0)
      return message;
    if (gst_is_missing_plugin_message(message.get())) {
      const GCharPtr what(gst_missing_plugin_message_get_description(message.get()));
      missing = format_text(messages::kDecoderIsMissing, what.get());
    }
  }
}

void Flow::watch(GstPad *pad) {
  const auto count = [](GstPad *, GstPadProbeInfo *, gpointer data) {
    ++*static_cast<std::atomic<std::size_t> *>(data);
    return GST_PAD_PROBE_OK;
  };
  gst_pad_add_probe(pad, GST_PAD_PROBE_TYPE_BUFFER, count, &flowed_, nullptr);
}

void Flow::check(const char *sentence, GstClockTime longest) {
  still_ = before_ == flowed_ ? still_ + kPollTime : 0;
  before_ = flowed_;
  if (still_ > longest)
    throw_error("%s", format_text(sentence, static_cast<int>(longest / GST_SECOND)).c_str());
}

} // namespace haptic
