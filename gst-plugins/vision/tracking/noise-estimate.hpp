// SPDX-License-Identifier: LGPL-2.1-or-later
// How noisy the camera is, learned from what does not move.
#pragma once

#include <algorithm>

namespace haptic {

/// Standard deviation of the noise that a camera's frame is assumed to have, 8-bit grey levels.
inline constexpr float kAssumedNoise = 1.5F;
inline constexpr float kAssumedVariance = kAssumedNoise * kAssumedNoise;
/// Least variance of a pixel: rounding to 8 bits, with a margin for averages, which are rounded
/// too.
inline constexpr float kRoundingVariance = 0.25F;

/// Variance of a pixel that a frame is assumed to have after so many reductions. Averaging 2x2
/// pixels quarters the variance of the noise, but each result is rounded again.
inline float assumed_variance(int reductions) {
  return std::max(kRoundingVariance, kAssumedVariance / static_cast<float>(1 << (2 * reductions)));
}

/// Variance of the noise of a pixel, grey levels squared.
class NoiseEstimate {
public:
  /// `rate`: weight of the newest observation, 0..1.
  explicit NoiseEstimate(float rate) : rate_(rate) {}

  /// Starts anew at `start`; the estimate never falls below `least`.
  void reset(float start, float least) {
    variance_ = start;
    least_ = least;
  }

  /// `energy`: mean squared difference between two frames of a scene at rest. Both frames are
  /// noisy, so it is twice the variance.
  void learn(float energy) {
    constexpr float kMost = 150; // beyond this, something other than noise changed
    variance_ += rate_ * (std::clamp(energy / 2, least_, kMost) - variance_);
  }

  float variance() const { return variance_; }

private:
  float rate_;
  float variance_ = kAssumedVariance;
  float least_ = kRoundingVariance;
};

} // namespace haptic
