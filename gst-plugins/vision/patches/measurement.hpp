// SPDX-License-Identifier: LGPL-2.1-or-later
// What a tracker finds: patches with their displacement.
#pragma once

#include "haptic-patch.h"
#include "samples/motion-sample.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace haptic {

using Patch = GstHapticPatch;

inline constexpr int kMaxPatches = GST_HAPTIC_MOTION_META_MAX_PATCHES;

/// What a tracker says of all patches.
inline constexpr std::uint16_t kStill = kMotionStill; ///< the displacement is exactly zero
inline constexpr std::uint16_t kCut = kMotionCut;     ///< the frames do not show the same scene
/// The patches cover the region, each with the mean over its pixels. Not a MotionFlag.
inline constexpr std::uint16_t kTiled = 1 << 8;

/// The result of a tracker. Patch centres are in frame coordinates.
struct Measurement {
  std::uint16_t flags = 0; ///< kStill, kCut or kTiled
  int candidates = 0;      ///< patches looked at; those that cannot be trusted are not in the list
  int count = 0;
  std::array<Patch, kMaxPatches> patches;

  void clear() {
    flags = 0;
    candidates = 0;
    count = 0;
  }
  /// A patch beyond kMaxPatches is left out.
  void add(const Patch &patch) {
    if (count < kMaxPatches)
      patches[static_cast<std::size_t>(count++)] = patch;
  }
  std::span<const Patch> view() const { return {patches.data(), static_cast<std::size_t>(count)}; }
  std::span<Patch> view() { return {patches.data(), static_cast<std::size_t>(count)}; }

  /// Moves the origin of the coordinates by (-x, -y) px.
  void shift(float x, float y) {
    for (Patch &patch : view()) {
      patch.x += x;
      patch.y += y;
    }
  }
  /// Converts to the pixels of a frame that is `factor` times larger.
  void scale(float factor) {
    if (factor == 1)
      return;
    for (Patch &patch : view()) {
      for (float *length : {&patch.x, &patch.y, &patch.width, &patch.height, &patch.dx, &patch.dy})
        *length *= factor;
      for (float *precision : {&patch.precision_xx, &patch.precision_xy, &patch.precision_yy})
        *precision /= factor * factor;
    }
  }
};

} // namespace haptic
