// SPDX-License-Identifier: LGPL-2.1-or-later
// What a haptic device can do, and what it can hold without shaking. SI units.
#pragma once

#include <algorithm>
#include <limits>
#include <numbers>

namespace spidar {

/// A device leaves what it does not know as it is here: nothing follows the hand then, neither a
/// stiffness nor a damping, because neither is safe on an unknown device. It is what holds without
/// a device, too.
struct DeviceLimits {
  // What it can do.

  double force = std::numeric_limits<double>::infinity();  ///< N, the strongest
  double torque = std::numeric_limits<double>::infinity(); ///< N·m, the strongest; 0: it has none
  double rate = std::numeric_limits<double>::infinity();   ///< Hz, of the fastest exchanges
  int degrees_of_freedom = 6;  ///< that it exerts: from 3 on a push in z, 6: a torque, too
  double metres_per_count = 0; ///< m, the coarsest step of a measured place
  double flicker_way = 0;      ///< m, by which the last count moves the place of a hand at rest

  // What it can hold. Everything that follows the hand acts late; a spring is stable that is not
  // stiffer than the damping of the grip divided by this delay.

  double stiffness = 0;        ///< N/m, the stiffest; 0: none, the strength of its force is unknown
  double physical_damping = 0; ///< N·s/m, of the lightest grip, that no software makes
  double damping = 0; ///< N·s/m, that a force may have which follows the speed of the hand
  double mass = 0;    ///< kg, the smallest at the grip
  double delay = 2.5; ///< periods of the loop, from a place to the middle of what answers it
  /// W for each newton of the highest force that is set: what a spring may give to a hand at rest,
  /// because the last count of its place flickers
  double flicker = 0;
  /// Hz, of the low-pass of the speed that a force follows; a count a tick would be felt.
  static constexpr double kSpeedCutoff = 35;

  // Of a grip that nobody holds.

  bool grip_is_free = false; ///< it can move freely; a stick on a joint cannot
  double let_go_speed = 1;   ///< m/s; no hand that is in control of the grip is faster
  double let_go_turn = 3;    ///< rad/s, while the torque drives the turn
  double whirl = 10;         ///< rad/s, whatever drives it
  double calm_turn = 1;      ///< rad/s; what turns faster is braked
  double turn_brake = 0;     ///< N·m·s, of this brake
  double side_torque = 0;    ///< N·m, which may come without a force: what turns no free grip up

  /// N·m; 0 for a device that only moves.
  double strongest_torque() const noexcept { return degrees_of_freedom < 6 ? 0 : torque; }
  /// N, in z; 0 for a device of the plane.
  double strongest_push() const noexcept { return degrees_of_freedom < 3 ? 0 : force; }
  /// Whether a commanded force is one in newtons.
  bool knows_newtons() const noexcept { return stiffness > 0; }
  /// N/m at ticks of `period` s, of a spring that a free grip bears: k T < b.
  double stiffest_spring(double period) const noexcept {
    return std::min(stiffness, physical_damping / (delay * period));
  }
  /// N·s/m at ticks of `period` s: the most by which a force may follow the hand's speed. It is a
  /// damper behind the delay of device, hold and low-pass; more of it pumps a light grip up, also
  /// over a still frame, or makes the flicker of a count felt.
  double most_resistance(double period) const noexcept {
    constexpr double kOfMass = 10;     // periods, in which such a damper would stop the grip
    constexpr double kFlicker = 0.016; // N
    const double of_counts = kFlicker / (2 * std::numbers::pi * kSpeedCutoff * metres_per_count);
    return std::min({damping, mass / kOfMass / period, of_counts});
  }
  /// J per N of the highest force that is set: what a hand may have back at most. At the strongest
  /// force, the lightest grip that is let go with it reaches 0.8 of the speed that lets go.
  double most_for_hand() const noexcept {
    constexpr double kOfSquare = 0.32; // 0.8² / 2
    return kOfSquare * mass * let_go_speed * let_go_speed / force;
  }
};

} // namespace spidar
