// SPDX-License-Identifier: LGPL-2.1-or-later
// Single samples of a mapped frame, of 8 bits or more.
#pragma once

#include <cstdint>
#include <gst/video/video.h>

namespace test {

inline std::uint8_t *sample_of(const GstVideoFrame &frame, guint component, int x, int y) {
  return static_cast<std::uint8_t *>(GST_VIDEO_FRAME_COMP_DATA(&frame, component)) +
         static_cast<std::ptrdiff_t>(y) * GST_VIDEO_FRAME_COMP_STRIDE(&frame, component) +
         static_cast<std::ptrdiff_t>(x) * GST_VIDEO_FRAME_COMP_PSTRIDE(&frame, component);
}

/// Writes the value to the upper eight bits of a sample, and ones below them.
inline void set_sample(GstVideoFrame &frame, guint component, int x, int y, std::uint8_t value) {
  const GstVideoFormatInfo *format = frame.info.finfo;
  std::uint8_t *bytes = sample_of(frame, component, x, y);
  const guint more = GST_VIDEO_FORMAT_INFO_DEPTH(format, component) - 8;
  const guint shift = GST_VIDEO_FORMAT_INFO_SHIFT(format, component);
  const auto bits = static_cast<std::uint16_t>((((value + 1U) << more) - 1U) << shift);
  if (more == 0)
    *bytes = value;
  else if (GST_VIDEO_FORMAT_INFO_IS_LE(format))
    GST_WRITE_UINT16_LE(bytes, bits);
  else
    GST_WRITE_UINT16_BE(bytes, bits);
}

/// The upper eight bits of a sample.
inline int get_sample(const GstVideoFrame &frame, guint component, int x, int y) {
  const GstVideoFormatInfo *format = frame.info.finfo;
  const std::uint8_t *bytes = sample_of(frame, component, x, y);
  const guint more = GST_VIDEO_FORMAT_INFO_DEPTH(format, component) - 8;
  if (more == 0)
    return *bytes;
  const guint bits =
      GST_VIDEO_FORMAT_INFO_IS_LE(format) ? GST_READ_UINT16_LE(bytes) : GST_READ_UINT16_BE(bytes);
  return bits >> (GST_VIDEO_FORMAT_INFO_SHIFT(format, component) + more) & 255;
}

} // namespace test
