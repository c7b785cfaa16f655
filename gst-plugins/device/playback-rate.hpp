// SPDX-License-Identifier: LGPL-2.1-or-later
// Time deformation: what a film played slower, faster or backwards feels like.
#pragma once

#include "motion-field.hpp"

#include <optional>

namespace haptic {

enum class RateLaw {
  as_seen,   ///< slow motion feels softer, fast motion stronger
  as_filmed, ///< as at the film's own pace
};

/// How the film is played.
struct Playback {
  double rate = 1;         ///< that remains to be applied to its time stamps (GstSegment::rate)
  double applied_rate = 1; ///< that its time stamps already hold (GstSegment::applied_rate)
  bool skips = false;      ///< frames are left out (trick modes)
};

/// The sample in the time of its presentation: interval and motion as they are lived through, or
/// the motion as filmed. Samples come in the order of presentation, so that a film played backwards
/// brings its motions turned round already. Nothing where frames are too far apart for a motion
/// to mean something: beyond twice the film's pace, or when frames are left out.
std::optional<MotionSample> play(MotionSample sample, const Playback &playback,
                                 RateLaw law) noexcept;

/// The same for a field, in place; false where that gives nothing for a sample.
bool play(MotionField &field, const Playback &playback, RateLaw law) noexcept;

} // namespace haptic
