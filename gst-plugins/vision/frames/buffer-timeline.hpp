// SPDX-License-Identifier: LGPL-2.1-or-later
// The time line of the frames of a stream, from the time stamps and flags of their buffers.
#pragma once

#include "frames/frame-timeline.hpp"

#include <gst/base/gstbasetransform.h>
#include <optional>
#include <utility>

namespace haptic {

/// Streaming thread only.
class BufferTimeline {
public:
  /// Returns how the frame in the buffer follows on the reference. Logs the first faulty time
  /// stamp.
  TimeStep advance(GstBaseTransform *element, GstDebugCategory *category, const GstBuffer *buffer) {
    // Backwards, each group of frames is decoded for itself and begins with a discontinuity.
    const bool descending = element->segment.rate < 0;
    if (GST_BUFFER_IS_DISCONT(buffer) && !descending)
      timeline_.forget();
    std::optional<std::uint64_t> pts;
    if (GST_BUFFER_PTS_IS_VALID(buffer))
      pts = GST_BUFFER_PTS(buffer);
    const TimeStep step = timeline_.advance(pts, descending);
    if (step.fault && !std::exchange(reported_, true))
      GST_CAT_WARNING_OBJECT(category, element,
                             "%s (at %" GST_TIME_FORMAT "): no motion is measured across it. "
                             "Further ones are not reported",
                             step.fault, GST_TIME_ARGS(GST_BUFFER_PTS(buffer)));
    return step;
  }
  /// The frame given last becomes the reference.
  void adopt() { timeline_.adopt(); }
  /// The next frame restarts.
  void forget() { timeline_.forget(); }
  /// The next fault is logged again.
  void report_faults_again() { reported_ = false; }

private:
  FrameTimeline timeline_;
  bool reported_ = false;
};

} // namespace haptic
