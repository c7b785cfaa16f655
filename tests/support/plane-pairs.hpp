// SPDX-License-Identifier: LGPL-2.1-or-later
// Two smoothed frames of things that move side by side, and what stands beside the rows of a plane.
#pragma once

#include "field-frames.hpp"
#include "moving-texture.hpp"
#include "pixels/image-kernels.hpp"

#include <algorithm>
#include <random>

namespace test {

/// Frames of `side` px, with noise: the left texture up to `border`, the right one from there on.
inline void smooth_things(unsigned seed, int side, int border, const Shift &left,
                          const Shift &right, haptic::Plane &earlier, haptic::Plane &later) {
  std::mt19937 random(seed);
  const auto frame_at = [&](double time) {
    Frame frame = Texture(seed, 4, 50).frame(side, side, {left.x * time, left.y * time});
    Texture(seed + 100, 4, 50).paint(frame, {right.x * time, right.y * time}, border);
    add_noise(frame, 1.5, random);
    return frame;
  };
  haptic::smooth(view_of(frame_at(0)), earlier);
  haptic::smooth(view_of(frame_at(1)), later);
}

/// Fills what stands beside the rows of a plane, and below them.
inline void pad(haptic::Plane &plane, float value) {
  for (int y = 0; y < plane.height() + 2; ++y)
    std::fill(plane.row(y) + (y < plane.height() ? plane.width() : 0),
              plane.row(y) + plane.stride(), value);
}

} // namespace test
