// SPDX-License-Identifier: LGPL-2.1-or-later
// Clouds that drift over a sky, and hills below them.
#pragma once

#include "scene/drawing.hpp"

namespace film {

class Sky {
public:
  /// `scale`: px for each px of a frame 540 px high.
  Sky(int width, int height, float scale, std::uint64_t seed);

  void draw(Canvas &canvas, double time, double interval) const;

  static constexpr float kHorizon = 418; ///< px of a frame 540 px high

private:
  float scale_;
  Texture clouds_;
  Texture hills_;
};

} // namespace film
