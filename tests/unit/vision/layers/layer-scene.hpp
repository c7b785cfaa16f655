// SPDX-License-Identifier: LGPL-2.1-or-later
// A leaf before a sky, drawn with known motion.
#pragma once

#include "frame-view.hpp"
#include "layers/layer-frame.hpp"
#include "moving-texture.hpp"

#include <algorithm>
#include <cmath>

namespace test {

/// A dark round leaf with veins before bright clouds without an edge.
class LayerScene {
public:
  double radius = 16;  ///< px, of the leaf
  Shift place{40, 40}; ///< px, of its middle before it moves

  /// The part of the pixel that the leaf covers, 0..1.
  double cover(int x, int y, Shift leaf) const {
    const double away = std::hypot(x + 0.5 - place.x - leaf.x, y + 0.5 - place.y - leaf.y);
    return std::clamp(radius - away + 0.5, 0.0, 1.0);
  }

  Frame draw(int width, int height, Shift sky, Shift leaf) const {
    Frame frame = clouds_.frame(width, height, sky);
    Frame veins(width, height);
    veins_.paint(veins, leaf);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const double share = cover(x, y, leaf);
        const double bright = frame.at(x, y) + 60;
        const double dark = veins.at(x, y) - 50;
        frame.at(x, y) = static_cast<std::uint8_t>(
            std::clamp(std::round(bright + share * (dark - bright)), 0.0, 255.0));
      }
    return frame;
  }

private:
  Texture clouds_{1, 60, 12};
  Texture veins_{2, 6, 20};
};

inline constexpr int kCropSide = 80; // px
inline constexpr haptic::LayerSize kCropSize{kCropSide, kCropSide};

inline haptic::LayerFrame prepared(const Frame &frame, float noise = 0) {
  haptic::LayerFrame made;
  haptic::prepare(view_of(frame), kCropSize, noise, made);
  return made;
}

} // namespace test
