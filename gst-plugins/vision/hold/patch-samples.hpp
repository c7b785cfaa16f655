// SPDX-License-Identifier: LGPL-2.1-or-later
// A square of samples about a thing, and the pose at which it is sampled.
#pragma once

#include <array>

namespace haptic {

inline constexpr int kPatchRadius = 10; ///< samples on each side of the middle one
inline constexpr int kPatchSide = 2 * kPatchRadius + 1;
inline constexpr int kPatchSamples = kPatchSide * kPatchSide;
inline constexpr int kPatchRoom = 448; ///< whole vectors; the rest is 0

/// Row after row.
struct alignas(64) PatchSamples {
  std::array<float, kPatchRoom> values{};

  float &operator[](int at) { return values[static_cast<std::size_t>(at)]; }
  float operator[](int at) const { return values[static_cast<std::size_t>(at)]; }
  float *data() { return values.data(); }
  const float *data() const { return values.data(); }
};

/// Grey levels with their gradients by row and column, per sample.
struct PatchTemplate {
  PatchSamples grey;
  PatchSamples gradient_x;
  PatchSamples gradient_y;
};

/// Where sample (u, v) of a patch lies: (a b; c d) (u, v) spacing + (x, y), px.
struct PatchPose {
  float a = 1, b = 0, c = 0, d = 1;
  float x = 0, y = 0;

  float area() const { return a * d - b * c; }
};

} // namespace haptic
