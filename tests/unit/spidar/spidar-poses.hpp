// SPDX-License-Identifier: LGPL-2.1-or-later
// Poses and directions for the tests of the device: seeded, or evenly spread.
#pragma once

#include "spidar/types.hpp"

#include <cmath>
#include <Eigen/Geometry>
#include <numbers>
#include <random>
#include <vector>

namespace spidar_test {

constexpr double kDegree = std::numbers::pi / 180;

inline spidar::Matrix3 turn(const spidar::Vector3 &axis, double angle) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// `count` unit vectors spread evenly over the sphere (Fibonacci lattice).
inline std::vector<spidar::Vector3> directions(int count) {
  std::vector<spidar::Vector3> result;
  for (int i = 0; i < count; ++i) {
    const double height = 1 - 2 * (i + 0.5) / count;
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const double radius = std::sqrt(1 - height * height);
    result.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
  }
  return result;
}

class Random {
public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(engine_);
  }
  spidar::Vector3 in_box(double half) {
    return {between(-half, half), between(-half, half), between(-half, half)};
  }
  spidar::Vector3 direction() {
    for (;;) {
      const spidar::Vector3 vector = in_box(1);
      if (vector.norm() > 0.1 && vector.norm() <= 1)
        return vector.normalized();
    }
  }
  spidar::Pose pose(double half, double most_turned) {
    return {in_box(half), turn(direction(), between(0, most_turned))};
  }

private:
  std::mt19937 engine_;
};

/// Angle between two orientations, rad.
inline double angle_between(const spidar::Matrix3 &a, const spidar::Matrix3 &b) {
  return Eigen::AngleAxisd(spidar::Matrix3(a.transpose() * b)).angle();
}

} // namespace spidar_test
