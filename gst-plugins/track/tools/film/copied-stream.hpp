// SPDX-License-Identifier: LGPL-2.1-or-later
// Streams of a file that go into another container as they are.
#pragma once

#include "glue/gst-raii.hpp"

#include <gst/gst.h>
#include <string>

namespace haptic {

/// Returns the media type.
const char *name_of(const GstCaps *caps);

/// Returns the caps of the pad, or those that it may get.
CapsPtr caps_of(GstPad *pad);

/// Returns whether the muxer has a place for the stream of the pad, in whatever form.
bool has_place(const char *mux, GstPad *pad);

/// Handler of parsebin's signal autoplug-continue: subtitles with a style stay as they are.
gboolean is_parsed_further(GstElement *, GstPad *, GstCaps *caps, gpointer);

/// Adds a queue with a limit of bytes alone.
GstElement *add_queue(GstElement *pipeline, guint bytes);

// These four throw TrackFileError.
/// Adds a muxer that writes to a file, with the marks of hapticmark.
GstElement *add_muxer(GstElement *pipeline, const char *factory, const std::string &path);
void link_elements(GstElement *from, GstElement *to);
void link_pad(GstPad *pad, GstElement *to);
/// Links the stream of `from`, in the same bin, to the muxer: only its form changes. Returns the
/// pad that is linked to the muxer.
PadPtr link_untouched(GstElement *from, GstCaps *caps, GstElement *mux, bool is_matroska);

} // namespace haptic
