// SPDX-License-Identifier: LGPL-2.1-or-later
// Turns the metadata of the frames of a stream into one motion per frame.
#pragma once

#include "gsthapticmotionmeta.h"
#include "samples/motion-sample.hpp"
#include "velocity/velocity-estimate.hpp"

#include <gst/video/video.h>

namespace haptic {

/// Keeps the motion of the frame before, which a duplicate repeats. Not thread-safe.
class MotionReader {
public:
  /// Returns the motion of a frame; confidence 0: nothing was measured. `frame` has its size and
  /// pixel aspect.
  MotionSample read(const GstHapticMotionMeta &meta, const GstVideoInfo &frame,
                    Average average = kUsualAverage, ModelChoice choice = ModelChoice::automatic);

  /// Returns the sample of a frame without metadata.
  MotionSample read_nothing(const GstVideoInfo &frame);

private:
  MotionSample last_;
  ModelHistory history_;
};

/// Adds the fields of the structure haptic-motion (docs/formats/motion-meta.md).
void set_motion(GstStructure *to, const MotionSample &sample);

} // namespace haptic
