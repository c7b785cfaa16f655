// SPDX-License-Identifier: LGPL-2.1-or-later
// Makes buffers of a haptic track.
#pragma once

#include "glue/gst-raii.hpp"

#include <cstdint>
#include <span>

namespace haptic {

/// Returns a buffer with a copy of the bytes.
inline BufferPtr make_buffer(std::span<const std::uint8_t> bytes, GstClockTime pts,
                             GstClockTime duration) {
  BufferPtr buffer(gst_buffer_new_allocate(nullptr, bytes.size(), nullptr));
  gst_buffer_fill(buffer.get(), 0, bytes.data(), bytes.size());
  GST_BUFFER_PTS(buffer.get()) = pts;
  GST_BUFFER_DURATION(buffer.get()) = duration;
  return buffer;
}

} // namespace haptic
