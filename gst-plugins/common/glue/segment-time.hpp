// SPDX-License-Identifier: LGPL-2.1-or-later
// Times of a segment, which may count in something else than time.
#pragma once

#include <gst/gst.h>

namespace haptic {

/// Running time of a time stamp; GST_CLOCK_TIME_NONE outside the segment, or if the segment does
/// not count in time. GStreamer's own function complains of such a segment.
inline GstClockTime running_time_of(const GstSegment &segment, GstClockTime pts) {
  return segment.format == GST_FORMAT_TIME
             ? gst_segment_to_running_time(&segment, GST_FORMAT_TIME, pts)
             : GST_CLOCK_TIME_NONE;
}

/// Stream time, likewise.
inline GstClockTime stream_time_of(const GstSegment &segment, GstClockTime pts) {
  return segment.format == GST_FORMAT_TIME
             ? gst_segment_to_stream_time(&segment, GST_FORMAT_TIME, pts)
             : GST_CLOCK_TIME_NONE;
}

} // namespace haptic
