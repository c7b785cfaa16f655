// SPDX-License-Identifier: LGPL-2.1-or-later
// A hand that holds a rigid grip on the real strings of a geometry. Nothing in it is random: the
// same words at the same times give the same counts. SI units, frame of spidar/types.hpp.
#pragma once

#include "held-grip.hpp"
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

class HandOnStrings final : public spidar::Controller, public HeldGrip {
public:
  HandOnStrings(const spidar::Geometry &geometry, const Hand &of, const spidar::Vector3 &start)
      : HeldGrip(of, start, reach_of(geometry)), geometry_(geometry) {
    update_strings();
  }

  spidar::Counts slip{}; ///< counts by which each string has slipped
  /// The guardian puts the motors at rest.
  void intervene() noexcept override {
    tensions_.setConstant(geometry_.tension_min);
    intervened_ = true;
  }

  // What is true.

  const spidar::Matrix3 &rotation() const noexcept { return rotation_; }
  /// N and N·m, of the strings.
  spidar::Wrench wrench() const noexcept override {
    return spidar::realised_wrench(strings_.pull, tensions_);
  }

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
  static double reach_of(const spidar::Geometry &geometry) noexcept {
    double nearest = geometry.motors[0].norm();
    for (const spidar::Vector3 &motor : geometry.motors)
      nearest = std::min(nearest, motor.norm());
    return nearest / 2;
  }
  static Eigen::Index at(std::size_t i) noexcept { return static_cast<Eigen::Index>(i); }

  spidar::Counts counts_of(const spidar::StringLengths &lengths) const noexcept {
    spidar::Counts counts;
    for (std::size_t i = 0; i < spidar::kStrings; ++i)
      counts[i] =
          static_cast<std::int32_t>(std::lround(lengths[at(i)] / geometry_.metres_per_count[i]));
    return counts;
  }

  // The work is exact: a constant tension does its product with the shortening of the string,
  // whatever the way.
  void update_strings() noexcept {
    const spidar::StringLengths before = strings_.lengths;
    strings_ = string_kinematics(geometry_, {position(), rotation_});
    work_ += tensions_.dot(before - strings_.lengths);
  }

  void advance(double elapsed) noexcept {
    in_steps(elapsed, [this](double dt) {
      const spidar::Wrench strings = wrench();
      move(dt, strings.force);
      if (turning_hand)
        turn(dt, strings.torque);
      update_strings();
    });
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
  spidar::Tensions tensions_ = spidar::Tensions::Zero();
  spidar::StringKinematics strings_{spidar::WrenchMatrix::Zero(), spidar::StringLengths::Zero()};
  spidar::Matrix3 rotation_ = spidar::Matrix3::Identity();
  spidar::Vector3 turning_ = spidar::Vector3::Zero(); // rad/s
  std::optional<std::int64_t> now_;                   // ns
  double elapsed_ = 0;                                // s, that the next exchange advances
  bool intervened_ = false;                           // not told yet
};

} // namespace test
