// SPDX-License-Identifier: LGPL-2.1-or-later
// A hand that holds the grip of a device. Nothing in it is random. SI units, frame of
// spidar/types.hpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <spidar/types.hpp>

namespace test {

/// A mass that a spring and a damper hold.
struct Hand {
  double mass = 0.4;    ///< kg, with the grip
  double damping = 3;   ///< N·s/m, with what the strings have
  double stiffness = 0; ///< N/m, to the target

  bool operator==(const Hand &) const = default;
};

/// The same for turning, towards the orientation of the centre.
struct TurningHand {
  double inertia = 1.7e-4; ///< kg·m², of the simulator's grip and hand
  double damping = 0.032;  ///< N·m·s, critical
  double stiffness = 1.5;  ///< N·m/rad
};

class HeldGrip {
public:
  HeldGrip(const Hand &of, const spidar::Vector3 &start, double reach)
      : hand(of), target(start), goal(start), reach_(reach), aimed_at_(start), position_(start) {}
  virtual ~HeldGrip() = default;

  // What the hand does until the next exchange.

  Hand hand;
  spidar::Vector3 target; ///< m
  spidar::Vector3 goal;   ///< m, to which the target moves in a straight line
  double speed = 0;       ///< m/s, of the target
  /// m/s², with which it gets that fast after a change of the goal
  double acceleration = std::numeric_limits<double>::infinity();
  bool leads = false;                      ///< the grip is at the target, whatever the force
  bool presses = false;                    ///< the button of the grip
  std::optional<TurningHand> turning_hand; ///< none: the orientation is held; an arm's always is
  spidar::Vector3 push = spidar::Vector3::Zero(); ///< N, from outside

  // What the electronics do.

  bool answers = true;    ///< to exchanges; if not, the force stays as it is
  bool plugged_in = true; ///< if not, for good
  /// A guardian puts the motors at rest.
  virtual void intervene() noexcept = 0;

  // What is true.

  const spidar::Vector3 &position() const noexcept { return position_; } ///< m
  const spidar::Vector3 &velocity() const noexcept { return velocity_; } ///< m/s
  virtual spidar::Wrench wrench() const noexcept = 0; ///< N and N·m, of the device
  double work() const noexcept { return work_; }      ///< J that the device has done on the grip

protected:
  // Calls step() with dt in s, all together `elapsed`.
  template <typename Step>
  static void in_steps(double elapsed, const Step &step) noexcept {
    constexpr double kLongestStep = 0.00025; // s; short against the hands: 10 ms is the fastest
    const int steps = static_cast<int>(std::ceil(elapsed / kLongestStep - 1e-9));
    for (int i = 0; i < steps; ++i)
      step(elapsed / steps);
  }
  // Semi-implicit Euler, of what the device's own mass and damping add to the hand's.
  void move(double dt, const spidar::Vector3 &force, double mass = 0, double damping = 0) noexcept {
    if (goal != aimed_at_)
      target_speed_ = 0;
    aimed_at_ = goal;
    target_speed_ = std::min(speed, target_speed_ + acceleration * dt);
    const spidar::Vector3 left = goal - target;
    target += std::min(1.0, target_speed_ * dt / std::max(left.norm(), 1e-12)) * left;
    if (leads) {
      velocity_ = (target - position_) / dt;
    } else {
      velocity_ += dt / (hand.mass + mass) *
                   (force + push + hand.stiffness * (target - position_) -
                    (hand.damping + damping) * velocity_);
    }
    position_ += dt * velocity_;
    if (const double distance = position_.norm(); distance > reach_) {
      const spidar::Vector3 outwards = position_ / distance;
      position_ = reach_ * outwards;
      velocity_ -= std::max(velocity_.dot(outwards), 0.0) * outwards;
    }
  }

  double work_ = 0; // J

private:
  double reach_;             // m; the grip cannot get farther from the centre
  spidar::Vector3 aimed_at_; // the goal, until it changes
  double target_speed_ = 0;  // m/s
  spidar::Vector3 position_;
  spidar::Vector3 velocity_ = spidar::Vector3::Zero();
};

} // namespace test
