// SPDX-License-Identifier: LGPL-2.1-or-later
// From a surface and a hand to the force of touching it: a god-object proxy with Coulomb friction
// (Zilles and Salisbury 1995; friction cone of Harwin and Melder 2002) on a surface that moves.
// docs/force.md#touch gives the reasons.
#pragma once

#include "non-blocking.hpp"
#include "touch/relief-surface.hpp"

#include <limits>
#include <spidar/device-limits.hpp>
#include <spidar/types.hpp>

namespace haptic {

/// What the device can hold, and what the safety chain lets through.
struct ContactLimits {
  const spidar::DeviceLimits &device;
  double slew_rate = 20;     ///< N/s, of the safety chain
  double longest_dt = 0.001; ///< s between two steps
  /// J that the hand has put into the touch: what acted on it in truth, by the safety chain
  double energy = std::numeric_limits<double>::infinity();
};

/// The stiffest surface, N/m: at the fastest hand that is not braked, the slew rate still follows
/// the spring, and a light hand is stable. Stiffer reliefs are felt with this stiffness.
double stiffest(const ContactLimits &limits) noexcept;

struct Contact {
  bool touches = false;
  spidar::Vector3 proxy = spidar::Vector3::Zero(); ///< m, on the surface; the hand, if free
  spidar::Vector3 force = spidar::Vector3::Zero(); ///< N, on the hand
  double surface_work = 0; ///< J, that its own movement put into the spring since the step before
  double energy = 0;       ///< J, of the spring
  double released = 0;     ///< N, of the spring, by the hand\'s own way out since the step before
};

/// One thread; real-time safe. SI units.
class ContactLaw {
public:
  /// The fastest that a surface moves under a hand that touches it, m/s. A film may jump.
  static constexpr double kFastestSurface = 0.1;

  /// `dt` in s since the call before, > 0.
  const Contact &step(const ReliefSurface &surface, const spidar::Vector3 &hand,
                      const ContactLimits &limits, double dt) noexcept HAPTIC_NONBLOCKING;
  const Contact &contact() const noexcept { return contact_; }
  /// N·s/m, of the hand against the surface; 0 while free.
  double damping() const noexcept { return contact_.touches ? damping_ : 0; }
  /// There is no surface, or another one. A hand that is found beneath the next one is lifted out
  /// of it slowly, at the film's cost.
  void restart() noexcept;
  /// What is felt is held: a surface that was touched begins anew at the hand, and stays there
  /// until the hand has come out of the film's.
  void hold() noexcept;
  /// The same for any surface: the pose of the hand has jumped.
  void sink() noexcept;

private:
  bool touch(const ReliefSurface &surface, const spidar::Vector3 &hand) noexcept;
  void move_with_surface(const ReliefSurface &surface, const spidar::Vector3 &hand,
                         double most_stiffness, double dt) noexcept;
  void slide(const ReliefSurface &surface, const spidar::Vector3 &hand,
             double most_stiffness) noexcept;
  void set_damping(double whole_stiffness, const ContactLimits &limits) noexcept;
  bool hangs(const ReliefSurface &surface, const spidar::Vector3 &hand) const noexcept;
  void shorten_to(double energy, const ReliefSurface &surface,
                  const spidar::Vector3 &hand) noexcept;
  void follow_length(const spidar::Vector3 &change, double dt) noexcept;
  spidar::Vector3 force(const ReliefSurface &surface, const spidar::Vector3 &spring) const noexcept;
  double felt_height(const SurfacePoint &point) const noexcept {
    return point.height + lag_ + sunk_;
  }

  Contact contact_;
  double stiffness_ = 0; // N/m, felt in the step before
  double damping_ = 0;   // N·s/m
  double lag_ = 0;       // m, of the surface that is felt above the film's; 0 while free
  double sunk_ = 0;      // m, the same, for good: what is not the film's to lift
  bool sinks_ = false;   // the next touch begins with sunk_ instead of lag_
  spidar::Vector3 spring_ = spidar::Vector3::Zero();      // m, from hand to proxy
  spidar::Vector3 lengthens_ = spidar::Vector3::Zero();   // m/s, low-passed
  bool hand_known_ = false;                               // the hand of the step before was free
  spidar::Vector3 hand_before_ = spidar::Vector3::Zero(); // m
};

} // namespace haptic
