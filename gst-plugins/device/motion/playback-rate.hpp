// SPDX-License-Identifier: LGPL-2.1-or-later
// Time deformation: the motion of a film that is played slower, faster or backwards.
#pragma once

#include "motion/timed-motion.hpp"

namespace haptic {

enum class RateLaw {
  as_seen,   ///< slow motion feels softer, fast motion stronger
  as_filmed, ///< as at the film's own pace
};

/// How the film is played.
struct Playback {
  double rate = 1;         ///< still to be applied to the time stamps (GstSegment::rate)
  double applied_rate = 1; ///< already applied to them (GstSegment::applied_rate)
  bool skips = false;      ///< frames are left out (trick modes)
};

/// Converts the motion into the time of its presentation: the interval as it lasts, the velocities
/// as they are seen or as they were filmed. Frames come in the order of presentation, so that a
/// film played backwards brings its motions turned round already. Returns false, and leaves the
/// motion as it is, where frames are too far apart for a motion to be felt: beyond twice the film's
/// pace, or when frames are left out.
bool apply_playback(TimedMotion &motion, const Playback &playback, RateLaw law) noexcept;

} // namespace haptic
