// SPDX-License-Identifier: LGPL-2.1-or-later
// From the hand to the point in the frame (paper, equation 1), and when an event is sent.
#pragma once

#include "motion/held-path.hpp"
#include "samples/pointer-position.hpp"

#include <cstdint>
#include <optional>
#include <spidar/types.hpp>

namespace haptic {

/// Shift of the frame under the hand, in parts of its width and height, y down.
using FrameShift = FramePoint;

/// Equation 1 of the paper without the frame's size, with the hand at (X, Y, Z) and the half
/// extents (hX, hY, hZ): x = 0.5 + X / (2 hX), y = 0.5 - Y / (2 hY), z = Z / hZ. All in m.
/// Positions outside the workspace are clamped to its border.
/// `shift` is added to x and y.
PointerPosition map_pointer(const spidar::Vector3 &hand, const spidar::Vector3 &workspace_half,
                            const FrameShift &shift = {}) noexcept;

/// The inverse, for ways: from parts of the frame, y down, to m of the workspace. Real-time safe.
inline spidar::Vector3 map_way(const FramePoint &way,
                               const spidar::Vector3 &workspace_half) noexcept {
  return {2 * workspace_half.x() * way.x, -2 * workspace_half.y() * way.y, 0};
}

/// Moves the frame under a hand that points away from the centre, while it moves, so that a hand
/// that follows its point comes to rest nearer to the centre (docs/force.md#wash-out). One thread;
/// real-time safe.
class WashOut {
public:
  /// The shift moves by at most this share of what the hand moves.
  static constexpr double kMostDrift = 0.05;
  /// A hand that moves slower rests, and the shift rests with it.
  static constexpr double kResting = 0.1; // 1/s of the frame

  /// `velocity` in m/s, `dt` in s since the step before. `rate` in 1/s; at 0 the shift, if there is
  /// one, goes back to zero as slowly.
  void step(const spidar::Vector3 &hand, const spidar::Vector3 &velocity,
            const spidar::Vector3 &workspace_half, double rate, double dt) noexcept;
  const FrameShift &shift() const noexcept { return shift_; }
  /// Back to zero at once.
  void reset() noexcept { shift_ = {}; }

private:
  FrameShift shift_;
};

/// Passes a position that differs from the last passed one by more than 0.001, or its force by more
/// than 0.01 N, or its proxy by more than 0.001 or 0.1 mm of depth; where a press or a touch begins
/// or ends; and any position 200 ms after the last passed one.
class PointerGate {
public:
  /// Returns whether the position passes. `now` in ns of any steady clock.
  bool pass(const PointerPosition &position, std::int64_t now) noexcept;

private:
  std::optional<PointerPosition> last_;
  std::int64_t last_time_ = 0;
};

} // namespace haptic
