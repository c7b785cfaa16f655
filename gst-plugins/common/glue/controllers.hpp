// SPDX-License-Identifier: LGPL-2.1-or-later
// Properties that a GstController changes along the stream.
#pragma once

#include <gst/gst.h>

namespace haptic {

/// Sets the controlled properties to their values at the stream time of the buffer. Call it in the
/// streaming thread, without a lock: it notifies handlers.
inline void sync_controllers(gpointer element, const GstSegment &segment, GstBuffer *buffer) {
  if (segment.format != GST_FORMAT_TIME || !GST_BUFFER_PTS_IS_VALID(buffer))
    return;
  const GstClockTime time =
      gst_segment_to_stream_time(&segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  if (GST_CLOCK_TIME_IS_VALID(time))
    gst_object_sync_values(GST_OBJECT(element), time);
}

} // namespace haptic
