// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion-scale.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kFastest = 1e6;     // px/s
constexpr double kFastestTurn = 1e4; // rad/s, and 1/s

} // namespace

Motion scale_motion(const MotionSample &sample, double reference_width) noexcept {
  const bool known = reference_width > 0 && sample.frame_width > 0;
  const double scale = known ? reference_width / sample.frame_width : 1;
  const double x = scale * sample.velocity_x;
  const double y = scale * sample.velocity_y * sample.pixel_aspect_d / sample.pixel_aspect_n;
  return {{x, y}, sample.spin, sample.divergence};
}

PlanarVelocity scale_hand(const spidar::Vector3 &velocity, const spidar::Vector3 &workspace_half,
                          const MotionSample &sample, double reference_width) noexcept {
  if (sample.frame_width == 0)
    return {};
  const double width = reference_width > 0 ? reference_width : sample.frame_width;
  const double height = width * sample.frame_height / sample.frame_width * sample.pixel_aspect_d /
                        sample.pixel_aspect_n;
  return {velocity.x() / (2 * workspace_half.x()) * width,
          -velocity.y() / (2 * workspace_half.y()) * height};
}

bool is_plausible(const MotionSample &sample) noexcept {
  // Written so that NaN fails.
  return std::hypot(sample.velocity_x, sample.velocity_y) <= kFastest &&
         std::abs(sample.spin) <= kFastestTurn && std::abs(sample.divergence) <= kFastestTurn;
}

bool is_plausible(const MotionField &field) noexcept {
  return std::ranges::all_of(field.cells, [](const FieldCell &cell) {
    return std::hypot(cell.velocity_x, cell.velocity_y) <= kFastest;
  });
}

} // namespace haptic
