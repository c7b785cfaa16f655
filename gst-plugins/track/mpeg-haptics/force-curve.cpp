// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/force-curve.hpp"

#include "core/track-time.hpp"
#include "samples/force-defaults.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace haptic {
namespace {

constexpr std::size_t kMostWork = 10'000'000; // evaluations, a second or so
constexpr std::size_t kMostFilled = 65'536;   // samples between points in one call, 55 minutes
constexpr std::int64_t kMostParts = 65536;
constexpr double kLargestValue = 1e6;
constexpr double kLatestTime = 4e18;   // ns
constexpr double kFilling = 20;        // samples/s
constexpr double kFinestFilling = 200; // samples/s, where the force is cut
constexpr double kStrongest = 0.98;    // above this a step of the amplitude is thousands of px/s

double value_between(const ChannelCurve::Point &from, const ChannelCurve::Point &to,
                     std::int64_t tick) {
  if (from.tick == to.tick)
    return to.value;
  return std::lerp(from.value, to.value,
                   static_cast<double>(tick - from.tick) /
                       static_cast<double>(to.tick - from.tick));
}

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
  return value_between(*(after - 1), *after, tick);
}

using Span = std::pair<std::int64_t, std::int64_t>; // ticks, [begin, end)

// The times in [begin, end) that the curves cover, joined where they overlap or touch.
std::vector<Span> stretches_of(std::span<const ChannelCurve> curves, std::int64_t begin,
                               std::int64_t end) {
  std::vector<Span> stretches;
  for (const auto &curve : curves) {
    const std::int64_t from = std::max(curve.points.front().tick, begin);
    const std::int64_t until = std::min(curve.points.back().tick + 1, end);
    if (from >= until)
      continue;
    if (stretches.empty() || from > stretches.back().second)
      stretches.emplace_back(from, until);
    else
      stretches.back().second = std::max(stretches.back().second, until);
  }
  return stretches;
}

} // namespace

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

bool begins_before(const ChannelCurve &a, const ChannelCurve &b) noexcept {
  return a.points.front().tick < b.points.front().tick;
}

void scale_values(ChannelCurve &curve, double factor) noexcept {
  for (auto &point : curve.points)
    point.value = std::clamp(point.value * factor, -kLargestValue, kLargestValue);
  curve.code_step *= std::abs(factor);
}

bool touches(const ChannelCurve &curve, std::int64_t tick) noexcept {
  const std::int64_t last = curve.drawing.last(curve.points.back().tick);
  return curve.points.front().tick < tick && (last == tick || last == tick - 1);
}

void join(ChannelCurve &curve, std::span<const ChannelCurve::Point> effect) {
  auto &points = curve.points;
  const ChannelCurve::Point first = effect.front();
  if (points.size() > 1) {
    const ChannelCurve::Point last = points.back();
    points.pop_back();
    const ChannelCurve::Point &before = points.back();
    const double at_last = value_between(before, first, std::min(last.tick, first.tick));
    if (std::abs(last.value - at_last) > curve.code_step) { // a step
      const std::int64_t end = std::max(first.tick - 1, before.tick);
      points.push_back({end, value_between(before, last, end)});
    }
  } else if (points.back().tick == first.tick) {
    points.pop_back();
  }
  points.insert(points.end(), effect.begin(), effect.end());
}

std::uint64_t TickClock::ns_at(std::int64_t at) const noexcept {
  const auto ns_of = [&](std::int64_t ticks) {
    return std::llround(std::min(
        static_cast<double>(ticks) / timescale * static_cast<double>(kSecond), kLatestTime));
  };
  const std::int64_t since = ns_of(at) - ns_of(tick);
  if (since < 0 && static_cast<std::uint64_t>(-since) > ns)
    return 0;
  return ns + static_cast<std::uint64_t>(since);
}

