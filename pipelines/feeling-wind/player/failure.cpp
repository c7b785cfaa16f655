// SPDX-License-Identifier: LGPL-2.1-or-later
#include "player/failure.hpp"

#include "glue/gst-raii.hpp"

#include <gst/pbutils/missing-plugins.h>

namespace program {
namespace {

bool is(const GError &error, GQuark domain, int code) {
  return g_error_matches(&error, domain, code);
}

// GStreamer's own text ends with a stop or without one.
std::string reason_of(const GError &error) {
  std::string text = error.message;
  while (!text.empty() && (text.back() == '.' || text.back() == ' ' || text.back() == '\n'))
    text.pop_back();
  return text;
}

// A film may have a track of subtitles or metadata, which is not needed.
bool is_needed(const GstStructure *missing) {
  const GValue *detail = gst_structure_get_value(missing, "detail");
  if (!detail || !GST_VALUE_HOLDS_CAPS(detail))
    return true;
  const GstCaps *caps = gst_value_get_caps(detail);
  const char *type = gst_structure_get_name(gst_caps_get_structure(caps, 0));
  return g_str_has_prefix(type, "video/") || g_str_has_prefix(type, "audio/");
}

} // namespace

std::string failure_sentence(const GError &error, const Source &source,
                             const std::string &missing) {
  if (!missing.empty())
    return missing;
  const std::string name = "“" + source.title + "”";
  if (source.kind == SourceKind::camera) {
    if (is(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_BUSY))
      return "The camera " + source.name +
             " is used by another program. End that one, or choose another camera (Ctrl+K).";
    return "The camera " + source.name + " does not work: " + reason_of(error) +
           ". Plug it in again, or choose another (Ctrl+K).";
  }
  const char *reach = ". Check the address and the network.";
  if (source.is_remote() && is(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_SEEK))
    return name +
           " cannot be played from a server that does not send parts of a file. Download it, "
           "and open the file.";
  if (source.is_remote() && error.domain == GST_RESOURCE_ERROR)
    return name + " cannot be reached: " + reason_of(error) + reach;
  // souphttpsrc says no more when a connection is refused.
  if (source.is_remote() && is(error, GST_STREAM_ERROR, GST_STREAM_ERROR_FAILED))
    return name + " cannot be reached, or not read any further" + reach;
  if (is(error, GST_RESOURCE_ERROR, GST_RESOURCE_ERROR_NOT_FOUND))
    return "There is no file " + name + ". Check its name, or open another.";
  if (is(error, GST_STREAM_ERROR, GST_STREAM_ERROR_TYPE_NOT_FOUND) ||
      is(error, GST_STREAM_ERROR, GST_STREAM_ERROR_WRONG_TYPE))
    return name + " is not a film that can be played. Open another.";
  return name + " cannot be played: " + reason_of(error) + ". Open another.";
}

std::string missing_plugin(GstMessage *message) {
  if (!gst_is_missing_plugin_message(message) || !is_needed(gst_message_get_structure(message)))
    return "";
  const haptic::GCharPtr what(gst_missing_plugin_message_get_description(message));
  const char *type = gst_structure_get_string(gst_message_get_structure(message), "type");
  const bool decoder = g_strcmp0(type, "decoder") == 0;
  return std::string("Missing here: ") + what.get() + ". Install the package " +
         (decoder ? "gstreamer1.0-libav"
                  : "gstreamer1.0-plugins-good or gstreamer1.0-plugins-bad") +
         ", and open it again.";
}

} // namespace program
