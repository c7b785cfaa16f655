// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion of one frame, a sample or a field, with the time at which it is felt.
#pragma once

#include "motion/held-path.hpp"
#include "samples/motion-sample.hpp"
#include "share/field-pool.hpp"

#include <cstdint>
#include <limits>

namespace haptic {

/// The time of a motion that is felt as soon as it comes.
inline constexpr std::int64_t kAtOnce = std::numeric_limits<std::int64_t>::min();

struct TimedMotion {
  MotionSample sample;         ///< of a field only frame_of()
  bool measured = false;       ///< false: nothing could be measured in this frame
  std::int64_t time = kAtOnce; ///< ns, the middle of the sample's interval
  FieldPool::Field field = {}; ///< null: the same motion everywhere
  double stretch = 1;          ///< what velocities were multiplied by, per interval as it is now
  WayPoint way = {};           ///< of the held thing, at `time`; the interpolator's
  std::uint64_t order = 0;     ///< of the frames; the interpolator's
};

/// Multiplies the velocities, the spin and the divergence.
void scale_velocities(TimedMotion &motion, double factor) noexcept;

/// Sets the interval that the motion was measured over, ns.
void set_interval(TimedMotion &motion, std::uint64_t interval) noexcept;

/// Returns false for motions that no tracker can measure: the sample or field is damaged.
bool is_plausible(const TimedMotion &motion) noexcept;

/// Returns whether anything was measured: whether any confidence is above 0.
bool has_measurement(const TimedMotion &motion) noexcept;

} // namespace haptic
