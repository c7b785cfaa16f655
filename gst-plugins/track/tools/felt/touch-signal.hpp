// SPDX-License-Identifier: LGPL-2.1-or-later
// The force of touching reliefs, as far as a track alone says it: a spring along the normal,
// without the friction, damping and limits of hapticsink, which follow from how the hand came
// there.
#pragma once

#include "felt/force-log.hpp"
#include "felt/perception.hpp"
#include "samples/relief-field.hpp"

#include <span>

namespace haptic {

/// A hand at rest is so far beneath the mean of the two surfaces that are compared, m: 0.2 N at
/// kStiffestTouch.
inline constexpr double kTouchDepth = 0.001;

/// The surface above one place at one time.
struct FeltSurface {
  double time = 0;     ///< s
  bool exists = false; ///< false: no surface, and the rest is 0
  bool begins = false; ///< another scene: no line leads here from the surface before
  float height = 0;    ///< m
  float stiffness = 0; ///< N/m
  float slope_x = 0;   ///< rise to the right
  float slope_y = 0;   ///< rise upwards
};

/// `x`, `y`: 0..1, shares of the frame from its top left; `time` in ns. The frame is a workspace of
/// kWorkspaceHalf, and there is no surface above it.
FeltSurface felt_surface(const ReliefField &relief, double x, double y, std::uint64_t time);

/// Returns the surface on the straight line from `a` to `b`. Where only one exists, the nearer one
/// counts.
FeltSurface interpolated(const FeltSurface &a, const FeltSurface &b, double share) noexcept;

/// Returns the force on a hand at height `z` (m): its depth along the normal times the stiffness,
/// at most kStiffestTouch; at most `max_force` (N).
Force contact_force(const FeltSurface &surface, double z, double max_force) noexcept;

/// Returns the height above its mean, as a force of kStiffestTouch: what a shift is known by.
ForceSignal height_signal(std::span<const FeltSurface> surfaces);

/// Returns the forces on one hand that touches both surfaces at a place, of which B is later by
/// `shift` s. It follows their mean, kTouchDepth beneath; where one is missing, the other one.
SignalPair touch_signals(std::span<const FeltSurface> a, std::span<const FeltSurface> b,
                         double max_force, double shift);

} // namespace haptic
