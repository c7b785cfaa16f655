// SPDX-License-Identifier: LGPL-2.1-or-later
// Single samples of a mapped frame, of 8 bits or more.
#pragma once

#include <cstdint>
#include <cstring>
#include <gst/video/video.h>

namespace test {

inline std::uint8_t *sample_of(const GstVideoFrame &frame, guint component, int x, int y) {
  return static_cast<std::uint8_t *>(GST_VIDEO_FRAME_COMP_DATA(&frame, component)) +
         static_cast<std::ptrdiff_t>(y) * GST_VIDEO_FRAME_COMP_STRIDE(&frame, component) +
         static_cast<std::ptrdiff_t>(x) * GST_VIDEO_FRAME_COMP_PSTRIDE(&frame, component);
}

/// GStreamer 1.22 describes Y210 otherwise than it converts it: as big-endian, and not shifted.
inline bool is_little_endian(const GstVideoFormatInfo *format) {
  return GST_VIDEO_FORMAT_INFO_FORMAT(format) == GST_VIDEO_FORMAT_Y210 ||
         GST_VIDEO_FORMAT_INFO_IS_LE(format);
}

inline guint shift_of(const GstVideoFormatInfo *format, guint component) {
  return GST_VIDEO_FORMAT_INFO_FORMAT(format) == GST_VIDEO_FORMAT_Y210
             ? 6
             : GST_VIDEO_FORMAT_INFO_SHIFT(format, component);
}

/// v210 holds its samples in words: the luma at x is one of three in the word at this place.
struct WordSample {
  std::uint8_t *word;
  guint shift;
};

inline WordSample v210_luma(const GstVideoFrame &frame, int x, int y) {
  constexpr int kWord[] = {0, 1, 1, 2, 3, 3};
  constexpr guint kShift[] = {10, 0, 20, 10, 0, 20};
  return {static_cast<std::uint8_t *>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0)) +
              static_cast<std::ptrdiff_t>(y) * GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0) +
              x / 6 * 16 + kWord[x % 6] * 4,
          kShift[x % 6]};
}

/// Writes the value to the upper eight bits of a sample, and ones below them.
inline void set_sample(GstVideoFrame &frame, guint component, int x, int y, std::uint8_t value) {
  const GstVideoFormatInfo *format = frame.info.finfo;
  if (GST_VIDEO_FORMAT_INFO_FORMAT(format) == GST_VIDEO_FORMAT_v210) {
    const WordSample sample = v210_luma(frame, x, y);
    const guint32 others = GST_READ_UINT32_LE(sample.word) & ~(1023U << sample.shift);
    const guint32 word = GUINT32_TO_LE(others | ((4U * value + 3U) << sample.shift));
    std::memcpy(sample.word, &word, sizeof word);
    return;
  }
  std::uint8_t *bytes = sample_of(frame, component, x, y);
  const guint more = GST_VIDEO_FORMAT_INFO_DEPTH(format, component) - 8;
  const guint shift = shift_of(format, component);
  const auto bits = static_cast<std::uint16_t>((((value + 1U) << more) - 1U) << shift);
  if (more == 0) {
    *bytes = value;
    return;
  }
  const guint16 word = is_little_endian(format) ? GUINT16_TO_LE(bits) : GUINT16_TO_BE(bits);
  std::memcpy(bytes, &word, sizeof word);
}

/// The upper eight bits of a sample.
inline int get_sample(const GstVideoFrame &frame, guint component, int x, int y) {
  const GstVideoFormatInfo *format = frame.info.finfo;
  if (GST_VIDEO_FORMAT_INFO_FORMAT(format) == GST_VIDEO_FORMAT_v210) {
    const WordSample sample = v210_luma(frame, x, y);
    return GST_READ_UINT32_LE(sample.word) >> (sample.shift + 2) & 255;
  }
  const std::uint8_t *bytes = sample_of(frame, component, x, y);
  const guint more = GST_VIDEO_FORMAT_INFO_DEPTH(format, component) - 8;
  if (more == 0)
    return *bytes;
  const guint bits =
      is_little_endian(format) ? GST_READ_UINT16_LE(bytes) : GST_READ_UINT16_BE(bytes);
  return bits >> (shift_of(format, component) + more) & 255;
}

} // namespace test
