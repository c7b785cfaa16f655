// SPDX-License-Identifier: LGPL-2.1-or-later
#include "force/carry-law.hpp"

#include "force/force-law.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace haptic {
namespace {

using spidar::Vector3;

// 250 N/m leave 29 % of a sway of 1 Hz to a hand of 1 kg and 8 N·s/m, 300 leave 24 %.
constexpr double kStiffest = 300; // N/m
// The slew rate follows the spring up to here, 20 N/s the stiffest one.
constexpr double kFastestHand = 0.067; // m/s
// A damper acts later than its spring, by its low-pass. With a half of it a hand of 0.4 kg shook by
// 0.06 N at late ticks, and a hand led out at 0.9 m/s at 500 Hz gained 0.5 mJ.
constexpr double kShareThatCalms = 1.0 / 6;

constexpr double kComes = 0.2;  // s, back to the whole stiffness, and of the law
constexpr double kFades = 0.25; // s back, while the thing is hidden or too fast
constexpr double kEnds = 0.05;  // s back, when it is let go

// J. A hand that goes with the thing seems to stand, while the spring grows, and then to take all
// of a count at the force that the spring has at its end: half a count more than the hand took.
double hidden_by_counts(double stiffness, double way, const spidar::DeviceLimits &device) noexcept {
  return stiffness * device.metres_per_count / 2 * way;
}

double damping_at(const CarryLimits &limits) noexcept {
  return kShareOfDampers * limits.device.most_resistance(limits.longest_dt);
}

double stiffness_at(const CarryLimits &limits) noexcept {
  const spidar::DeviceLimits &device = limits.device;
  const double damping = device.physical_damping + kShareThatCalms * damping_at(limits);
  return std::min({kStiffest, device.stiffness, limits.slew_rate / kFastestHand,
                   damping / (device.delay * limits.longest_dt)});
}

// The spring has the force min(k d, F), and its energy is the integral of that.
double energy_of(double length, double stiffness, double most) noexcept {
  const double bend = most / stiffness; // m
  return length < bend ? stiffness * length * length / 2 : most * (length - bend / 2);
}

double length_of(double energy, double stiffness, double most) noexcept {
  if (!(most > 0))
    return 0;
  const double bend = most / stiffness;
  const double left = std::max(energy, 0.0);
  return left < most * bend / 2 ? std::sqrt(2 * left / stiffness) : left / most + bend / 2;
}

} // namespace

void CarryLaw::ramp(HoldState state, double follows, double dt) noexcept {
  const double target = state == HoldState::held ? follows : 0;
  law_ += std::clamp(1 - target - law_, -dt / kComes, dt / kComes);
  const bool fades = state == HoldState::held || state == HoldState::hidden;
  if (share_ == 0) // without a length, it may be as stiff as it likes
    share_ = target;
  else if (target >= share_)
    share_ = std::min(share_ + dt / kComes, target);
  else
    share_ = std::max(share_ - dt / (fades ? kFades : kEnds), target);
  wants_ = state == HoldState::held || share_ > 0 || law_ < 1;
}

// A stiffness that comes must not give energy: the spring is shortened to what it has.
void CarryLaw::set_stiffness(double stiffness, double most) noexcept {
  if (stiffness_ > 0 && stiffness > stiffness_)
    spring_ = clamp_norm(spring_,
                         length_of(energy_of(spring_.norm(), stiffness_, most), stiffness, most));
  stiffness_ = stiffness;
}

// F = k d + b d', d' low-passed. The end takes part in the way of the thing; its work is the
// film's.
void CarryLaw::step(HoldState state, const Vector3 &moved, const Vector3 &hand,
                    const CarryLimits &limits, double dt) noexcept {
  if (!hand.allFinite() || !moved.allFinite() || !(dt > 0))
    return restart();
  const double follows = std::clamp(2 - moved.norm() / dt / kFastestThing, 0.0, 1.0);
  ramp(ends_ ? HoldState::none : state, follows, dt);
  if (share_ == 0) {
    const CarryLaw before = std::exchange(*this, {});
    wants_ = before.wants_;
    law_ = before.law_;
    return;
  }
  const auto in_plane = [](const Vector3 &v) { return Vector3(v.x(), v.y(), 0); };
  const bool begins = stiffness_ == 0;
  const Vector3 way = begins || ends_ ? Vector3::Zero() : in_plane(follows * moved);
  const Vector3 hand_way = begins ? Vector3::Zero() : in_plane(hand - hand_);
  hand_ = hand;

  const double stiffer = stiffness_;
  const double most = limits.max_force;
  set_stiffness(share_ * stiffness_at(limits), most);
  damping_ = share_ * damping_at(limits);
  const Vector3 change = way - hand_way;
  spring_ = clamp_norm(spring_ + change,
                       length_of(limits.device.most_for_hand() * most, stiffness_, most));
  lengthens_ += (1 - std::exp(-2 * std::numbers::pi * spidar::DeviceLimits::kSpeedCutoff * dt)) *
                (change / dt - lengthens_);

  const Vector3 damper = damping_ * lengthens_;
  const double out = std::max(hand_way.dot(spring_.stableNormalized()), 0.0);
  if (out > 0)
    spring_ = clamp_norm(spring_, length_of(limits.energy, stiffness_, most));
  const double before = pull_.force.norm();
  pull_.force = clamp_norm(stiffness_ * spring_, most) + damper;
  pull_.carried = way;
  pull_.hidden_work = hidden_by_counts(stiffness_, way.norm(), limits.device);
  pull_.energy = energy_of(spring_.norm(), stiffness_, most);
  pull_.released = stiffness_ * out;
  if (stiffness_ < stiffer)
    pull_.released += std::max(before - pull_.force.norm(), 0.0);
}

// The spring is certain, as a surface is: the confidence of the motion is that of the law alone.
void CarryLaw::apply(HoldLaw law, SafetyChain::Input &input) const noexcept {
  if (!wants_)
    return;
  input.make_certain(law == HoldLaw::both ? 1 : law_);
  input.touch.force += pull_.force;
  input.touch.carried = pull_.carried;
  input.touch.energy += pull_.energy;
  input.touch.hidden_work += pull_.hidden_work;
  input.touch.released += pull_.released;
}

} // namespace haptic
