// SPDX-License-Identifier: LGPL-2.1-or-later
#include "film/pipeline.hpp"

#include "glue/content-only.hpp"
#include "glue/segment-time.hpp"

#include <cstring>
#include <gst/pbutils/pbutils.h>

namespace haptic {
namespace {

GstClockTime time_of(const GstBuffer *buffer) {
  return GST_BUFFER_PTS_IS_VALID(buffer) ? GST_BUFFER_PTS(buffer) : GST_BUFFER_DTS(buffer);
}

std::string error_of(GstMessage *message) {
  GError *failure = nullptr;
  gchar *text = nullptr;
  gst_message_parse_error(message, &failure, &text);
  const ErrorPtr error(failure);
  const GCharPtr details(text);
  // "Internal data stream error" needs its reason beside it.
  const char *reason = text ? std::strstr(text, "reason ") : nullptr;
  return reason ? format_text("%s (%s)", error->message, reason) : error->message;
}

ElementPtr parse_line(const std::string &line, GstParseFlags flags) {
  GError *wrong = nullptr;
  GstParseContext *context = gst_parse_context_new();
  ElementPtr parsed(gst_parse_launch_full(line.c_str(), context, flags, &wrong));
  const ErrorPtr error(wrong);
  const std::unique_ptr<gchar *, decltype(&g_strfreev)> missing(
      gst_parse_context_get_missing_elements(context), g_strfreev);
  gst_parse_context_free(context);
  if (missing)
    throw_error(messages::kElementIsMissing, *missing);
  if (!parsed || error)
    throw TrackFileError(error ? error->message : "unknown");
  return parsed;
}

} // namespace

GstElement *add_element(GstElement *pipeline, const char *factory, const char *name) {
  GstElement *element = gst_element_factory_make(factory, name);
  if (!element)
    throw_error(messages::kElementIsMissing, factory);
  gst_bin_add(GST_BIN(pipeline), element);
  return element;
}

ElementPtr make_pipeline(const std::string &line) {
  return parse_line(line, GST_PARSE_FLAG_NONE);
}

GstElement *add_bin(GstElement *pipeline, const std::string &line) {
  GstElement *bin = parse_line(line, GST_PARSE_FLAG_PLACE_IN_BIN).release(); // a floating reference
  gst_bin_add(GST_BIN(pipeline), bin);
  return bin;
}

ElementPtr element_in(GstElement *pipeline, const char *name) {
  return ElementPtr(gst_bin_get_by_name(GST_BIN(pipeline), name));
}

std::string rotation_of(GstEvent *event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_TAG)
    return "";
  GstTagList *tags = nullptr;
  gst_event_parse_tag(event, &tags);
  gchar *text = nullptr;
  gst_tag_list_get_string(tags, GST_TAG_IMAGE_ORIENTATION, &text);
  const GCharPtr owned(text);
  return text ? text : "";
}

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
  return segment ? running_time_of(*segment, time_of(buffer)) : GST_CLOCK_TIME_NONE;
}

GstClockTime stream_time_of(GstPad *pad, const GstBuffer *buffer) {
  const auto segment = segment_of(pad);
  return segment ? stream_time_of(*segment, time_of(buffer)) : GST_CLOCK_TIME_NONE;
}

std::optional<std::int64_t> signed_stream_time_of(GstPad *pad, const GstBuffer *buffer) {
  const auto segment = segment_of(pad);
  const GstClockTime stamp = time_of(buffer);
  guint64 time = 0;
  const gint sign = segment && GST_CLOCK_TIME_IS_VALID(stamp) && stamp <= segment->stop
                        ? gst_segment_to_stream_time_full(&*segment, GST_FORMAT_TIME, stamp, &time)
                        : 0;
  return sign == 0 ? std::nullopt : std::optional(sign * static_cast<std::int64_t>(time));
}

GstCaps *caps_in(GstEvent *event) {
  GstCaps *caps = nullptr;
  if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS)
    gst_event_parse_caps(event, &caps);
  return caps;
}

void fail(GstPad *pad, const char *text) {
  GstObject *top = GST_OBJECT(pad);
  while (GST_OBJECT_PARENT(top))
    top = GST_OBJECT_PARENT(top);
  GST_ELEMENT_ERROR(top, STREAM, FAILED, ("%s", text), (nullptr));
}

MessagePtr wait_for(GstElement *pipeline, GstMessageType wanted, const Poll &poll) {
  const BusPtr bus(gst_element_get_bus(pipeline));
  std::string missing;
  for (;;) {
    MessagePtr message(gst_bus_timed_pop_filtered(
        bus.get(), kPollTime,
        static_cast<GstMessageType>(wanted | GST_MESSAGE_ERROR | GST_MESSAGE_ELEMENT)));
    throw_if_interrupted();
    if (poll)
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
  watch_buffers(pad, [this](GstPad *, GstBuffer *) { ++flowed_; });
}

void Flow::check(const char *sentence, GstClockTime longest) {
  still_ = before_ == flowed_ ? still_ + kPollTime : 0;
  before_ = flowed_;
  if (still_ > longest)
    throw_error("%s", format_text(sentence, static_cast<int>(longest / GST_SECOND)).c_str());
}

FilePipeline::FilePipeline(const std::string &path, const std::string &reader,
                           const std::string &rest) {
  gst_init(nullptr, nullptr);
  pipeline_ = make_pipeline("filesrc name=source ! " + reader + " name=reader" + rest);
  reader_ = element_in(get(), "reader").get(); // the pipeline's
  const ElementPtr source = element_in(get(), "source");
  g_object_set(source.get(), "location", path.c_str(), nullptr);
  if (g_signal_lookup("autoplug-select", G_OBJECT_TYPE(reader_)) != 0)
    open_content_only(reader_, messages::kFileNamesOthers);
  watch(PadPtr(gst_element_get_static_pad(source.get(), "src")).get());
}

MessagePtr FilePipeline::run(GstState state, GstMessageType wanted, const char *sentence,
                             GstClockTime longest) {
  gst_element_set_state(get(), state);
  return wait_for(get(), wanted, [&] { flow_.check(sentence, longest); });
}

} // namespace haptic