// Returns false if there are more than kMostForcePoints, or if the sum would take seconds.
bool ForceSampler::sum(std::span<const ChannelCurve> curves, std::int64_t begin, std::int64_t end,
                       std::vector<ForcePoint> &points) {
  std::vector<std::int64_t> ticks;
  const auto add = [&](std::int64_t tick) {
    if (tick >= begin && tick < end)
      ticks.push_back(tick);
  };
  for (const auto &curve : curves) {
    if (ticks.size() > 2 * kMostForcePoints)
      return false;
    for (const auto &point : curve.points)
      add(point.tick);
    if (curve.points.front().value != 0) // the sum steps there
      add(curve.points.front().tick - 1);
    if (curve.points.back().value != 0)
      add(curve.points.back().tick + 1);
  }
  std::sort(ticks.begin(), ticks.end());
  ticks.erase(std::unique(ticks.begin(), ticks.end()), ticks.end());
  if (ticks.size() > kMostForcePoints)
    return false;
  points.clear();
  for (const auto tick : ticks)
    points.push_back({tick, {}});
  std::size_t work = 0;
  for (const auto &curve : curves) {
    // Only the ticks that the curve covers: many short curves must not cost their product.
    auto at = std::lower_bound(
        points.begin(), points.end(), curve.points.front().tick,
        [](const ForcePoint &point, std::int64_t tick) { return point.tick < tick; });
    for (; at != points.end() && at->tick <= curve.points.back().tick; ++at) {
      if (++work > kMostWork)
        return false;
      const double value = value_at(curve, at->tick);
      at->force.x += value * curve.direction[0];
      at->force.y += value * curve.direction[1];
    }
  }
  return true;
}

// Appends the points with others between them, `room` at most. The sum is linear between points.
void ForceSampler::append_filled(const std::vector<ForcePoint> &points, const TickClock &clock,
                                 std::size_t &room, std::vector<ForcePoint> &filled) {
  const auto is_cut = [](const ForcePoint &point) {
    return std::hypot(point.force.x, point.force.y) > kStrongest;
  };
  for (const auto &point : points) {
    if (before_) {
      // Where the force is cut the line has a corner.
      const double rate = is_cut(*before_) != is_cut(point) ? kFinestFilling : kFilling;
      const std::int64_t gap = point.tick - before_->tick;
      const auto parts = static_cast<std::int64_t>(
          std::ceil(std::min(static_cast<double>(gap) / clock.timescale * rate,
                             static_cast<double>(std::min<std::int64_t>(gap, kMostParts)))));
      for (std::int64_t i = 1; i < parts && room > 0; ++i, --room) {
        const std::int64_t tick = before_->tick + gap * i / parts;
        const double part = static_cast<double>(tick - before_->tick) / static_cast<double>(gap);
        filled.push_back({tick,
                          {std::lerp(before_->force.x, point.force.x, part),
                           std::lerp(before_->force.y, point.force.y, part)}});
      }
    }
    filled.push_back(point);
    before_ = point;
  }
}

// Returns whether the last point repeats the force of the one before. A sample holds until the
// silence.
bool ForceSampler::ends_flat(std::span<const ForcePoint> points) const {
  const ForcePoint *before = points.size() > 1 ? &points[points.size() - 2]
                             : before_         ? &*before_
                                               : nullptr;
  return before && !points.empty() && points.back().force == before->force;
}

void ForceSampler::append_felt(const std::vector<ForcePoint> &points, std::int64_t end,
                               const TickClock &clock, std::vector<TrackSample> &samples) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    TrackSample sample;
    sample.motion = motion_of_force(points[i].force);
    sample.time = clock.ns_at(points[i].tick);
    sample.duration = clock.ns_at(i + 1 < points.size() ? points[i + 1].tick : end) - sample.time;
    const bool follows = last_ != kNoTime && last_ < sample.time;
    sample.motion.interval =
        std::min(follows ? sample.time - last_ : sample.duration, kUsualInterval * 3);
    last_ = sample.time;
    samples.push_back(sample);
  }
}

const char *ForceSampler::append(std::span<const ChannelCurve> curves, std::int64_t begin,
                                 std::int64_t end, const TickClock &clock,
                                 std::vector<TrackSample> &samples) {
  std::vector<ForcePoint> points;
  std::vector<ForcePoint> filled;
  const auto append_silence = [&](std::int64_t from, std::int64_t until) {
    const std::uint64_t time = clock.ns_at(from);
    samples.push_back(silent_sample(time, clock.ns_at(until) - time));
    restart();
  };
  std::size_t used = 0;
  std::size_t room = kMostFilled;
  for (const auto &[from, until] : stretches_of(curves, begin, end)) {
    if (from > begin)
      append_silence(begin, from);
    const std::size_t first = used;
    while (used < curves.size() && curves[used].points.front().tick < until)
      ++used;
    // Stretch by stretch, since only so many points are summed at once.
    if (!sum(curves.subspan(first, used - first), from, until, points))
      return "too many keyframes in one stretch";
    const bool is_flat = until < end && ends_flat(points);
    filled.clear();
    append_filled(points, clock, room, filled);
    if (is_flat)
      filled.pop_back();
    append_felt(filled, until, clock, samples);
    begin = until;
  }
  if (begin < end)
    append_silence(begin, end);
  return nullptr;
}

} // namespace haptic
