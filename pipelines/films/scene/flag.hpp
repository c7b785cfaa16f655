// SPDX-License-Identifier: LGPL-2.1-or-later
// A flag on a pole: waves run through its cloth, and its slopes take the light.
#pragma once

#include "scene/drawing.hpp"
#include "scene/wind.hpp"

namespace film {

class Flag {
public:
  explicit Flag(const Affine &to_frame);

  void draw(Canvas &canvas, const Winds &winds) const;

private:
  struct Spot {
    Point at;      // px of a frame 960 px wide
    float towards; // px, to the camera
  };
  /// A point of the cloth, `along` from the pole and `down` from its top, 0..1.
  Spot spot(const Wind &wind, float along, float down) const;

  Affine to_frame_;
  Texture cloth_;
  Texture pole_;
};

} // namespace film
