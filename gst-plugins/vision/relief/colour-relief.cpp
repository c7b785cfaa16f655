// SPDX-License-Identifier: LGPL-2.1-or-later
#include "relief/colour-relief.hpp"

#include "relief/cell-samples.hpp"

#include <algorithm>

namespace haptic {

void make_colour_relief(const ColourView &frame, const TouchTable &table, ReliefField &relief) {
  const auto &light = linear_light();
  const int samples_x = relief.columns * kCellSamples;
  const int samples_y = relief.rows * kCellSamples;
  std::vector<LinearColour> sums(relief.columns);
  for (int row = 0; row < relief.rows; ++row) {
    std::ranges::fill(sums, LinearColour{});
    for (int i = 0; i < kCellSamples; ++i) {
      const std::ptrdiff_t y =
          centre_of_part(row * kCellSamples + i, samples_y, frame.height) * frame.stride;
      for (int sample = 0; sample < samples_x; ++sample) {
        const std::ptrdiff_t at =
            y + centre_of_part(sample, samples_x, frame.width) * std::ptrdiff_t{frame.pixel_size};
        LinearColour &sum = sums[static_cast<std::size_t>(sample / kCellSamples)];
        for (std::size_t c = 0; c < sum.size(); ++c)
          sum[c] += static_cast<double>(light[frame.components[c][at]]);
      }
    }
    ReliefCell *cell = relief.cells.data() + std::ptrdiff_t{row} * relief.columns;
    for (LinearColour &sum : sums) {
      for (double &part : sum)
        part /= kCellSamples * kCellSamples;
      *cell++ = table.at(lab_of(sum));
    }
  }
}

} // namespace haptic
