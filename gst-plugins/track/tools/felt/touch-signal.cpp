// SPDX-License-Identifier: LGPL-2.1-or-later
#include "felt/touch-signal.hpp"

#include "samples/motion-sample.hpp"
#include "samples/relief-sampler.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

SurfacePoint point_at(const ReliefField &relief, double x, double y) {
  ReliefSums sums;
  sums.add(relief, x, y, 1);
  return sums.point(kWorkspaceHalf);
}

// The slope between half a cell to each side, of the sides that exist; `dx` and `dy` are shares of
// the frame.
float slope(const ReliefField &relief, double x, double y, double dx, double dy) {
  const SurfacePoint here = point_at(relief, x, y);
  const SurfacePoint before = point_at(relief, x - dx, y - dy);
  const SurfacePoint after = point_at(relief, x + dx, y + dy);
  const double run = 2 * kWorkspaceHalf * (dx + dy) * (int{before.exists} + int{after.exists});
  const double rise = (after.exists ? after : here).height - (before.exists ? before : here).height;
  return static_cast<float>(run > 0 ? rise / run : 0);
}

constexpr auto surface_between = [](const FeltSurface &a, const FeltSurface &b, double share) {
  return interpolated(a, b, share);
};

} // namespace

FeltSurface felt_surface(const ReliefField &relief, double x, double y, std::uint64_t time) {
  const SurfacePoint point = point_at(relief, x, y);
  const double seconds = static_cast<double>(time) * 1e-9;
  const bool begins = (relief.flags & kMotionCut) != 0;
  if (!point.exists)
    return {.time = seconds, .begins = begins};
  return {seconds,
          true,
          begins,
          static_cast<float>(point.height),
          static_cast<float>(point.stiffness),
          slope(relief, x, y, 0.5 / relief.columns, 0),
          -slope(relief, x, y, 0, 0.5 / relief.rows)};
}

FeltSurface interpolated(const FeltSurface &a, const FeltSurface &b, double share) noexcept {
  const double time = std::lerp(a.time, b.time, share);
  FeltSurface between = share < 1 && (b.begins || share <= 0.5) ? a : b;
  if (!b.begins && a.exists && b.exists) {
    const auto s = static_cast<float>(share);
    for (float FeltSurface::*number : {&FeltSurface::height, &FeltSurface::stiffness,
                                       &FeltSurface::slope_x, &FeltSurface::slope_y})
      between.*number = std::lerp(a.*number, b.*number, s);
  }
  between.time = time;
  return between;
}

Force contact_force(const FeltSurface &surface, double z, double max_force) noexcept {
  const double depth = static_cast<double>(surface.height) - z;
  if (!surface.exists || !(depth > 0))
    return {};
  const double steepness =
      std::hypot(1.0, static_cast<double>(surface.slope_x), static_cast<double>(surface.slope_y));
  const double stiffness = std::min(static_cast<double>(surface.stiffness), kStiffestTouch);
  const auto share =
      static_cast<float>(std::min(stiffness * depth / steepness, max_force) / steepness);
  return {-share * surface.slope_x, -share * surface.slope_y, share};
}

std::vector<TimedForce> touch_along(const std::vector<TimedPlace> &path, const ReliefField *before,
                                    std::uint64_t time_before, const ReliefField &relief,
                                    std::uint64_t time, double max_force) {
  std::vector<TimedForce> forces;
  const double end = static_cast<double>(time) * 1e-9;
  const double begin = static_cast<double>(time_before) * 1e-9;
  const auto add = [&](const FeltSurface &surface, const PointerPosition &hand, double at) {
    forces.push_back({at, contact_force(surface, kWorkspaceHalf * hand.z, max_force)});
  };
  if (before && end - begin <= kLongestMotionGap)
    for (double at = begin + kPathStep; at < end - kPathStep / 2; at += kPathStep) {
      const PointerPosition hand = place_at(path, at);
      add(interpolated(felt_surface(*before, hand.x, hand.y, time_before),
                       felt_surface(relief, hand.x, hand.y, time), (at - begin) / (end - begin)),
          hand, at);
    }
  const PointerPosition hand = place_at(path, end);
  add(felt_surface(relief, hand.x, hand.y, time), hand, end);
  return forces;
}

ForceSignal height_signal(std::span<const FeltSurface> surfaces) {
  ForceSignal signal = silence(surfaces);
  double sum = 0;
  double count = 0;
  for (const FeltSurface &surface : surfaces)
    if (surface.exists) {
      sum += static_cast<double>(surface.height);
      ++count;
    }
  const double mean = sum / std::max(count, 1.0);
  KnotReader reader(surfaces, kLongestMotionGap);
  for (std::int64_t step = signal.first; step < signal.end(); ++step)
    if (const FeltSurface surface = reader.at(step, surface_between); surface.exists)
      signal.forces[static_cast<std::size_t>(step - signal.first)].z =
          static_cast<float>(kStiffestTouch * (static_cast<double>(surface.height) - mean));
  return signal;
}

SignalPair touch_signals(std::span<const FeltSurface> a, std::span<const FeltSurface> b,
                         double max_force, double shift) {
  SignalPair pair(silence(a), silence(b));
  auto &[first, second] = pair;
  const std::int64_t by = std::llround(shift / kForceStep);
  KnotReader a_reader(a, kLongestMotionGap);
  KnotReader b_reader(b, kLongestMotionGap);
  const std::int64_t begin = std::min(first.first, second.first - by);
  const std::int64_t end = std::max(first.end(), second.end() - by);
  for (std::int64_t step = begin; step < end; ++step) {
    const FeltSurface of_a = a_reader.at(step, surface_between);
    const FeltSurface of_b = b_reader.at(step + by, surface_between);
    const auto height_a = static_cast<double>((of_a.exists ? of_a : of_b).height);
    const auto height_b = static_cast<double>((of_b.exists ? of_b : of_a).height);
    const double hand = (height_a + height_b) / 2 - kTouchDepth;
    if (step >= first.first && step < first.end())
      first.forces[static_cast<std::size_t>(step - first.first)] =
          contact_force(of_a, hand, max_force);
    if (step + by >= second.first && step + by < second.end())
      second.forces[static_cast<std::size_t>(step + by - second.first)] =
          contact_force(of_b, hand, max_force);
  }
  return pair;
}

} // namespace haptic
