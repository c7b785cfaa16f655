// SPDX-License-Identifier: LGPL-2.1-or-later
// Pipelines of haptic-track and their errors.
#pragma once

#include "glue/gst-raii.hpp"
#include "track-error.hpp"

#include <cstring>
#include <gst/gst.h>
#include <string>

namespace haptic {

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

} // namespace haptic
