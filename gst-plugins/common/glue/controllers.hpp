// SPDX-License-Identifier: LGPL-2.1-or-later
// Properties that a GstController changes along the stream.
#pragma once

#include "glue/segment-time.hpp"

#include <gst/gst.h>

namespace haptic {

/// Sets the controlled properties to their values at the stream time of the buffer. Call it in the
/// streaming thread, without a lock: it notifies handlers.
inline void sync_controllers(gpointer element, const GstSegment &segment, GstBuffer *buffer) {
  const GstClockTime time = stream_time_of(segment, GST_BUFFER_PTS(buffer));
  if (GST_CLOCK_TIME_IS_VALID(time))
    gst_object_sync_values(GST_OBJECT(element), time);
}

} // namespace haptic
