// SPDX-License-Identifier: LGPL-2.1-or-later
// Counts what happened to the frames of one run.
#pragma once

#include "tracking/region-tracker.hpp"

#include <chrono>
#include <cstdint>

namespace haptic {

/// Not thread-safe: the owner locks.
struct TrackingStatistics {
  std::uint64_t frames = 0;
  std::uint64_t measured = 0; ///< with one patch or more
  std::uint64_t still = 0;
  std::uint64_t duplicates = 0;
  std::uint64_t discontinuities = 0;
  std::uint64_t points = 0;
  std::uint64_t timed = 0; ///< frames for which the tracker ran
  std::chrono::nanoseconds time{0};

  void add(const Finding &finding, int patches) {
    ++frames;
    still += (finding.flags & kMotionStill) != 0;
    duplicates += (finding.flags & kMotionDuplicate) != 0;
    discontinuities += (finding.flags & kMotionDiscontinuity) != 0;
    measured += patches > 0;
    points += static_cast<std::uint64_t>(patches);
    if (finding.time) {
      ++timed;
      time += *finding.time;
    }
  }

  /// Per frame that was measured; 0: none was.
  double mean_points() const { return mean(static_cast<double>(points), measured); }

  /// Microseconds from two frames to patches, for the frames for which the tracker ran; 0: it never
  /// did.
  double mean_time() const {
    return mean(std::chrono::duration<double, std::micro>(time).count(), timed);
  }

private:
  static double mean(double sum, std::uint64_t count) {
    return count > 0 ? sum / static_cast<double>(count) : 0;
  }
};

} // namespace haptic
