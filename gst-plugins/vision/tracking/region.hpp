// SPDX-License-Identifier: LGPL-2.1-or-later
// The region of interest and the crop around it, from the pointer and a side length.
#pragma once

#include "pixels/luma-view.hpp"
#include "samples/region-size.hpp"

namespace haptic {

/// region_side() with hysteresis, for a hand that trembles. Not thread-safe.
class RegionSize {
public:
  /// Returns the side in px, an even number. It changes by more than a tenth or not at all. A hand
  /// near the centre gets `base` itself.
  int side(double z, int base, int frame_width, int frame_height);

private:
  int side_ = 0;
};

/// The square of `side` px about the pointer, clipped at the frame. `pointer_x` and `pointer_y`
/// are fractions of the frame, 0..1, origin at its top left (paper, equation 1). The centre stays
/// under the pointer: at a border the region gets smaller and does not move. At least 1x1.
Rectangle region_at(double pointer_x, double pointer_y, int side, int frame_width,
                    int frame_height);

/// The rectangle grown by `margin` px on each side and clipped at the frame.
Rectangle crop_around(const Rectangle &region, int margin, int frame_width, int frame_height);

/// Whether both sides are kSmallestRegion or more.
bool is_measurable(const Rectangle &region);

} // namespace haptic
