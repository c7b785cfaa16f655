// SPDX-License-Identifier: LGPL-2.1-or-later
// Between motion samples and what MPEG haptics knows: two curves of force, to the right and up.
#pragma once

#include "track-sample.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace haptic {

struct CurveForce {
  double x = 0; ///< fraction of the full force, to the right
  double y = 0; ///< up
};

/// The force of a motion under the paper's law at its defaults: 2/pi atan(0.01 s/px v) of a frame
/// 352 px wide, times the share that its confidence lets through.
CurveForce force_of_motion(const MotionSample &sample) noexcept;

/// Whether that share is more than nothing.
bool is_felt(const MotionSample &sample) noexcept;

/// A motion that gives this force; lengths of 0.98 and more are one speed.
MotionSample motion_of_force(CurveForce force) noexcept;

/// Returns a sample in which nothing was measured.
TrackSample silent_sample(std::uint64_t time, std::uint64_t duration) noexcept;

/// One effect of one channel: what it adds to the force along its direction.
struct ChannelCurve {
  struct Point {
    std::int64_t tick = 0;
    double value = 0; ///< fraction of the full force
  };
  std::array<double, 2> direction = {}; ///< right, up; of length 1 or less
  std::vector<Point> points;            ///< in the order of time
};

struct ForcePoint {
  std::int64_t tick = 0;
  CurveForce force;
};

/// The sum of the curves at each of their points in [begin, end), linear in between. Nothing when
/// there are more than kMostForcePoints, or so many curves at once that they cannot be meant.
std::vector<ForcePoint> sum_curves(std::span<const ChannelCurve> curves, std::int64_t begin,
                                   std::int64_t end);
inline constexpr std::size_t kMostForcePoints = 65536;

} // namespace haptic
