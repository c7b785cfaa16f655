// From the metadata of picture after picture to the motion of each.
#pragma once

#include "gsthapticmotionmeta.h"
#include "motion-sample.hpp"
#include "velocity-estimate.hpp"

#include <gst/video/video.h>

namespace haptic {

/// Remembers the picture before: a duplicate repeats its motion. Not thread-safe.
class MotionReader {
public:
  /// Confidence 0: nothing was measured. `picture` gives size and pixel aspect.
  MotionSample read(const GstHapticMotionMeta &meta, const GstVideoInfo &picture,
                    Average average = Average::model, ModelChoice choice = ModelChoice::automatic);

  /// Of a picture without metadata.
  MotionSample read_nothing(const GstVideoInfo &picture);

private:
  MotionSample last_;
  ModelHistory history_;
};

} // namespace haptic
