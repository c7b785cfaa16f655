// SPDX-License-Identifier: LGPL-2.1-or-later
// The measurement as metadata that elements of other projects read: GstAnalytics, where GStreamer
// has it (1.24 and later).
#pragma once

#include "gsthapticmotionmeta.h"

namespace haptic {

/// Keeps when the held thing was taken and last seen. Not thread-safe.
class AnalyticsWriter {
public:
  /// Adds the region and the held thing (docs/formats/motion-meta.md). The buffer must be writable.
  void attach(GstBuffer *buffer, const GstHapticMotionMeta &motion);

private:
  bool is_taken(GstClockTime now, const GstHapticMotionMeta &motion);

  GstClockTime taken_ = GST_CLOCK_TIME_NONE;
  GstClockTime last_seen_ = 0;
  GstClockTime held_time_ = 0; // of the frame before
};

} // namespace haptic
