// SPDX-License-Identifier: LGPL-2.1-or-later
// From the hand to the point in the frame (paper, equation 1), and when an event is sent.
#pragma once

#include "pointer-position.hpp"

#include <cstdint>
#include <optional>
#include <spidar/types.hpp>

namespace haptic {

/// Equation 1 of the paper without the frame's size, with the hand at (X, Y, Z) and the half
/// extents (hX, hY, hZ): x = 0.5 + X / (2 hX), y = 0.5 - Y / (2 hY), z = Z / hZ. All in m.
/// Positions outside the workspace are clamped to its border.
PointerPosition map_pointer(const spidar::Vector3 &hand,
                            const spidar::Vector3 &workspace_half) noexcept;

/// Passes a position that differs from the last passed one by more than 0.001, or its force by more
/// than 0.01 N; and any position 200 ms after the last passed one.
class PointerGate {
public:
  /// Returns whether the position passes. `now` in ns of any steady clock.
  bool pass(const PointerPosition &position, std::int64_t now) noexcept;

private:
  std::optional<PointerPosition> last_;
  std::int64_t last_time_ = 0;
};

} // namespace haptic
