// SPDX-License-Identifier: LGPL-2.1-or-later
#include "force-curve.hpp"

#include "force-defaults.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace haptic {
namespace {

constexpr std::size_t kMostWork = 10'000'000; // evaluations, a second or so
constexpr double kStrongest = 0.98; // above this a step of the amplitude is thousands of px/s

double value_at(const ChannelCurve &curve, std::int64_t tick) {
  const auto &points = curve.points;
  const auto after = std::lower_bound(
      points.begin(), points.end(), tick,
      [](const ChannelCurve::Point &point, std::int64_t t) { return point.tick < t; });
  if (after == points.end())
    return 0;
  if (after->tick == tick)
    return after->value;
  if (after == points.begin())
    return 0;
  const auto before = after - 1;
  const double part =
      static_cast<double>(tick - before->tick) / static_cast<double>(after->tick - before->tick);
  return before->value + part * (after->value - before->value);
}

} // namespace

bool is_felt(const MotionSample &sample) noexcept {
  return confidence_gate(sample.confidence) > 0;
}

CurveForce force_of_motion(const MotionSample &s) noexcept {
  const double scale = kReferenceWidth / s.frame_width;
  const double x = scale * s.velocity_x;
  const double y = scale * s.velocity_y * s.pixel_aspect_d / s.pixel_aspect_n;
  const double speed = std::hypot(x, y);
  if (!(speed > 0) || !std::isfinite(speed))
    return {};
  const double gain = arctan_gain(speed, kDefaultAlpha, 1) * confidence_gate(s.confidence);
  return {gain * x, -gain * y};
}

MotionSample motion_of_force(CurveForce force) noexcept {
  MotionSample s;
  s.frame_width = static_cast<std::uint32_t>(kReferenceWidth);
  s.frame_height = static_cast<std::uint32_t>(kReferenceHeight);
  s.confidence = 1;
  s.points = 1;
  s.model = MotionModel::still;
  const double length = std::hypot(force.x, force.y);
  if (!(length > 0) || !std::isfinite(length))
    return s;
  const double speed =
      std::tan(std::numbers::pi / 2 * std::min(length, kStrongest)) / kDefaultAlpha;
  s.velocity_x = static_cast<float>(speed * force.x / length);
  s.velocity_y = static_cast<float>(-speed * force.y / length);
  s.model = MotionModel::translation;
  return s;
}

TrackSample silent_sample(std::uint64_t time, std::uint64_t duration) noexcept {
  TrackSample sample;
  sample.motion = motion_of_force({});
  sample.motion.confidence = 0;
  sample.motion.points = 0;
  sample.motion.model = MotionModel::none;
  sample.time = time;
  sample.duration = duration;
  return sample;
}

std::vector<ForcePoint> sum_curves(std::span<const ChannelCurve> curves, std::int64_t begin,
                                   std::int64_t end) {
  std::vector<std::int64_t> ticks;
  for (const auto &curve : curves)
    for (const auto &point : curve.points)
      if (point.tick >= begin && point.tick < end) {
        if (ticks.size() >= 2 * kMostForcePoints)
          return {};
        ticks.push_back(point.tick);
      }
  std::sort(ticks.begin(), ticks.end());
  ticks.erase(std::unique(ticks.begin(), ticks.end()), ticks.end());
  if (ticks.size() > kMostForcePoints)
    return {};
  std::vector<ForcePoint> sum;
  sum.resize(ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i)
    sum[i].tick = ticks[i];
  std::size_t work = 0;
  for (const auto &curve : curves) {
    if (curve.points.empty())
      continue;
    // Only the ticks that the curve covers: many short curves must not cost their product.
    auto at = std::lower_bound(
        sum.begin(), sum.end(), curve.points.front().tick,
        [](const ForcePoint &point, std::int64_t tick) { return point.tick < tick; });
    for (; at != sum.end() && at->tick <= curve.points.back().tick; ++at) {
      if (++work > kMostWork)
        return {};
      const double value = value_at(curve, at->tick);
      at->force.x += value * curve.direction[0];
      at->force.y += value * curve.direction[1];
    }
  }
  return sum;
}

} // namespace haptic
