// SPDX-License-Identifier: LGPL-2.1-or-later
// Film in video: 24 frames a second carried in 30 repeat every fourth one, so that an even motion
// is measured unevenly, six times a second.
#pragma once

#include "samples/motion-sample.hpp"

#include <array>
#include <cstddef>

namespace haptic {

/// Finds the pattern in which frames are repeated, and corrects motions that were measured too fast
/// because their frame was shown too soon. Not thread-safe.
class Cadence {
public:
  /// Call for every sample in order. Returns the factor for the velocity: the measured interval
  /// divided by the mean interval of the pattern, or 1 if no pattern is known.
  double correction(const MotionSample &sample) noexcept;
  void restart() noexcept;

private:
  struct Interval {
    double seconds = 0;
    bool repeated = false; ///< a frame was shown again within it
  };

  // 24 frames in 25; each pattern has to occur twice.
  static constexpr std::size_t kLongest = 24;
  static constexpr std::size_t kMemory = 2 * kLongest;

  const Interval &interval(std::size_t ago) const noexcept {
    return intervals_[(newest_ + kMemory - ago) % kMemory];
  }
  double mean_of_pattern(std::size_t period) const noexcept;

  std::array<Interval, kMemory> intervals_{}; // ring
  std::size_t newest_ = 0;
  std::size_t count_ = 0;
  bool repeated_ = false; // since the newest interval
};

} // namespace haptic
