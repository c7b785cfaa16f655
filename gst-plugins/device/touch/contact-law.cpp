// SPDX-License-Identifier: LGPL-2.1-or-later
#include "touch/contact-law.hpp"

#include "force/force-law.hpp"
#include "safety/safety-chain.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace haptic {
namespace {

using spidar::Vector3;

// A hand that is not braked must not be faster than the spring can follow.
static_assert(ContactLaw::kFastestSurface == SafetyChain::kUndamped);

// s: damper over spring. With 5 ms, 1 kg on the coarsest encoders swings for more than 15 s.
constexpr double kDampingTime = 0.0075;
// The same where the damper is more than may follow the speed of a hand: there, counts flicker.
constexpr double kLeastDampingTime = 0.005;
constexpr double kWholeDamping = 0.0005; // m of depth from which the damper is whole
constexpr int kSlideSteps = 8;           // of half a cell, per tick: 3 m/s in cells of 0.8 mm
constexpr int kHalvings = 5;
constexpr double kAtRest = 1e-8;  // m of slip that is not worth a step
constexpr double kHanging = 1e-4; // m outside the friction cone
constexpr int kBisections = 16;   // of the hand's way in one tick

} // namespace

double stiffest(const ContactLimits &limits) noexcept {
  return std::min(limits.slew_rate / ContactLaw::kFastestSurface,
                  limits.device.stiffest_spring(limits.longest_dt));
}

void ContactLaw::restart() noexcept {
  contact_ = {};
  lag_ = 0;
  sunk_ = 0;
  sinks_ = false;
  hand_known_ = false;
}

// Of the stiffness with ticks on time: late ones make a surface soft, but its damper only as weak
// as they have to.
void ContactLaw::set_damping(double whole_stiffness, const ContactLimits &limits) noexcept {
  const double on_time =
      std::min({whole_stiffness, limits.slew_rate / kFastestSurface, limits.device.stiffness});
  const double most = kShareOfDampers * limits.device.most_resistance(limits.longest_dt);
  damping_ = std::max(kLeastDampingTime * stiffness_, std::min(kDampingTime * on_time, most));
}

void ContactLaw::hold() noexcept {
  if (contact_.touches || sinks_ || sunk_ != 0)
    sink();
  else
    restart();
}

void ContactLaw::sink() noexcept {
  restart();
  sinks_ = true;
}

// Returns whether the hand came through the surface, and sets the proxy to where. A hand over which
// the surface came, or that came beneath it from the side, out of a hole, is not thrown out: the
// surface begins at the hand (lag_).
bool ContactLaw::touch(const ReliefSurface &surface, const Vector3 &hand) noexcept {
  const SurfacePoint here = surface.at(hand.x(), hand.y());
  if (!here.exists || hand.z() >= here.height) {
    sunk_ = 0;
    sinks_ = false;
    return false;
  }
  if (hand.z() >= felt_height(here))
    return false;
  const auto is_inside = [&](const Vector3 &place) {
    const SurfacePoint point = surface.at(place.x(), place.y());
    return point.exists && place.z() < felt_height(point);
  };
  const auto begin_at_hand = [&] {
    (std::exchange(sinks_, false) ? sunk_ : lag_) += hand.z() - felt_height(here);
    contact_.proxy = hand;
    stiffness_ = 0;
    return true;
  };
  if (!hand_known_ || is_inside(hand_before_))
    return begin_at_hand();
  double outside = 0;
  double inside = 1;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = (outside + inside) / 2;
    (is_inside(hand_before_ + middle * (hand - hand_before_)) ? inside : outside) = middle;
  }
  const Vector3 last_outside = hand_before_ + outside * (hand - hand_before_);
  if (!surface.at(last_outside.x(), last_outside.y()).exists)
    return begin_at_hand();
  contact_.proxy = hand_before_ + inside * (hand - hand_before_);
  contact_.proxy.z() = felt_height(surface.at(contact_.proxy.x(), contact_.proxy.y()));
  stiffness_ = 0;
  return true;
}

