// SPDX-License-Identifier: LGPL-2.1-or-later
// Keeps the noise of a standing frame from being felt.
#pragma once

#include "motion-scale.hpp"

namespace haptic {

/// The speed below which a motion counts as none, and from which on it is left as it is; linear
/// between, so that the force does not chatter around standstill. px/s of the reference width.
inline constexpr double kStillSpeed = 3;
inline constexpr double kMovingSpeed = 6;

/// One thread; real-time safe.
class Deadband {
public:
  /// `dt` in s since the call before. A motion that turns round passes through zero without
  /// standing still: what counts is the fastest of the last moments (release 0.1 s).
  Motion step(Motion motion, double dt) noexcept;

private:
  double fastest_ = 0; // px/s
};

} // namespace haptic
