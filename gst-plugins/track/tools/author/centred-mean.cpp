// SPDX-License-Identifier: LGPL-2.1-or-later
#include "author/centred-mean.hpp"

#include <algorithm>

namespace haptic {

void take_centred_mean(const MotionField &before, MotionField &now, const MotionField &after) {
  constexpr float kFull = 1.0F / 60; // s
  constexpr float kMost = 0.25F;
  const auto is_like = [&now](const MotionField &other) {
    return other.flags == 0 && other.columns == now.columns && other.rows == now.rows &&
           other.frame_width == now.frame_width && other.frame_height == now.frame_height;
  };
  if (now.flags != 0 || !is_like(before) || !is_like(after))
    return;
  const float seconds = std::max(1e-9F * static_cast<float>(now.interval), kFull);
  const float weight = kMost * (kFull / seconds) * (kFull / seconds);
  for (std::size_t i = 0; i < now.cells.size(); ++i) {
    FieldCell &cell = now.cells[i];
    if (!(cell.confidence > 0))
      continue;
    const FieldCell own = cell;
    for (const MotionField *other : {&before, &after})
      if (const FieldCell &there = other->cells[i]; there.confidence > 0) {
        cell.velocity_x += weight * (there.velocity_x - own.velocity_x);
        cell.velocity_y += weight * (there.velocity_y - own.velocity_y);
      }
  }
}

} // namespace haptic
