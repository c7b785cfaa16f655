#include "motion-scale.hpp"

#include <cmath>

namespace haptic {
namespace {

constexpr double kFastest = 1e6; // px/s

double deadband(double speed) {
  if (speed <= kStillSpeed)
    return 0;
  if (speed >= kMovingSpeed)
    return 1;
  return kMovingSpeed / (kMovingSpeed - kStillSpeed) * (speed - kStillSpeed) / speed;
}

} // namespace

Motion scale_motion(const MotionSample &sample, double reference_width) noexcept {
  const bool known = reference_width > 0 && sample.picture_width > 0;
  const double scale = known ? reference_width / sample.picture_width : 1;
  const double x = scale * sample.velocity_x;
  const double y = scale * sample.velocity_y * sample.pixel_aspect_d / sample.pixel_aspect_n;
  const double keep = deadband(std::hypot(x, y));
  return {keep * x, keep * y};
}

bool is_plausible(const MotionSample &sample) noexcept {
  // Written so that NaN fails.
  return std::hypot(sample.velocity_x, sample.velocity_y) <= kFastest;
}

} // namespace haptic
