// SPDX-License-Identifier: LGPL-2.1-or-later
// Quantities of the SPIDAR-G. SI units throughout. Frame of reference: origin in the workspace
// centre, x to the right, y up, z towards the user (right-handed).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <Eigen/Core>

namespace spidar {

inline constexpr std::size_t kStrings = 8;

// Not aligned: Eigen's own alignment depends on the processor that is compiled for (16 bytes for
// SSE, 32 for AVX), and library and user may be compiled for different ones. layout.hpp checks it.
using Vector3 = Eigen::Vector3d; // 24 and 72 bytes: Eigen never aligns these
using Matrix3 = Eigen::Matrix3d;
using StringLengths = Eigen::Matrix<double, kStrings, 1, Eigen::DontAlign>; ///< m, motor to grip
using Tensions = Eigen::Matrix<double, kStrings, 1, Eigen::DontAlign>;      ///< N, never negative

/// Position and orientation of the grip.
struct Pose {
  Vector3 position = Vector3::Zero();     ///< m
  Matrix3 rotation = Matrix3::Identity(); ///< grip frame to workspace frame
};

/// Force and torque on the grip, about its centre.
struct Wrench {
  Vector3 force = Vector3::Zero();  ///< N
  Vector3 torque = Vector3::Zero(); ///< N·m
};

/// Encoder counts, extended beyond the counters' width so that they do not wrap.
using Counts = std::array<std::int32_t, kStrings>;

/// D/A words, one per motor.
using DacWords = std::array<std::int16_t, kStrings>;

} // namespace spidar
