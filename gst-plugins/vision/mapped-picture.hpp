// A picture mapped for reading.
#pragma once

#include <gst/video/gstvideometa.h>
#include <gst/video/video.h>

namespace haptic {

class MappedPicture {
public:
  MappedPicture(const GstVideoInfo &info, GstBuffer *buffer) {
    // Without a reference of its own: the buffer must stay writable for metadata.
    const auto flags = static_cast<GstMapFlags>(static_cast<int>(GST_MAP_READ) |
                                                static_cast<int>(GST_VIDEO_FRAME_MAP_FLAG_NO_REF));
    is_mapped_ = fits(info, buffer) && gst_video_frame_map(&frame_, &info, buffer, flags);
  }
  ~MappedPicture() {
    if (is_mapped_)
      gst_video_frame_unmap(&frame_);
  }
  MappedPicture(const MappedPicture &) = delete;
  MappedPicture &operator=(const MappedPicture &) = delete;

  /// False: the memory does not hold what the caps say.
  explicit operator bool() const { return is_mapped_; }
  const GstVideoFrame &frame() const { return frame_; }

private:
  // Mapping a picture whose own description contradicts the caps would be an error of this program.
  static bool fits(const GstVideoInfo &info, GstBuffer *buffer) {
    const GstVideoMeta *meta = gst_buffer_get_video_meta(buffer);
    return !meta || (meta->format == GST_VIDEO_INFO_FORMAT(&info) &&
                     meta->width >= static_cast<guint>(GST_VIDEO_INFO_WIDTH(&info)) &&
                     meta->height >= static_cast<guint>(GST_VIDEO_INFO_HEIGHT(&info)));
  }

  GstVideoFrame frame_{};
  bool is_mapped_ = false;
};

} // namespace haptic
