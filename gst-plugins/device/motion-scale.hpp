// From pixels of one picture to motion that means the same for every picture.
#pragma once

#include "motion-sample.hpp"

namespace haptic {

/// Motion as a force law sees it: square pixels of a picture that is `reference-width` wide, x to
/// the right and y down, freed from the tracker's noise around standstill.
struct Motion {
  double velocity_x = 0; ///< px/s
  double velocity_y = 0; ///< px/s
};

/// The speed below which a motion counts as none, and from which on it is left as it is; linear
/// between, so that the force does not chatter around standstill. px/s of the reference width.
inline constexpr double kStillSpeed = 3;
inline constexpr double kMovingSpeed = 6;

/// `reference_width` in px; 0 keeps the pixels of the picture itself. Real-time safe.
Motion scale_motion(const MotionSample &sample, double reference_width) noexcept;

/// False for speeds that no tracker can measure: faster than 1e6 px/s, an 8K picture's width
/// in a hundredth of a second. Such a sample is damaged.
bool is_plausible(const MotionSample &sample) noexcept;

} // namespace haptic
