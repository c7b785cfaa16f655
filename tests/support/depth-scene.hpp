// SPDX-License-Identifier: LGPL-2.1-or-later
// A moving scene with exact depth: rays of a pinhole camera against balls, a wall and a floor.
#pragma once

#include "relief-field.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace test {

class DepthScene {
public:
  static constexpr int kWidth = 640; // px
  static constexpr int kHeight = 360;
  static constexpr double kNear = 1; // m
  static constexpr double kFar = 3;
  static constexpr double kRange = 0.04; // m of the relief between both
  static constexpr std::uint64_t kInterval = 33'333'333;

  /// Depth in m along the optical axis, at a pixel and a time in s. x right, y down, z away.
  static double depth(double x, double y, double time) {
    constexpr double kFocal = 600; // px
    const double rx = (x - kWidth / 2.0) / kFocal;
    const double ry = (y - kHeight / 2.0) / kFocal;
    double nearest = kFar - 0.1; // the wall
    if (ry > 0)                  // the floor, 0.6 m below the camera
      nearest = std::min(nearest, 0.6 / ry);
    for (const Ball &ball : balls(time)) {
      // |t (rx, ry, 1) - centre|^2 = radius^2, t the depth
      const double a = rx * rx + ry * ry + 1;
      const double b = rx * ball.x + ry * ball.y + ball.z;
      const double c =
          ball.x * ball.x + ball.y * ball.y + ball.z * ball.z - ball.radius * ball.radius;
      if (const double root = b * b - a * c; root > 0)
        nearest = std::min(nearest, (b - std::sqrt(root)) / a);
    }
    return nearest;
  }

  static float height(double depth) {
    return static_cast<float>(kRange * (0.5 - (depth - kNear) / (kFar - kNear)));
  }

  /// The relief of a frame: its depth at the centres of the cells.
  static haptic::ReliefField relief(int frame, int columns = 64) {
    haptic::ReliefField relief;
    relief.interval = kInterval;
    relief.frame_width = kWidth;
    relief.frame_height = kHeight;
    relief.columns = static_cast<std::uint16_t>(columns);
    relief.rows = static_cast<std::uint16_t>(columns * kHeight / kWidth);
    const double side = static_cast<double>(kWidth) / columns;
    const double time = frame * static_cast<double>(kInterval) * 1e-9;
    for (int row = 0; row < relief.rows; ++row)
      for (int column = 0; column < columns; ++column)
        relief.cells.push_back(
            {height(depth((column + 0.5) * side, (row + 0.5) * side, time)), 200, 0.3F, 1});
    return relief;
  }

private:
  struct Ball {
    double x, y, z, radius; // m
  };

  // One bounces, one circles, one rolls to and fro.
  static std::array<Ball, 3> balls(double time) {
    const double turn = 2 * std::numbers::pi * time;
    return {{{-0.5, 0.45 - 0.6 * std::abs(std::sin(turn / 1.6)), 2, 0.15},
             {0.4 * std::cos(turn / 3), -0.15, 2.2 + 0.4 * std::sin(turn / 3), 0.25},
             {0.7 * std::sin(turn / 5), 0.38, 1.7, 0.2}}};
  }
};

} // namespace test
