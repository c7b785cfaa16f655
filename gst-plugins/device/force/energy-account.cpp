// SPDX-License-Identifier: LGPL-2.1-or-later
#include "force/energy-account.hpp"

#include <algorithm>

namespace haptic {
namespace {

using spidar::Vector3;
using spidar::Wrench;

// The force goes down over the last of the work, so that running out of it is no step.
constexpr double kWorkToFade = 0.25; // J

// A command is computed, sent one tick later, and acts until the one after that; half a tick is the
// margin for a hand that becomes faster.
constexpr double kTicksOfCommand = 2.5;

double work(const Wrench &wrench, const EnergyAccount::Charge &charge) {
  return wrench.force.dot(charge.moved) + wrench.torque.dot(charge.turned);
}

} // namespace

// E += 0.3 W dt - max(F . dx + tau . dphi, 0), E <= 0.9 J, by the pose: a low-passed velocity lags
// by 5 ms and misses half of the work on a hand that goes round fast. Only work that the force did
// counts: a hand that pushes back does not add to the purse. What a late tick let the force do
// beyond it is a debt.
// The hand's: E -= F_hand . dx + tau_hand . dphi, of what acted beside the film's part.
void EnergyAccount::charge(const Charge &charge) noexcept {
  const double all = work(charge.acted, charge);
  film_ =
      std::min(film_ + kWorkRate * std::max(charge.time, 0.0) - std::max(all, 0.0), kWorkAtOnce);
  hand_ += charge.surface_work;
  if (charge.touched)
    hand_ -= all - work(charge.film, charge);
  hand_ = std::min(hand_, charge.most);
}

double EnergyAccount::share_of_film() const noexcept {
  return std::clamp(film_ / kWorkToFade, 0.0, 1.0);
}

// F . v 2.5 T <= E, v of the low-pass or of the last tick, whichever goes more with the force.
Vector3 EnergyAccount::affordable(const Vector3 &force, const Vector3 &velocity,
                                  const Vector3 &moved, double dt, double longest) const noexcept {
  const double power = std::max(force.dot(velocity), dt > 0 ? force.dot(moved) / dt : 0.0);
  const double price = power * kTicksOfCommand * longest;
  return price > std::max(hand_, 0.0) ? Vector3(force * (std::max(hand_, 0.0) / price)) : force;
}

} // namespace haptic