// The proxy stays at its place of the picture while the surface moves, at most at kFastestSurface:
// what the film moves farther becomes lag_. That movement is the only one that gives the spring
// energy. A stiffness that a new frame raises must not: the spring is shortened to the same energy
// (k' d'² = k d²), and the surface comes back from there.
void ContactLaw::move_with_surface(const ReliefSurface &surface, const Vector3 &hand,
                                   double most_stiffness, double dt) noexcept {
  Vector3 &proxy = contact_.proxy;
  SurfacePoint point = surface.at(proxy.x(), proxy.y());
  const double stiffness = std::min(point.stiffness, most_stiffness);
  if (point.exists && stiffness_ > 0 && stiffness > stiffness_) {
    proxy = hand + std::sqrt(stiffness_ / stiffness) * (proxy - hand);
    point = surface.at(proxy.x(), proxy.y());
  }
  if (!point.exists) // the hand has a surface and the proxy has none: it begins anew at the hand
    return restart();
  lag_ = proxy.z() - point.height - sunk_;
  const double most = kFastestSurface * dt;
  lag_ -= std::clamp(lag_, -most, most);
  proxy.z() = felt_height(point);
}

// Shortens the spring: the proxy slips over the surface until it is within the friction cone,
// |t| <= mu n of its distance to the hand. A step is made only if it lowers the energy k d² / 2, so
// that neither the shape nor the map of the stiffness gives energy.
void ContactLaw::slide(const ReliefSurface &surface, const Vector3 &hand,
                       double most_stiffness) noexcept {
  Vector3 &proxy = contact_.proxy;
  SurfacePoint point = surface.at(proxy.x(), proxy.y());
  const auto energy = [&](const SurfacePoint &at, const Vector3 &place) {
    return std::min(at.stiffness, most_stiffness) * (place - hand).squaredNorm();
  };
  double now = energy(point, proxy);
  for (int i = 0; i < kSlideSteps; ++i) {
    const Vector3 normal = surface.normal(proxy.x(), proxy.y());
    const Vector3 spring = proxy - hand;
    const double depth = std::max(spring.dot(normal), 0.0);
    const Vector3 tangent = spring - depth * normal;
    const double length = tangent.norm();
    double step = std::min(length - point.friction * depth, surface.cell() / 2);
    bool slipped = false;
    for (int tried = 0; tried < kHalvings && step > kAtRest && !slipped; ++tried, step /= 2) {
      Vector3 place = proxy - step / length * tangent;
      const SurfacePoint there = surface.at(place.x(), place.y());
      place.z() = felt_height(there);
      const double then = energy(there, place);
      if (!there.exists || then >= now)
        continue;
      proxy = place;
      point = there;
      now = then;
      slipped = true;
    }
    if (!slipped)
      break;
  }
  stiffness_ = std::min(point.stiffness, most_stiffness);
}

// A proxy that a falling flank took beneath the hand, and that cannot slip back into the friction
// cone, would pull the hand in. Another spring begins at the hand, without energy.
bool ContactLaw::hangs(const ReliefSurface &surface, const Vector3 &hand) const noexcept {
  const Vector3 &proxy = contact_.proxy;
  const Vector3 spring = proxy - hand;
  if (spring.z() >= 0)
    return false;
  const Vector3 normal = surface.normal(proxy.x(), proxy.y());
  const double depth = std::max(spring.dot(normal), 0.0);
  const double friction = surface.at(proxy.x(), proxy.y()).friction;
  return (spring - depth * normal).norm() > friction * depth + kHanging;
}

