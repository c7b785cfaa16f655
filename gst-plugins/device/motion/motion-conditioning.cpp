// SPDX-License-Identifier: LGPL-2.1-or-later
#include "motion/motion-conditioning.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptic {
namespace {

constexpr double kFastestTurn = 1e4; // rad/s, and 1/s
constexpr double kRelease = 0.1;     // s, time constant of the deadband

// s(v) = 0 for v <= still, 1 for v >= moving, moving / (moving - still) * (v - still) / v between,
// so that s(v) v is continuous.
double share_kept(double speed) noexcept {
  if (speed <= kStillSpeed)
    return 0;
  if (speed >= kMovingSpeed)
    return 1;
  return kMovingSpeed / (kMovingSpeed - kStillSpeed) * (speed - kStillSpeed) / speed;
}

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

// The comparisons of both are written so that NaN fails.
bool is_plausible(const MotionSample &sample) noexcept {
  return std::hypot(sample.velocity_x, sample.velocity_y) <= kFastestMotion &&
         std::abs(sample.spin) <= kFastestTurn && std::abs(sample.divergence) <= kFastestTurn;
}

bool is_plausible(const MotionField &field) noexcept {
  return std::ranges::all_of(field.cells, [](const FieldCell &cell) {
    return std::hypot(cell.velocity_x, cell.velocity_y) <= kFastestMotion;
  });
}

// Low-pass of first order: y += (1 - exp(-2 pi cutoff dt)) (x - y).
const Motion &MotionConditioner::step(const Motion &scaled, double cutoff, double dt) noexcept {
  const double speed = std::hypot(scaled.velocity.x, scaled.velocity.y);
  fastest_ = std::max(fastest_ * std::exp(-dt / kRelease), speed);
  const double keep = share_kept(fastest_);
  Motion target = scaled;
  target.velocity = {keep * scaled.velocity.x, keep * scaled.velocity.y};

  const bool low_pass = cutoff > 0 && begun_; // false for NaN
  begun_ = true;
  if (!low_pass) {
    output_ = target;
    return output_;
  }
  const double share = 1 - std::exp(-2 * std::numbers::pi * cutoff * dt);
  const auto follow = [share](double &value, double to) { value += share * (to - value); };
  follow(output_.velocity.x, target.velocity.x);
  follow(output_.velocity.y, target.velocity.y);
  follow(output_.spin, target.spin);
  follow(output_.divergence, target.divergence);
  return output_;
}

void MotionConditioner::restart_low_pass() noexcept {
  output_ = {};
  begun_ = false;
}

} // namespace haptic
