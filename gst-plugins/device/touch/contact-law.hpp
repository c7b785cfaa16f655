// SPDX-License-Identifier: LGPL-2.1-or-later
// From a surface and a hand to the force of touching it: a god-object proxy with Coulomb friction
// (Zilles and Salisbury 1995; friction cone of Harwin and Melder 2002) on a surface that moves.
// docs/force.md#touch gives the reasons.
#pragma once

#include "share/non-blocking.hpp"
#include "touch/relief-surface.hpp"

#include <spidar/types.hpp>

namespace haptic {

/// What the device can hold.
struct ContactLimits {
  double slew_rate = 20; ///< N/s, of the safety chain
  double max_force = 1;  ///< N
  double rate = 1000;    ///< Hz, of the loop
};

/// The stiffest surface, N/m: at the fastest hand that is not braked, the slew rate still follows
/// the spring, and a light hand is stable. Stiffer reliefs are felt with this stiffness.
double stiffest(const ContactLimits &limits) noexcept;

struct Contact {
  bool touches = false;
  spidar::Vector3 proxy = spidar::Vector3::Zero(); ///< m, on the surface; the hand, if free
  spidar::Vector3 force = spidar::Vector3::Zero(); ///< N, on the hand
};

/// One thread; real-time safe. SI units.
class ContactLaw {
public:
  /// The fastest that a surface moves under a hand that touches it, m/s. A film may jump.
  static constexpr double kFastestSurface = 0.1;

  /// `dt` in s since the call before, > 0.
  const Contact &step(const ReliefSurface &surface, const spidar::Vector3 &hand,
                      const spidar::Vector3 &velocity, const ContactLimits &limits,
                      double dt) noexcept HAPTIC_NONBLOCKING;
  const Contact &contact() const noexcept { return contact_; }
  /// There is no surface, or another one. A hand that is found beneath the next one is lifted out
  /// of it slowly.
  void restart() noexcept;

private:
  bool touch(const ReliefSurface &surface, const spidar::Vector3 &hand) noexcept;
  void move_with_surface(const ReliefSurface &surface, const spidar::Vector3 &hand,
                         double most_stiffness, double dt) noexcept;
  void slide(const ReliefSurface &surface, const spidar::Vector3 &hand,
             double most_stiffness) noexcept;
  bool hangs(const ReliefSurface &surface, const spidar::Vector3 &hand) const noexcept;
  spidar::Vector3 wanted(const spidar::Vector3 &hand, const spidar::Vector3 &velocity,
                         const spidar::Vector3 &moved, const ContactLimits &limits) noexcept;
  void exert(const spidar::Vector3 &wanted, const ContactLimits &limits, double dt) noexcept;
  double felt_height(const SurfacePoint &point) const noexcept { return point.height + lag_; }

  Contact contact_;
  double stiffness_ = 0; // N/m, felt in the step before
  double lag_ = 0;       // m, of the surface that is felt above the film's; 0 while free
  double energy_ = 0;    // J that the hand and the surface have put into the spring
  spidar::Vector3 acting_ = spidar::Vector3::Zero();      // N, since the step before
  bool hand_known_ = false;                               // the hand of the step before was free
  spidar::Vector3 hand_before_ = spidar::Vector3::Zero(); // m
};

} // namespace haptic