const Contact &ContactLaw::step(const ReliefSurface &surface, const Vector3 &hand,
                                const ContactLimits &limits, double dt) noexcept {
  if (!hand.allFinite() || !(dt > 0)) {
    restart();
    return contact_;
  }
  const double most = stiffest(limits);
  const Vector3 before = hand_known_ || contact_.touches ? hand_before_ : hand;
  const double height = contact_.proxy.z();
  Vector3 rise = Vector3::Zero(); // m
  const bool touched = contact_.touches;
  if (touched)
    move_with_surface(surface, hand, most, dt);
  if (contact_.touches)
    rise.z() = contact_.proxy.z() - height;
  else
    contact_.touches = touch(surface, hand);
  const SurfacePoint here = surface.at(hand.x(), hand.y());
  contact_.touches = contact_.touches && here.exists && hand.z() <= felt_height(here) + kAtRest;
  hand_before_ = hand;
  hand_known_ = !contact_.touches;
  if (!contact_.touches) {
    contact_ = {.proxy = hand};
    lag_ = 0;
    follow_length(before - hand, dt);
    return contact_;
  }
  // F . dx of a spring that grew meanwhile. One that the surface shortens has less energy left.
  contact_.surface_work = std::max(stiffness_ * (contact_.proxy - hand - rise / 2).dot(rise), 0.0);
  const Vector3 stuck = contact_.proxy;
  slide(surface, hand, most);
  set_damping(surface.at(contact_.proxy.x(), contact_.proxy.y()).stiffness, limits);
  const Vector3 spring = contact_.proxy - hand;
  Vector3 longer = touched ? Vector3(stuck - hand - spring_) : Vector3(before - hand);
  if (contact_.proxy != stuck) { // it does not hold the hand back along the surface
    const Vector3 normal = surface.normal(contact_.proxy.x(), contact_.proxy.y());
    longer = longer.dot(normal) * normal;
  }
  follow_length(longer, dt);
  if (hangs(surface, hand)) {
    lag_ = hand.z() - here.height - sunk_;
    contact_.proxy = hand;
    stiffness_ = 0;
  }
  const double out = touched ? (hand - before).dot(spring.normalized()) : 0; // m
  contact_.released = stiffness_ * std::max(out, 0.0);
  if (out > 0)
    shorten_to(limits.energy + contact_.surface_work, surface, hand);
  spring_ = contact_.proxy - hand;
  contact_.force = force(surface, spring_);
  contact_.energy = stiffness_ * spring_.squaredNorm() / 2;
  return contact_;
}

// A hand that has turned round is not damped on its way out by its way in.
void ContactLaw::follow_length(const Vector3 &change, double dt) noexcept {
  lengthens_ += (1 - std::exp(-2 * std::numbers::pi * spidar::DeviceLimits::kSpeedCutoff * dt)) *
                (change / dt - lengthens_);
  if (change.dot(lengthens_) < 0)
    lengthens_ -= change.dot(lengthens_) / change.squaredNorm() * change;
}

// k d² / 2 <= E: what the hand did not put in, or what a limit of the force took from it, does not
// come back.
void ContactLaw::shorten_to(double energy, const ReliefSurface &surface,
                            const Vector3 &hand) noexcept {
  Vector3 &proxy = contact_.proxy;
  const Vector3 spring = proxy - hand;
  const double most = std::sqrt(2 * std::max(energy, 0.0) / stiffness_);
  const double depth = spring.norm();
  if (!(depth > most))
    return;
  const Vector3 place = hand + most / depth * spring;
  const SurfacePoint there = surface.at(place.x(), place.y());
  if (!there.exists)
    return;
  sunk_ += place.z() - felt_height(there);
  proxy = place;
}

// F = k d + c d', c = k T min(|d| / d_0, 1), d' low-passed: a damper of the hand against the proxy.
// It never pulls, and along the surface it is at most friction, or the spring.
Vector3 ContactLaw::force(const ReliefSurface &surface, const Vector3 &spring) const noexcept {
  const Vector3 &proxy = contact_.proxy;
  const Vector3 normal = surface.normal(proxy.x(), proxy.y());
  const double damper = damping_ * std::min(spring.norm() / kWholeDamping, 1.0);
  const Vector3 all = stiffness_ * spring + damper * lengthens_;
  const double press = std::max(all.dot(normal), 0.0);
  const Vector3 across = all - all.dot(normal) * normal;
  const double held = stiffness_ * (spring - spring.dot(normal) * normal).norm();
  const double most = std::max(held, surface.at(proxy.x(), proxy.y()).friction * press);
  return press * normal + std::min(across.norm(), most) * across.stableNormalized();
}

} // namespace haptic
