// Owning pointers and scoped locks for GStreamer's C types.
#pragma once

#include <gst/gst.h>
#include <memory>

namespace haptic {

template <auto Release>
struct Releaser {
  template <typename T>
  void operator()(T *object) const noexcept {
    Release(object);
  }
};

using BufferPtr = std::unique_ptr<GstBuffer, Releaser<gst_buffer_unref>>;
using CapsPtr = std::unique_ptr<GstCaps, Releaser<gst_caps_unref>>;
using EventPtr = std::unique_ptr<GstEvent, Releaser<gst_event_unref>>;
using QueryPtr = std::unique_ptr<GstQuery, Releaser<gst_query_unref>>;
using StructurePtr = std::unique_ptr<GstStructure, Releaser<gst_structure_free>>;
using GCharPtr = std::unique_ptr<gchar, Releaser<g_free>>;

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

} // namespace haptic
