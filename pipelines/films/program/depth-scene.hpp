// SPDX-License-Identifier: LGPL-2.1-or-later
// A moving scene with exact depth: rays of a pinhole camera against balls, a wall and a floor.
#pragma once

#include "scene/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace film {

class DepthScene {
public:
  static constexpr int kWidth = 640; // px
  static constexpr int kHeight = 360;
  static constexpr int kRate = 30;   // Hz
  static constexpr double kNear = 1; // m
  static constexpr double kFar = 3;
  static constexpr double kRange = 0.04; // m of the relief between both

  using Colour = std::array<float, 3>; // red, green, blue, 0..1

  struct Ball {
    double x, y, z, radius; // m
    double turn;            // rad, about z
    Colour colour;
  };
  using Balls = std::array<Ball, 3>;

  /// Time in s. One bounces, one circles, one rolls to and fro.
  static Balls balls(double time) {
    const double turn = 2 * std::numbers::pi * time;
    const double rolled = 0.7 * std::sin(turn / 5);
    return {{{-0.5, 0.45 - 0.6 * std::abs(std::sin(turn / 1.6)), 2, 0.15, 0, {0.9F, 0.25F, 0.2F}},
             {0.4 * std::cos(turn / 3),
              -0.15,
              2.2 + 0.4 * std::sin(turn / 3),
              0.25,
              time,
              {0.2F, 0.45F, 0.85F}},
             {rolled, 0.38, 1.7, 0.2, rolled / 0.2, {0.95F, 0.7F, 0.15F}}}};
  }

  /// Depth in m along the optical axis, at a pixel. x right, y down, z away.
  static double depth(double x, double y, const Balls &balls) { return hit(x, y, balls).depth; }
  static double depth(double x, double y, double time) { return depth(x, y, balls(time)); }

  /// Of the relief, in m.
  static float height(double depth) {
    return static_cast<float>(kRange * (0.5 - (depth - kNear) / (kFar - kNear)));
  }

  static Colour colour(double x, double y, const Balls &now) {
    const Hit seen = hit(x, y, now);
    const double px = ray(x, kWidth) * seen.depth; // m, the place that is seen
    const double py = ray(y, kHeight) * seen.depth;
    if (seen.ball >= 0)
      return of_ball(now[static_cast<std::size_t>(seen.ball)], seen, px, py);
    const bool is_floor = py > kFloor - 1e-6;
    const float grain = rough_noise(static_cast<float>(is_floor ? 3 * px : 6 * px),
                                    static_cast<float>(is_floor ? 30 * seen.depth : 6 * py), 3, 5);
    // What lies under a ball is darker.
    double light = 1;
    for (const Ball &ball : now)
      if (is_floor)
        light *= 1 - 0.6 *
                         std::exp(-(std::pow(px - ball.x, 2) + std::pow(seen.depth - ball.z, 2)) /
                                  (ball.radius * ball.radius)) *
                         std::exp(-4 * (kFloor - ball.y - ball.radius));
    const auto shade = static_cast<float>(light) * (0.6F + 0.7F * grain);
    return is_floor ? Colour{0.55F * shade, 0.40F * shade, 0.27F * shade}
                    : Colour{0.44F * shade, 0.51F * shade, 0.58F * shade};
  }

private:
  struct Hit {
    double depth;
    int ball; // -1: none
  };

  static constexpr double kFocal = 600; // px
  static constexpr double kFloor = 0.6; // m below the camera

  static double ray(double px, int size) { return (px - size / 2.0) / kFocal; }

  static Hit hit(double x, double y, const Balls &balls) {
    const double rx = ray(x, kWidth);
    const double ry = ray(y, kHeight);
    Hit nearest{kFar - 0.1, -1}; // the wall
    if (ry > 0)
      nearest.depth = std::min(nearest.depth, kFloor / ry);
    for (int i = 0; i < static_cast<int>(balls.size()); ++i) {
      // |t (rx, ry, 1) - centre|^2 = radius^2, t the depth
      const Ball &ball = balls[static_cast<std::size_t>(i)];
      const double a = rx * rx + ry * ry + 1;
      const double b = rx * ball.x + ry * ball.y + ball.z;
      const double c =
          ball.x * ball.x + ball.y * ball.y + ball.z * ball.z - ball.radius * ball.radius;
      if (const double root = b * b - a * c; root > 0)
        if (const double depth = (b - std::sqrt(root)) / a; depth < nearest.depth)
          nearest = {depth, i};
    }
    return nearest;
  }

  // Six sectors, a grain that makes motion visible, and light from the upper left.
  static Colour of_ball(const Ball &ball, const Hit &seen, double px, double py) {
    const double nx = (px - ball.x) / ball.radius;
    const double ny = (py - ball.y) / ball.radius;
    const double nz = (seen.depth - ball.z) / ball.radius;
    const double along = std::cos(ball.turn) * nx + std::sin(ball.turn) * ny;
    const double across = std::cos(ball.turn) * ny - std::sin(ball.turn) * nx;
    const double sector = (std::atan2(across, along) / std::numbers::pi + 1) * 3;
    const float grain =
        rough_noise(static_cast<float>(7 * along), static_cast<float>(7 * across), 3, 9);
    const auto light =
        static_cast<float>(0.3 + 0.75 * std::max(0.0, -0.45 * nx - 0.6 * ny - 0.66 * nz));
    const float shade = light * (0.6F + 0.7F * grain);
    if (static_cast<int>(sector) % 2 == 0)
      return {0.95F * shade, 0.93F * shade, 0.86F * shade};
    return {ball.colour[0] * shade, ball.colour[1] * shade, ball.colour[2] * shade};
  }
};

} // namespace film
