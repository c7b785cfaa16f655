// SPDX-License-Identifier: LGPL-2.1-or-later
// The lock of a pad under which frames, serialised events and queries pass.
#pragma once

#include <gst/base/gstbasetransform.h>

namespace haptic {

/// Holds this lock of an element's sink pad for a scope: of its stop(). GStreamer stops an element
/// after its pad has become flushing, but the end of a flush that another thread sends meanwhile
/// lets buffers and queries in again.
class StreamLock {
public:
  explicit StreamLock(gpointer trans) noexcept
      : pad_(GST_BASE_TRANSFORM_SINK_PAD(GST_BASE_TRANSFORM_CAST(trans))) {
    GST_PAD_STREAM_LOCK(pad_);
  }
  ~StreamLock() { GST_PAD_STREAM_UNLOCK(pad_); }
  StreamLock(const StreamLock &) = delete;
  StreamLock &operator=(const StreamLock &) = delete;

private:
  GstPad *pad_;
};

} // namespace haptic
