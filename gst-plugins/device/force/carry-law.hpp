// SPDX-License-Identifier: LGPL-2.1-or-later
// A spring and a damper from the hand to a held thing, which carry the hand along (a virtual
// coupling: Colgate, Stanley and Brown 1995). docs/force.md#carry gives the reasons.
#pragma once

#include "safety/safety-chain.hpp"
#include "samples/held-place.hpp"

#include <spidar/types.hpp>

namespace haptic {

/// What a held thing does to the hand (property `hold-law`).
enum class HoldLaw {
  motion, ///< its motion is felt
  carry,  ///< it carries the hand; what cannot carry is felt as motion
  both    ///< the sum
};

/// What the device can hold, and what the safety chain lets through.
struct CarryLimits {
  const spidar::DeviceLimits &device;
  double max_force = 1;      ///< N
  double slew_rate = 20;     ///< N/s, of the safety chain
  double longest_dt = 0.001; ///< s between two steps
  double energy = 0;         ///< J that the hand may have back, by the safety chain
};

/// One thread; real-time safe. SI units. In the plane of the frame.
class CarryLaw {
public:
  /// The fastest thing that carries, m/s; one that is twice as fast does not pull at all.
  static constexpr double kFastestThing = 0.1;

  /// `moved`: m, of the thing, and `dt` s, since the call before. The spring begins, without a
  /// force, where the hand is. It ends by becoming soft: what has pulled a hand is never moved.
  /// Nor does it pull to another thing: the spring to that one begins when this one has ended.
  void step(HoldState state, const spidar::Vector3 &moved, const spidar::Vector3 &hand,
            const CarryLimits &limits, double dt) noexcept HAPTIC_NONBLOCKING;
  void end() noexcept { ends_ = share_ > 0; } ///< another thing was taken
  /// Ends at once: the force is held, or the pose of the hand has jumped.
  void restart() noexcept { *this = {}; }
  /// Adds the spring to the chain's input, and takes the law from it as far as the thing carries.
  void apply(HoldLaw law, SafetyChain::Input &input) const noexcept;

  double stiffness() const noexcept { return stiffness_; } ///< N/m; 0 while nothing pulls
  double damping() const noexcept { return damping_; }     ///< N·s/m
  /// m, from the hand to where the thing would take it.
  const spidar::Vector3 &spring() const noexcept { return spring_; }

private:
  void ramp(HoldState state, double follows, double dt) noexcept;
  void set_stiffness(double stiffness, double most) noexcept;

  bool wants_ = false;                                  // it pulls, or is about to
  bool ends_ = false;                                   // to begin anew
  double share_ = 0;                                    // 0..1, of the whole stiffness
  double law_ = 1;                                      // 0..1, of the law beside it
  double stiffness_ = 0;                                // N/m
  double damping_ = 0;                                  // N·s/m
  TouchForce pull_;                                     // of the last step
  spidar::Vector3 spring_ = spidar::Vector3::Zero();    // m, from hand to end
  spidar::Vector3 lengthens_ = spidar::Vector3::Zero(); // m/s, low-passed
  spidar::Vector3 hand_ = spidar::Vector3::Zero();      // m, of the step before
};

} // namespace haptic
