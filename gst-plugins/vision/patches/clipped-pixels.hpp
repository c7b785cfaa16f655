// SPDX-License-Identifier: LGPL-2.1-or-later
// Pixels that are too bright or too dark for the camera. Where their area ends, the frame shows
// where the light passed the limit, and not a thing that moves.
#pragma once

#include "patches/patch-grid.hpp"

#include <cstdint>
#include <vector>

namespace haptic {

/// The clipped pixels of one frame.
class ClippedPixels {
public:
  /// Finds them if they are a quarter of the region or more; fewer change little. A column or row
  /// of the view is kSmoothingRadius further than that of the smoothed plane, which `region` is in.
  void find(const LumaView &view, const Area &region);

  /// From now on there are none.
  void forget() { width_ = height_ = 0; }
  bool any() const { return width_ > 0; }

  /// Takes the weight of pixels that are clipped, or were smoothed with clipped ones, out of a
  /// template of the finest plane.
  void mask(Template &patch) const;

private:
  bool is_kept(int x, int y) const;

  int width_ = 0; // px of the plane; 0: no pixels are clipped
  int height_ = 0;
  std::vector<std::uint8_t> marks_; // of the pixels of the plane
};

} // namespace haptic
