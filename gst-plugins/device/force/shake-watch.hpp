// SPDX-License-Identifier: LGPL-2.1-or-later
// Notices that a law shakes the hand. docs/force.md#a-watch-for-shaking gives the reasons.
#pragma once

#include "non-blocking.hpp"

#include <cmath>
#include <numbers>
#include <spidar/types.hpp>

namespace haptic {

/// A law that follows the hand gives at most b N for each m/s of the hand (most_resistance()), so
/// over any time F_rms <= b v_rms, whatever hand and film do. A loop that shakes has much force and
/// little motion. One thread; real-time safe.
class ShakeWatch {
public:
  /// Times what a force may follow the hand's speed by: of the force between kLowest and kHighest
  /// over the motion, both rms over about 0.5 s.
  static constexpr double kOfResistance = 2;
  static constexpr double kFelt = 0.03; // N rms; less is calm
  static constexpr double kLowest = 3;  // Hz
  static constexpr double kHighest = 40;

  /// Returns the share of the hand's part that may be felt: 1, or 1/2 while it shakes. `of_hand`:
  /// N, that part as the law gives it. `velocity`: m/s, of the hand. `resistance`: N·s/m, the most
  /// by which a force may follow the hand's speed. `dt`: s since the step before.
  double step(const spidar::Vector3 &of_hand, const spidar::Vector3 &velocity, double resistance,
              double dt) noexcept HAPTIC_NONBLOCKING {
    if (!of_hand.allFinite() || !velocity.allFinite()) // gives no force
      return share_;
    const spidar::Vector3 felt = share_ * of_hand;
    slow_ += share(kLowest, dt) * (felt - slow_);
    fast_ += share(kHighest, dt) * (felt - slow_ - fast_);
    const double of_now = 1 - std::exp(-dt / kAveraged);
    force_ += of_now * (fast_.squaredNorm() - force_);
    motion_ += of_now * (velocity.squaredNorm() - motion_);
    const double most = kOfResistance * resistance;
    if (force_ > kFelt * kFelt && force_ > most * most * motion_) {
      shaken_for_ += dt;
      calm_for_ = 0;
      share_ = 0.5;
    } else {
      shaken_for_ = 0;
      calm_for_ += dt;
      if (calm_for_ > kCalm)
        share_ = 1;
    }
    return share_;
  }

  /// Half of it shakes still: nothing that follows the hand is safe.
  bool stops() const noexcept { return shaken_for_ > kPatience; }

private:
  static constexpr double kAveraged = 0.25; // s, time constant
  static constexpr double kPatience = 0.25; // s
  static constexpr double kCalm = 1;        // s

  static double share(double cutoff, double dt) noexcept {
    return 1 - std::exp(-2 * std::numbers::pi * cutoff * dt);
  }

  double share_ = 1;
  spidar::Vector3 slow_ = spidar::Vector3::Zero(); // N, below kLowest
  spidar::Vector3 fast_ = spidar::Vector3::Zero(); // N, above it, low-passed
  double force_ = 0;                               // N²
  double motion_ = 0;                              // m²/s²
  double shaken_for_ = 0;                          // s
  double calm_for_ = 0;                            // s
};

} // namespace haptic
