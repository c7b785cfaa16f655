// SPDX-License-Identifier: LGPL-2.1-or-later
// Lengths of the eight strings at a pose, and the wrench of each per newton. Real-time safe.
#pragma once

#include "spidar/geometry.hpp"

#include <algorithm>
#include <Eigen/Geometry>

namespace spidar {

using WrenchMatrix = Eigen::Matrix<double, 6, kStrings>; ///< a column per string: force, torque
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct StringKinematics {
  /// Column i: unit force towards motor i (workspace frame) and its moment about the grip's centre
  /// (m). Its transpose maps the grip's velocity to the speed at which the strings shorten.
  WrenchMatrix pull;
  StringLengths lengths; ///< m
};

inline StringKinematics string_kinematics(const Geometry &geometry, const Pose &pose) noexcept {
  constexpr double kShortest = 1e-6; // m; keeps the direction finite with the grip on an exit point
  StringKinematics strings;
  for (std::size_t i = 0; i < kStrings; ++i) {
    const Vector3 arm = pose.rotation * geometry.attachments[i];
    const Vector3 string = geometry.motors[i] - pose.position - arm;
    const double length = std::max(string.norm(), kShortest);
    const Vector3 direction = string / length;
    // Not with <<, whose calls are an eighth of what a tick costs.
    strings.pull.col(i).head<3>() = direction;
    strings.pull.col(i).tail<3>() = arm.cross(direction);
    strings.lengths[i] = length;
  }
  return strings;
}

inline Wrench realised_wrench(const WrenchMatrix &pull, const Tensions &tensions) noexcept {
  const Vector6 wrench = pull * tensions;
  return {wrench.head<3>(), wrench.tail<3>()};
}

/// The axis of a rotation times its angle, rad.
inline Vector3 rotation_vector(const Matrix3 &rotation) noexcept {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

/// Rotation by the vector `turn` (axis times angle, rad), applied in the workspace frame.
inline Matrix3 turned(const Matrix3 &rotation, const Vector3 &turn) noexcept {
  const double angle = turn.norm();
  const Vector3 axis = angle > 0 ? Vector3(turn / angle) : Vector3::UnitX();
  const Matrix3 result = Eigen::AngleAxisd(angle, axis) * rotation;
  // One Newton step towards the nearest orthonormal matrix undoes what rounding adds per call.
  return result * (1.5 * Matrix3::Identity() - 0.5 * result.transpose() * result);
}

} // namespace spidar
