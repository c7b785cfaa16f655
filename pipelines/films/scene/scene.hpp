// SPDX-License-Identifier: LGPL-2.1-or-later
// The film: a tree, a meadow and a flag in gusts. Each frame depends on its time alone.
#pragma once

#include "scene/flag.hpp"
#include "scene/meadow.hpp"
#include "scene/sky.hpp"
#include "scene/tree.hpp"

namespace film {

class Scene {
public:
  /// Draws the textures, which takes some tenths of a second.
  Scene(int width, int height, std::uint64_t seed);

  /// Paints all of the canvas. `time` and `interval`, to the frame before, in s. Threads may draw
  /// at the same time.
  void draw(Canvas &canvas, double time, double interval) const;

  /// Whether this place is in the crown of the tree.
  bool is_crown(float x, float y) const;

private:
  Affine to_frame_; // from px of a frame of 960×540 px
  std::uint64_t seed_;
  Sky sky_;
  Meadow meadow_;
  Tree tree_;
  Flag flag_;
};

} // namespace film
