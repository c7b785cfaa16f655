// SPDX-License-Identifier: LGPL-2.1-or-later
// The pixels of a buffer that holds a frame, and a buffer for new metadata on shared pixels.
#pragma once

#include <gst/video/gstvideometa.h>
#include <gst/video/video.h>

namespace haptic {

/// Maps a frame for a scope. False: the buffer does not hold such a frame.
class MappedFrame {
public:
  MappedFrame(const GstVideoInfo &info, GstBuffer *buffer, GstMapFlags access = GST_MAP_READ) {
    // Takes no reference: the buffer must stay writable for the metadata.
    const auto flags = static_cast<GstMapFlags>(static_cast<int>(access) |
                                                static_cast<int>(GST_VIDEO_FRAME_MAP_FLAG_NO_REF));
    is_mapped_ = fits(info, buffer) && gst_video_frame_map(&frame_, &info, buffer, flags);
  }
  ~MappedFrame() {
    if (is_mapped_)
      gst_video_frame_unmap(&frame_);
  }
  MappedFrame(const MappedFrame &) = delete;
  MappedFrame &operator=(const MappedFrame &) = delete;

  explicit operator bool() const { return is_mapped_; }
  const GstVideoFrame &frame() const { return frame_; }
  GstVideoFrame &frame() { return frame_; }

private:
  // gst_video_frame_map() asserts that the buffer's description agrees with the caps.
  static bool fits(const GstVideoInfo &info, GstBuffer *buffer) {
    const GstVideoMeta *meta = gst_buffer_get_video_meta(buffer);
    return !meta || (meta->format == GST_VIDEO_INFO_FORMAT(&info) &&
                     meta->width >= static_cast<guint>(GST_VIDEO_INFO_WIDTH(&info)) &&
                     meta->height >= static_cast<guint>(GST_VIDEO_INFO_HEIGHT(&info)));
  }

  // GstMapFlags has no name for 0.
  GstVideoFrame frame_{}; // NOLINT(bugprone-invalid-enum-default-initialization)
  bool is_mapped_ = false;
};

/// Returns the buffer itself if nobody else holds it, a new one that shares its pixels if somebody
/// does, or null on failure. Does not take `in`.
inline GstBuffer *with_own_metadata(GstBuffer *in) {
  if (gst_buffer_is_writable(in))
    return in;
  GstBuffer *out = gst_buffer_new();
  if (!gst_buffer_copy_into(
          out, in,
          static_cast<GstBufferCopyFlags>(static_cast<int>(GST_BUFFER_COPY_METADATA) |
                                          static_cast<int>(GST_BUFFER_COPY_MEMORY)),
          0, static_cast<gsize>(-1))) {
    gst_buffer_unref(out);
    return nullptr;
  }
  // A buffer of a pool must not go back there while its memory is in use.
  gst_buffer_add_parent_buffer_meta(out, in);
  return out;
}

} // namespace haptic
