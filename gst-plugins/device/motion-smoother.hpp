// SPDX-License-Identifier: LGPL-2.1-or-later
// An optional low-pass for noisy frames, after the interpolation.
#pragma once

#include "motion-scale.hpp"

#include <cmath>
#include <numbers>

namespace haptic {

/// First order. One thread; real-time safe.
class MotionSmoother {
public:
  /// `cutoff` in Hz, 0: off; `dt` in s.
  const Motion &step(const Motion &motion, double cutoff, double dt) noexcept {
    // Written so that NaN is off.
    const double share =
        cutoff > 0 && begun_ ? 1 - std::exp(-2 * std::numbers::pi * cutoff * dt) : 1;
    const auto follow = [share](double &value, double target) {
      value += share * (target - value);
    };
    follow(smoothed_.velocity.x, motion.velocity.x);
    follow(smoothed_.velocity.y, motion.velocity.y);
    follow(smoothed_.spin, motion.spin);
    follow(smoothed_.divergence, motion.divergence);
    begun_ = true;
    return smoothed_;
  }

  /// The next motion stands for itself.
  void forget() noexcept {
    smoothed_ = {};
    begun_ = false;
  }

private:
  Motion smoothed_;
  bool begun_ = false;
};

} // namespace haptic
