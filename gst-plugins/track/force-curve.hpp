// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion samples as the force that MPEG haptics holds, to the right and up, and back.
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

/// Returns the force of a motion by the paper's law (equation 5) with kDefaultAlpha, in a frame
/// kReferenceWidth wide, times confidence_gate() (force-defaults.hpp).
CurveForce force_of_motion(const MotionSample &sample) noexcept;

/// Returns whether confidence_gate() lets anything through.
bool is_felt(const MotionSample &sample) noexcept;

/// Returns a motion that gives this force: equation 5 inverted, v = tan(pi/2 F) / alpha. Forces of
/// 0.98 and more give one speed.
MotionSample motion_of_force(CurveForce force) noexcept;

/// Returns a sample in which nothing was measured.
TrackSample silent_sample(std::uint64_t time, std::uint64_t duration) noexcept;

/// One effect of one channel: a force along its direction.
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

/// Returns the sum of the curves at each of their points in [begin, end); they are linear in
/// between. Returns nothing if there are more than kMostForcePoints, or if the sum would take
/// seconds.
std::vector<ForcePoint> sum_curves(std::span<const ChannelCurve> curves, std::int64_t begin,
                                   std::int64_t end);
inline constexpr std::size_t kMostForcePoints = 65536;

} // namespace haptic
