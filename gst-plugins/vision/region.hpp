// SPDX-License-Identifier: LGPL-2.1-or-later
// Where to look: from the pointer and a side length to the region and the crop around it.
#pragma once

#include "region-size.hpp"

namespace haptic {

/// Pixels of a frame, origin at its top left corner.
struct Rectangle {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool operator==(const Rectangle &) const = default;
};

/// region_side() for a hand that trembles. Not thread-safe.
class RegionSize {
public:
  /// Side in px, even. Follows only a change of more than a tenth; `base` itself for a hand about
  /// the centre.
  int side(double z, int base, int frame_width, int frame_height);

private:
  int side_ = 0;
};

/// The square of `side` px about the pointer, clipped at the frame. `pointer_x` and `pointer_y`
/// are fractions of the frame, 0..1, origin at its top left (paper, equation 1). The centre stays
/// under the pointer: at a border the region gets smaller, it does not move inwards. At least 1x1.
Rectangle region_at(double pointer_x, double pointer_y, int side, int frame_width,
                    int frame_height);

/// The rectangle grown by `margin` px on each side and clipped at the frame.
Rectangle crop_around(const Rectangle &region, int margin, int frame_width, int frame_height);

bool is_measurable(const Rectangle &region);

} // namespace haptic
