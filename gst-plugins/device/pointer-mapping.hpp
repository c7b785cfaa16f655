// SPDX-License-Identifier: LGPL-2.1-or-later
// From the hand to the point in the frame (paper, equation 1), and when that is worth telling.
#pragma once

#include "pointer-position.hpp"

#include <cstdint>
#include <optional>
#include <spidar/types.hpp>

namespace haptic {

/// Equation 1 without the frame's size, which only its reader knows: x, y and z of the result are
/// those of the pointer event. `hand` and `workspace_half` in m. Positions outside the workspace
/// are taken to its border.
PointerPosition map_pointer(const spidar::Vector3 &hand,
                            const spidar::Vector3 &workspace_half) noexcept;

/// Lets a position through when it differs by more than 0.001, or its force by more than 0.01 N,
/// from the last one let through, or when that was 200 ms ago.
class PointerGate {
public:
  /// `now` in ns of any steady clock.
  bool pass(const PointerPosition &position, std::int64_t now) noexcept;

private:
  std::optional<PointerPosition> last_;
  std::int64_t last_time_ = 0;
};

} // namespace haptic
