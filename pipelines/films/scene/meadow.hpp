// SPDX-License-Identifier: LGPL-2.1-or-later
// A meadow: rows of grass one behind the other, flowers, and long blades in front.
#pragma once

#include "scene/drawing.hpp"
#include "scene/wind.hpp"

namespace film {

class Meadow {
public:
  Meadow(int width, const Affine &to_frame, std::uint64_t seed);

  /// The rows behind (`far`) or before the foot of the tree.
  void draw(Canvas &canvas, const Winds &winds, bool far) const;

private:
  /// A strip of grass. Its blades are fixed at its lower edge.
  struct Row {
    float foot;    // px of a frame 540 px high
    float height;  // of the blades
    float bend;    // of the tips at wind 1
    Texture grass; // px drawn
  };
  struct Blade {
    Point foot;
    float height;
    float lean;
    float width;
    Pixel colour;
    Pixel tip;
    Sway sway;
  };

  void draw_strip(Canvas &canvas, const Row &row, const Winds &winds) const;
  void draw_blade(Canvas &canvas, const Blade &blade, const Winds &winds) const;

  Affine to_frame_;
  int margin_;            // px of a strip beyond both sides of the frame
  std::vector<Row> rows_; // from the front to the back
  std::vector<Blade> blades_;
};

} // namespace film
