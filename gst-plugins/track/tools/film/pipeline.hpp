// SPDX-License-Identifier: LGPL-2.1-or-later
// Pipelines of haptic-track and their errors.
#pragma once

#include "glue/gst-raii.hpp"
#include "track-error.hpp"

#include <atomic>
#include <cstring>
#include <functional>
#include <gst/gst.h>
#include <optional>
#include <string>

namespace haptic {

/// Called some times a second while a pipeline runs. What it throws ends the work.
using Poll = std::function<void()>;

inline constexpr GstClockTime kPollTime = 200 * GST_MSECOND;
inline constexpr GstClockTime kLongestStandstill = 30 * GST_SECOND;

inline ElementPtr make_pipeline() {
  return ElementPtr(GST_ELEMENT(gst_object_ref_sink(gst_pipeline_new(nullptr))));
}

/// Throws TrackFileError if there is no such element.
inline ElementPtr make_element(const char *factory) {
  GstElement *element = gst_element_factory_make(factory, nullptr);
  if (!element)
    throw_error(messages::kElementIsMissing, factory);
  return ElementPtr(GST_ELEMENT(gst_object_ref_sink(element)));
}

/// Throws TrackFileError if there is no such element. The pipeline owns it.
inline GstElement *add_element(GstElement *pipeline, const char *factory) {
  const ElementPtr owned = make_element(factory);
  GstElement *element = owned.get();
  gst_bin_add(GST_BIN(pipeline), element);
  return element;
}

/// The tag image-orientation of an event; empty if the event has none.
inline std::string rotation_of(GstEvent *event) {
  if (GST_EVENT_TYPE(event) != GST_EVENT_TAG)
    return "";
  GstTagList *tags = nullptr;
  gst_event_parse_tag(event, &tags);
  gchar *text = nullptr;
  gst_tag_list_get_string(tags, GST_TAG_IMAGE_ORIENTATION, &text);
  const GCharPtr owned(text);
  return text ? text : "";
}

inline std::string error_of(GstMessage *message) {
  GError *error = nullptr;
  gchar *details = nullptr;
  gst_message_parse_error(message, &error, &details);
  std::string text = error->message;
  // "Internal data stream error" needs its reason beside it.
  const char *reason = details ? std::strstr(details, "reason ") : nullptr;
  if (reason)
    text += std::string(" (") + reason + ")";
  g_free(details);
  g_error_free(error);
  return text;
}

/// Returns the segment in which the buffers of the pad are, or nothing before the first one.
std::optional<GstSegment> segment_of(GstPad *pad);

// Both return the time of a frame (ns), or GST_CLOCK_TIME_NONE. In AVI, frames that depend on
// others have a decoding time only.
GstClockTime running_time_of(GstPad *pad, const GstBuffer *buffer);
GstClockTime stream_time_of(GstPad *pad, const GstBuffer *buffer);

/// Returns the caps of a caps event, or null.
inline GstCaps *caps_in(GstEvent *event) {
  GstCaps *caps = nullptr;
  if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS)
    gst_event_parse_caps(event, &caps);
  return caps;
}

/// Returns the first message of these types. Throws TrackFileError with the error of the pipeline
/// instead.
MessagePtr wait_for(GstElement *pipeline, GstMessageType wanted, const Poll &poll);

/// Notices when nothing flows any more: damaged files let some elements wait for ever.
class Flow {
public:
  /// What passes this pad is progress.
  void watch(GstPad *pad);
  /// To be called by each Poll. Throws the sentence, with the s in it, after so long without
  /// progress. Polls are counted, not seconds: a process that was stopped does not poll.
  void check(const char *sentence, GstClockTime longest = kLongestStandstill);

private:
  std::atomic<std::size_t> flowed_ = 0; // buffers
  std::size_t before_ = 0;
  GstClockTime still_ = 0;
};

/// Lets a pipeline run until this goes.
class Running {
public:
  explicit Running(GstElement *pipeline, GstState state = GST_STATE_PLAYING) : pipeline_(pipeline) {
    gst_element_set_state(pipeline_, state);
  }
  ~Running() { gst_element_set_state(pipeline_, GST_STATE_NULL); }
  Running(const Running &) = delete;
  Running &operator=(const Running &) = delete;

private:
  GstElement *pipeline_;
};

} // namespace haptic
