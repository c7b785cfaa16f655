// SPDX-License-Identifier: LGPL-2.1-or-later
// Force laws: from a motion to a force. Limits, smoothing and silence come after them
// (safety-chain.hpp of libspidar), so that no law can be unsafe.
#pragma once

#include "motion/motion-conditioning.hpp"
#include "samples/force-defaults.hpp"

#include <limits>
#include <memory>
#include <span>
#include <spidar/limited-device.hpp>
#include <spidar/types.hpp>

namespace haptic {

/// Properties of the element that shape the laws.
struct LawSettings {
  double max_force = spidar::ForceLimits().force;   ///< N
  double alpha = kDefaultAlpha;                     ///< s/px
  double gain_window = 10;                          ///< s, of the linear law
  double max_torque = spidar::ForceLimits().torque; ///< N·m
  double spin_half = 1;                             ///< rad/s that give half of max_torque
  double max_push = 0;                              ///< N along z
  /// N by which the motion of the hand may change the force of a law that knows it
  double most_for_hand = std::numeric_limits<double>::infinity();
};

/// Of what may follow the speed of a hand (DeviceLimits::most_resistance): for the damper of a
/// surface or of a held thing. Laws have the rest.
constexpr double kShareOfDampers = 0.75;

/// What a law computes, in the plane of the frame: x to the right, y down.
struct PlanarForce {
  double x = 0; ///< N
  double y = 0; ///< N
};

/// Knows no device, and of the time only the step. Used by one thread; real-time safe.
class ForceLaw {
public:
  virtual ~ForceLaw() = default;

  /// Returns force and torque on the grip: x to the right, y up, z towards the user. It is the
  /// law's force, and what all laws share: rotation as torque about z, approach as a push along z.
  /// `dt` in s since the call before; 0 while there is no motion to follow.
  spidar::Wrench wrench(const Motion &motion, const PlanarVelocity &hand,
                        const LawSettings &settings, double dt) noexcept;
  /// The law begins to follow a motion, also after a pause or a gap: what changed before is none.
  virtual void restart() noexcept {}
  /// N, of that force: what the motion of the hand has changed in it.
  const spidar::Vector3 &of_hand() const noexcept { return of_hand_; }

protected:
  /// What force() returns, and the part of it that the motion of the hand has changed.
  struct Relative {
    PlanarForce force;
    PlanarForce of_hand;
  };

private:
  /// `hand` is in the unit of Motion::velocity.
  virtual Relative force(const Motion &motion, const PlanarVelocity &hand,
                         const LawSettings &settings, double dt) noexcept = 0;

  spidar::Vector3 of_hand_ = spidar::Vector3::Zero();
};

struct ForceLawInfo {
  const char *name;        ///< value of the property `force-law`
  const char *description; ///< for gst-inspect-1.0
  std::unique_ptr<ForceLaw> (*make)();
};

/// Returns all laws; the first is the default.
std::span<const ForceLawInfo> force_laws() noexcept;

} // namespace haptic
