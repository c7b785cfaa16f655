// SPDX-License-Identifier: LGPL-2.1-or-later
// Smaller frames for large regions, so that the cost of a measurement stays bounded.
#pragma once

#include "pixels/image-kernels.hpp"

#include <array>

namespace haptic {

/// Halves the width and height of views. Keeps its memory unless it has to grow.
class FrameReduction {
public:
  /// The view halved so many times. The result is valid until the next call.
  LumaView reduce(LumaView view, int times) {
    for (int i = 0; i < times; ++i) {
      ByteImage &half = halves_[static_cast<std::size_t>(i & 1)];
      average_pairs(view, half);
      view = half.view();
    }
    return view;
  }

private:
  std::array<ByteImage, 2> halves_;
};

} // namespace haptic
