// SPDX-License-Identifier: LGPL-2.1-or-later
// A hand that holds a rigid grip on the real strings of a geometry. Nothing in it is random: the
// same words at the same times give the same counts. SI units, frame of spidar/types.hpp.
#pragma once

#include "model/drive-scale.hpp"
#include "model/string-kinematics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <spidar/controller.hpp>
#include <spidar/geometry.hpp>
#include <string>
#include <utility>

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

class HandOnStrings final : public spidar::Controller {
public:
  HandOnStrings(const spidar::Geometry &geometry, const Hand &of, const spidar::Vector3 &start)
      : hand(of), target(start), goal(start), geometry_(geometry), aimed_at_(start),
        position_(start) {
    double nearest = geometry.motors[0].norm();
    for (const spidar::Vector3 &motor : geometry.motors)
      nearest = std::min(nearest, motor.norm());
    reach_ = nearest / 2;
    update_strings();
  }

  // What the hand does until the next exchange.

  Hand hand;
  spidar::Vector3 target; ///< m
  spidar::Vector3 goal;   ///< m, to which the target moves in a straight line
  double speed = 0;       ///< m/s, of the target
  /// m/s², with which it gets that fast after a change of the goal
  double acceleration = std::numeric_limits<double>::infinity();
  bool leads = false;                             ///< the grip is at the target, whatever the force
  bool presses = false;                           ///< the button of the grip
  std::optional<TurningHand> turning_hand;        ///< none: the orientation is held
  spidar::Vector3 push = spidar::Vector3::Zero(); ///< N, from outside

  // What the electronics do.

  spidar::Counts slip{};  ///< counts by which each string has slipped
  bool answers = true;    ///< to exchanges; if not, the words stay at the motors
  bool plugged_in = true; ///< if not, for good
  /// The guardian puts the motors at rest.
  void intervene() noexcept {
    tensions_.setConstant(geometry_.tension_min);
    intervened_ = true;
  }

  // What is true.

  const spidar::Vector3 &position() const noexcept { return position_; } ///< m
  const spidar::Vector3 &velocity() const noexcept { return velocity_; } ///< m/s
  const spidar::Matrix3 &rotation() const noexcept { return rotation_; }
  /// N and N·m, of the strings.
  spidar::Wrench wrench() const noexcept {
    return spidar::realised_wrench(strings_.pull, tensions_);
  }
  /// J that the strings have done on the grip. Exact: a constant tension does its product with the
  /// shortening of the string, whatever the way.
  double work() const noexcept { return work_; }

  void set_time(std::int64_t now) noexcept override {
    elapsed_ = now_ ? static_cast<double>(now - *now_) * 1e-9 : 0;
    now_ = now;
  }
  bool exchange(const spidar::DacWords &words, spidar::Counts &counts) noexcept override {
    advance(std::exchange(elapsed_, 0));
    if (!answers || !plugged_in)
      return false;
    for (std::size_t i = 0; i < spidar::kStrings; ++i)
      tensions_[at(i)] = std::max(spidar::tension_of_word(geometry_, i, words[i]), 0.0);
    counts = counts_of(strings_.lengths);
    for (std::size_t i = 0; i < spidar::kStrings; ++i)
      counts[i] += slip[i];
    return true;
  }
  bool home(spidar::Counts &counts) const noexcept override {
    counts = counts_of(string_kinematics(geometry_, {}).lengths);
    return true;
  }
  bool connected() const noexcept override { return plugged_in; }
  bool interrupted() noexcept override { return std::exchange(intervened_, false); }
  bool pressed() const noexcept override { return presses; }
  std::string description() const override { return "a hand on strings"; }

private:
  // Short against the hands: 10 ms is the fastest of them.
  static constexpr double kLongestStep = 0.00025; // s

  static Eigen::Index at(std::size_t i) noexcept { return static_cast<Eigen::Index>(i); }

  spidar::Counts counts_of(const spidar::StringLengths &lengths) const noexcept {
    spidar::Counts counts;
    for (std::size_t i = 0; i < spidar::kStrings; ++i)
      counts[i] =
          static_cast<std::int32_t>(std::lround(lengths[at(i)] / geometry_.metres_per_count[i]));
    return counts;
  }

  void update_strings() noexcept {
    const spidar::StringLengths before = strings_.lengths;
    strings_ = string_kinematics(geometry_, {position_, rotation_});
    work_ += tensions_.dot(before - strings_.lengths);
  }

  void advance(double elapsed) noexcept {
    const int steps = static_cast<int>(std::ceil(elapsed / kLongestStep - 1e-9));
    for (int i = 0; i < steps; ++i)
      step(elapsed / steps);
  }

  // Semi-implicit Euler.
  void step(double dt) noexcept {
    if (goal != aimed_at_)
      target_speed_ = 0;
    aimed_at_ = goal;
    target_speed_ = std::min(speed, target_speed_ + acceleration * dt);
    const spidar::Vector3 left = goal - target;
    target += std::min(1.0, target_speed_ * dt / std::max(left.norm(), 1e-12)) * left;
    const spidar::Wrench strings = wrench();
    if (leads) {
      velocity_ = (target - position_) / dt;
    } else {
      velocity_ +=
          dt / hand.mass *
          (strings.force + push + hand.stiffness * (target - position_) - hand.damping * velocity_);
    }
    position_ += dt * velocity_;
    if (const double distance = position_.norm(); distance > reach_) {
      position_ *= reach_ / distance;
      velocity_.setZero();
    }
    if (turning_hand)
      turn(dt, strings.torque);
    update_strings();
  }

  void turn(double dt, const spidar::Vector3 &torque) noexcept {
    constexpr double kLargestTurn = 1.4; // rad, where the strings cross
    const Eigen::AngleAxisd turned_by(rotation_);
    turning_ += dt / turning_hand->inertia *
                (torque - turning_hand->stiffness * turned_by.angle() * turned_by.axis() -
                 turning_hand->damping * turning_);
    const spidar::Matrix3 next = spidar::turned(rotation_, dt * turning_);
    if (Eigen::AngleAxisd(next).angle() < kLargestTurn)
      rotation_ = next;
    else
      turning_.setZero();
  }

  spidar::Geometry geometry_;
  double reach_ = 0; // m; the grip cannot get farther from the centre
  spidar::Tensions tensions_ = spidar::Tensions::Zero();
  spidar::StringKinematics strings_{spidar::WrenchMatrix::Zero(), spidar::StringLengths::Zero()};
  spidar::Vector3 aimed_at_; // the goal, until it changes
  double target_speed_ = 0;  // m/s
  spidar::Vector3 position_;
  spidar::Vector3 velocity_ = spidar::Vector3::Zero();
  spidar::Matrix3 rotation_ = spidar::Matrix3::Identity();
  spidar::Vector3 turning_ = spidar::Vector3::Zero(); // rad/s
  std::optional<std::int64_t> now_;                   // ns
  double elapsed_ = 0;                                // s, that the next exchange advances
  double work_ = 0;                                   // J
  bool intervened_ = false;                           // not told yet
};

} // namespace test
