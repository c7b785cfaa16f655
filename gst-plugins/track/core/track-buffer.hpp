// SPDX-License-Identifier: LGPL-2.1-or-later
// Buffers of a haptic track: their bytes in and out.
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

/// The bytes of a buffer, mapped for reading for a scope.
class ReadableBuffer {
public:
  explicit ReadableBuffer(GstBuffer *buffer) noexcept
      : buffer_(gst_buffer_map(buffer, &map_, GST_MAP_READ) ? buffer : nullptr) {}
  ~ReadableBuffer() {
    if (buffer_)
      gst_buffer_unmap(buffer_, &map_);
  }
  ReadableBuffer(const ReadableBuffer &) = delete;
  ReadableBuffer &operator=(const ReadableBuffer &) = delete;

  explicit operator bool() const noexcept { return buffer_ != nullptr; }
  std::span<const std::uint8_t> bytes() const noexcept { return {map_.data, map_.size}; }

private:
  GstMapInfo map_ = GST_MAP_INFO_INIT;
  GstBuffer *buffer_;
};

} // namespace haptic
