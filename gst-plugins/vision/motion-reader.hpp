// SPDX-License-Identifier: LGPL-2.1-or-later
// From the metadata of frame after frame to the motion of each.
#pragma once

#include "gsthapticmotionmeta.h"
#include "motion-sample.hpp"
#include "velocity-estimate.hpp"

#include <gst/video/video.h>

namespace haptic {

/// Remembers the frame before: a duplicate repeats its motion. Not thread-safe.
class MotionReader {
public:
  /// Confidence 0: nothing was measured. `frame` gives size and pixel aspect.
  MotionSample read(const GstHapticMotionMeta &meta, const GstVideoInfo &frame,
                    Average average = Average::model, ModelChoice choice = ModelChoice::automatic);

  /// Of a frame without metadata.
  MotionSample read_nothing(const GstVideoInfo &frame);

private:
  MotionSample last_;
  ModelHistory history_;
};

} // namespace haptic
