// SPDX-License-Identifier: LGPL-2.1-or-later
// Film in video: 24 frames a second carried in 30 repeat every fourth one, and what moves evenly
// then seems to move by fits and starts, six times a second.
#pragma once

#include "motion-sample.hpp"

#include <array>
#include <cstddef>

namespace haptic {

/// Finds the pattern in which frames are repeated, and tells how much too fast a motion was
/// measured because its frame was shown too soon. Not thread-safe.
class Cadence {
public:
  /// For every sample in order: the interval it was measured over divided by the one that its
  /// frame stands for. Multiply the velocity with it. 1 while no pattern is known.
  double correction(const MotionSample &sample) noexcept;
  void forget() noexcept;

private:
  struct Interval {
    double seconds = 0;
    bool repeated = false; ///< a frame was shown again within it
  };

  // 24 frames in 25; and each pattern is to be seen twice.
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
