// SPDX-License-Identifier: LGPL-2.1-or-later
// Owning pointers, scoped mappings and locks for GStreamer's C types.
#pragma once

#include <cstdint>
#include <gst/gst.h>
#include <memory>
#include <span>

namespace haptic {

// Overloads rather than a template over the release function: GStreamer's are static inline, and a
// type made of such a function would have internal linkage.
struct Releaser {
  void operator()(GstBuffer *buffer) const noexcept { gst_buffer_unref(buffer); }
  void operator()(GstCaps *caps) const noexcept { gst_caps_unref(caps); }
  void operator()(GstElement *element) const noexcept { gst_object_unref(element); }
  void operator()(GstPad *pad) const noexcept { gst_object_unref(pad); }
  void operator()(GstBus *bus) const noexcept { gst_object_unref(bus); }
  void operator()(GstEvent *event) const noexcept { gst_event_unref(event); }
  void operator()(GstMessage *message) const noexcept { gst_message_unref(message); }
  void operator()(GstQuery *query) const noexcept { gst_query_unref(query); }
  void operator()(GstSample *sample) const noexcept { gst_sample_unref(sample); }
  void operator()(GstStructure *structure) const noexcept { gst_structure_free(structure); }
  void operator()(GError *error) const noexcept { g_error_free(error); }
  void operator()(gchar *text) const noexcept { g_free(text); }
};

using BufferPtr = std::unique_ptr<GstBuffer, Releaser>;
using CapsPtr = std::unique_ptr<GstCaps, Releaser>;
using ElementPtr = std::unique_ptr<GstElement, Releaser>;
using PadPtr = std::unique_ptr<GstPad, Releaser>;
using BusPtr = std::unique_ptr<GstBus, Releaser>;
using EventPtr = std::unique_ptr<GstEvent, Releaser>;
using MessagePtr = std::unique_ptr<GstMessage, Releaser>;
using QueryPtr = std::unique_ptr<GstQuery, Releaser>;
using SamplePtr = std::unique_ptr<GstSample, Releaser>;
using StructurePtr = std::unique_ptr<GstStructure, Releaser>;
using ErrorPtr = std::unique_ptr<GError, Releaser>;
using GCharPtr = std::unique_ptr<gchar, Releaser>;

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

/// Holds a GstObject's lock for a scope. Never call into another element while it is held.
class ObjectLock {
public:
  explicit ObjectLock(gpointer object) noexcept : object_(GST_OBJECT_CAST(object)) {
    GST_OBJECT_LOCK(object_);
  }
  ~ObjectLock() { GST_OBJECT_UNLOCK(object_); }
  ObjectLock(const ObjectLock &) = delete;
  ObjectLock &operator=(const ObjectLock &) = delete;

private:
  GstObject *object_;
};

/// Returns what is read under the lock of the object.
template <typename Value>
Value locked_copy(gpointer object, const Value &value) {
  const ObjectLock lock(object);
  return value;
}

} // namespace haptic
