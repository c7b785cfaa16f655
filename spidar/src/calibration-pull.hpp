// SPDX-License-Identifier: LGPL-2.1-or-later
// The force with which spidar-calibrate pulls: a ramp to what is wanted, on the axes as measured.
#pragma once

#include "spidar/types.hpp"

#include <algorithm>

namespace spidar {

class CalibrationPull {
public:
  /// The force to approach, N, along the true axes as far as mirror() told them.
  void want(const Vector3 &force) noexcept { wanted_ = force; }
  /// No force from now on.
  void release() noexcept { force_ = wanted_ = Vector3::Zero(); }
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

private:
  static constexpr double kRamp = 2; // N/s

  Vector3 wanted_ = Vector3::Zero(); ///< N
  Vector3 force_ = Vector3::Zero();  ///< N
  Vector3 signs_ = Vector3::Ones();
};

} // namespace spidar
