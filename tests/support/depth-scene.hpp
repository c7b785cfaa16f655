// SPDX-License-Identifier: LGPL-2.1-or-later
// The scene of depth-film as reliefs.
#pragma once

#include "../../pipelines/films/program/depth-scene.hpp"
#include "samples/relief-field.hpp"

#include <cstdint>

namespace test {

class DepthScene : public film::DepthScene {
public:
  static constexpr std::uint64_t kInterval = 33'333'333; // ns

  /// The relief of a frame: its depth at the centres of the cells.
  static haptic::ReliefField relief(int frame, int columns = 64) {
    haptic::ReliefField relief;
    relief.interval = kInterval;
    relief.frame_width = kWidth;
    relief.frame_height = kHeight;
    relief.columns = static_cast<std::uint16_t>(columns);
    relief.rows = static_cast<std::uint16_t>(columns * kHeight / kWidth);
    const double side = static_cast<double>(kWidth) / columns;
    const double time = frame * static_cast<double>(kInterval) * 1e-9;
    for (int row = 0; row < relief.rows; ++row)
      for (int column = 0; column < columns; ++column)
        relief.cells.push_back(
            {height(depth((column + 0.5) * side, (row + 0.5) * side, time)), 200, 0.3F, 1});
    return relief;
  }
};

} // namespace test
