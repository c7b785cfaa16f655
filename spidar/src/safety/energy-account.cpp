// SPDX-License-Identifier: LGPL-2.1-or-later
#include "safety/energy-account.hpp"

#include <algorithm>
#include <chrono>
#include <spidar/haptic-device.hpp>

namespace haptic {
namespace {

using spidar::Vector3;
using spidar::Wrench;

// The force goes down over the last of the work, so that running out of it is no step.
constexpr double kWorkToFade = 0.25; // J

// A tick that is later than any before it, as late as holds no force yet, costs no more than this.
constexpr double kLateTick = std::chrono::duration<double>(spidar::kLongestSilence).count(); // s
constexpr double kCreditOfLateTick = 8e-4;                                                   // J

double work(const Wrench &wrench, const EnergyAccount::Charge &charge) {
  return wrench.force.dot(charge.moved) + wrench.torque.dot(charge.turned);
}

} // namespace

// E += 0.3 W dt - max(F . dx + tau . dphi, 0), E <= 0.9 J, by the pose: a low-passed velocity lags
// by 5 ms and misses half of the work on a hand that goes round fast. Only work that the force did
// counts: a hand that pushes back does not add to the purse. What a late tick let the force do
// beyond it is a debt.
// The hand's: E -= F_hand . (dx - dx_thing) + tau_hand . dphi, of what acted beside the film's
// part.
void EnergyAccount::charge(const Charge &charge) noexcept {
  const double time = std::max(charge.time, 0.0);
  const double all = work(charge.acted, charge);
  film_ = std::min(film_ + kWorkRate * time - std::max(all, 0.0), kWorkAtOnce);
  if (!charge.limits_film)
    film_ = std::max(film_, 0.0);
  hand_ += charge.surface_work;
  if (charge.by_hand)
    hand_ += charge.trickle * time - (all - work(charge.film, charge)) +
             (charge.acted.force - charge.film.force).dot(charge.carried);
  hand_ = std::min(hand_, charge.most);
  if (hand_ < 0)
    hand_ = std::min(hand_ + charge.hidden_work, 0.0);
}

// From a centre that is off, force and way are measured wrong, by 14 % in all at 16 mm. What the
// hand has put in must be enough for what it gets back by the new measure.
void EnergyAccount::calibrate() noexcept {
  constexpr double kKept = 0.5;
  hand_ *= hand_ > 0 ? kKept : 1;
}

double EnergyAccount::share_of_film() const noexcept {
  return std::clamp(film_ / kWorkToFade, 0.0, 1.0);
}

// |F . v| T <= E, T of the delay, v of the low-pass or of the last tick: a hand that presses in may
// turn round before the force does. While it presses in, it pays a debt. What is on its way to the
// device is paid first: it may be far more than the force that follows it. While ticks are late, a
// command acts far longer than a tick on time: a hand at rest whose count flickers in that one
// would seem to be fast, and lose its touch for a tick.
Vector3 EnergyAccount::affordable(const Vector3 &force, const Motion &hand) const noexcept {
  Vector3 last_velocity = Vector3::Zero();
  if (const double moved = hand.moved.norm(); hand.time > 0 && moved > hand.flicker)
    last_velocity = (1 - hand.flicker / moved) / hand.time * hand.moved;
  const auto pushing = [&](const Vector3 &part) {
    return std::max({part.dot(hand.velocity), part.dot(last_velocity), 0.0});
  };
  const double pushes = pushing(force);   // W
  const double resists = pushing(-force); // W
  const double held = std::max(hand_, 0.0);
  double share = 1;
  const auto limit = [&](double price, double purse) {
    if (price > purse)
      share = std::min(share, purse / price);
  };
  const double due = pushing(hand.on_its_way) * hand.takes;
  limit(pushes * (hand.delay - hand.takes), std::max(hand_ + hand.lent - due, 0.0));
  limit(resists * hand.delay, held + hand.credit);
  limit(std::max(pushes, resists) * kLateTick, held + kCreditOfLateTick);
  return share * force;
}

} // namespace haptic
