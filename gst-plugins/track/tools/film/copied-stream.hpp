// SPDX-License-Identifier: LGPL-2.1-or-later
// Streams of a file that go into another container as they are.
#pragma once

#include "glue/gst-raii.hpp"

#include <cstdint>
#include <gst/gst.h>
#include <string>
#include <utility>
#include <vector>

namespace haptic {

/// Returns the media type.
const char *name_of(const GstCaps *caps);

/// Returns the caps of the pad, or those that it may get.
CapsPtr caps_of(GstPad *pad);

/// Puts a buffer with what `edit` makes of its bytes in place of it.
template <typename Bytes = std::vector<std::uint8_t>, typename Edit>
void edit_buffer(GstBuffer *&buffer, const Edit &edit) {
  Bytes bytes(gst_buffer_get_size(buffer), {});
  gst_buffer_extract(buffer, 0, bytes.data(), bytes.size());
  edit(bytes);
  const BufferPtr before(std::exchange(buffer, gst_buffer_new_memdup(bytes.data(), bytes.size())));
  gst_buffer_copy_into(buffer, before.get(), GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
}

/// The size of frames, px.
struct FrameSize {
  gint width = 0; ///< 0: not known
  gint height = 0;
  bool operator==(const FrameSize &) const = default;
};
FrameSize size_in(const GstCaps *caps);

/// Endings of what copies of streams go into, and its muxer.
inline constexpr char kTransportStream[] = ".ts";
inline constexpr char kMatroska[] = ".mkv";
inline const char *muxer_of(const std::string &ending) {
  return ending == kMatroska ? "matroskamux" : "mpegtsmux";
}

/// Returns whether the muxer has a place for the stream of the pad, in whatever form.
bool has_place(const char *mux, GstPad *pad);

/// Adds a queue with a limit of bytes alone.
GstElement *add_queue(GstElement *pipeline, guint bytes);

// These throw TrackFileError.
/// Adds a muxer that writes to a file, with the marks of hapticmark.
GstElement *add_muxer(GstElement *pipeline, const char *factory, const std::string &path);
/// These link what lies in bins, too.
void link_elements(GstElement *from, GstElement *to);
void link_pad(GstPad *pad, GstElement *to);
/// Links the stream of the pad, which will be `offset` ns later, to the muxer behind a queue: only
/// its form changes. Returns the pad that is linked to the muxer.
PadPtr copy_stream(GstPad *pad, guint queue_bytes, gint64 offset, GstElement *mux,
                   bool is_matroska);

/// Frames that an edit list hides before the first shown one are decoded, but a muxer would leave
/// them out. The copied stream of the pad begins with them, so many ns earlier; what is shown is as
/// much later.
void begin_earlier(GstPad *pad, std::uint64_t by);

} // namespace haptic
