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

using Surfaces = std::span<const FeltSurface>;

// Returns a function that is called with rising steps and returns the surface there.
auto surface_reader(Surfaces surfaces) {
  return reader_of(surfaces, kLongestMotionGap,
                   [](const FeltSurface &a, const FeltSurface &b, double share) {
                     return interpolated(a, b, share);
                   });
}

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

ForceSignal height_signal(std::span<const FeltSurface> surfaces) {
  double sum = 0;
  double count = 0;
  for (const FeltSurface &surface : surfaces) {
    sum += static_cast<double>(surface.height);
    count += surface.exists;
  }
  const double mean = sum / std::max(count, 1.0);
  return signal_over(surfaces, [mean, at = surface_reader(surfaces)](std::int64_t step) mutable {
    const FeltSurface surface = at(step);
    const double height = static_cast<double>(surface.height) - mean;
    return Force{0, 0, surface.exists ? static_cast<float>(kStiffestTouch * height) : 0};
  });
}

SignalPair touch_signals(std::span<const FeltSurface> a, std::span<const FeltSurface> b,
                         double max_force, double shift) {
  const std::int64_t by = std::llround(shift / kForceStep);
  const auto touched = [&](Surfaces own, Surfaces other, std::int64_t later) {
    auto own_at = surface_reader(own);
    auto other_at = surface_reader(other);
    return signal_over(own, [&](std::int64_t step) {
      const FeltSurface here = own_at(step);
      const FeltSurface there = other_at(step + later);
      const auto height = static_cast<double>(here.height);
      const double mean = there.exists ? (height + static_cast<double>(there.height)) / 2 : height;
      return contact_force(here, mean - kTouchDepth, max_force);
    });
  };
  return {touched(a, b, by), touched(b, a, -by)};
}

} // namespace haptic
