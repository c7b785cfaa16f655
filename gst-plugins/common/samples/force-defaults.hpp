// SPDX-License-Identifier: LGPL-2.1-or-later
// The facts of the force that two rooms need: the device room exerts the force, the track room
// writes it into files.
#pragma once

namespace haptic {

/// Size of the paper's frame (section 3.2.1), px. Velocities are scaled to this width.
inline constexpr double kReferenceWidth = 352;
inline constexpr double kReferenceHeight = 288;

/// Steepness of the force law (paper, equation 5), s/px in a frame kReferenceWidth wide.
inline constexpr double kDefaultAlpha = 0.01;

/// The highest `max-force`, N: the most that is offered to a hand, whatever the device could do.
inline constexpr double kHighestForce = 5;

/// The stiffest surface that a hand feels at the defaults of hapticsink, N/m (docs/force.md#touch).
inline constexpr double kStiffestTouch = 200;

/// Returns the share of a force that a confidence lets through: 0 up to 0.2, 1 from 0.5 on, linear
/// between. Real-time safe.
double confidence_gate(double confidence) noexcept;

/// Returns equation 5 of the paper divided by v: (2 maximum / pi) atan(alpha v) / v. Finite and
/// smooth also at v = 0. `v` in px/s, `alpha` in s/px. Real-time safe.
double arctan_gain(double v, double alpha, double maximum) noexcept;

} // namespace haptic
