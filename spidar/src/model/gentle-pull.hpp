// SPDX-License-Identifier: LGPL-2.1-or-later
// The force with which the tools pull: a ramp to what is wanted, on the axes as measured.
#pragma once

#include "spidar/haptic-device.hpp"

#include <algorithm>

namespace spidar {

class GentlePull {
public:
  /// The force to approach, N, along the true axes as far as mirror() told them.
  void want(const Vector3 &force) noexcept {
    wanted_ = force;
    ended_ = false;
  }
  /// No force from now on.
  void release() noexcept { force_ = wanted_ = Vector3::Zero(); }
  /// Call it after each exchange: releases when the guardian has intervened, when the device is not
  /// `armed` (LimitedDevice), after a string slipped, and where no pose is known.
  void release_if_unsafe(const DeviceState &state, bool armed) noexcept {
    without_pose_ = state.valid ? 0 : without_pose_ + 1;
    if (state.interrupted || state.slipped || !armed || without_pose_ >= kMostWithoutPose) {
      release();
      ended_ = true;
    }
  }
  /// Whether release_if_unsafe() has released since want().
  bool ended() const noexcept { return ended_; }
  /// The device's geometry has `axis` the other way round.
  void mirror(int axis) noexcept {
    signs_[axis] *= -1;
    force_[axis] *= -1; // what is commanded stays as it is
  }
  /// Returns the force to command after `dt` s, along the axes of the device's geometry. With
  /// mirrored motors and attachments the tensions for F are those of the geometry itself for the
  /// mirrored F.
  Vector3 step(double dt) noexcept {
    const Vector3 change = wanted_ - force_;
    force_ += change * std::min(1.0, kRamp * dt / std::max(change.norm(), 1e-9));
    return force_.cwiseProduct(signs_);
  }
  /// N, as step() returned it last, or zero.
  double norm() const noexcept { return force_.norm(); }

private:
  static constexpr double kRamp = 2;         // N/s
  static constexpr int kMostWithoutPose = 3; // ticks; a single lost reply is no reason

  Vector3 wanted_ = Vector3::Zero(); ///< N
  Vector3 force_ = Vector3::Zero();  ///< N
  Vector3 signs_ = Vector3::Ones();
  int without_pose_ = 0; ///< ticks
  bool ended_ = false;
};

} // namespace spidar
