// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/light-change.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

// By which factor the median cell of `later`, multiplied by `by`, is brighter than the earlier one,
// as far as that stands out from the spread of the cells.
float factor_between(const CellMap &earlier, const CellMap &later, float by,
                     const LayerSize &size) {
  constexpr float kDark = 16; // grey levels: less does not show a factor
  constexpr float kLeastSpread = 1e-5F;
  std::array<float, static_cast<std::size_t>(kLayerSide / kCellSide) * (kLayerSide / kCellSide)>
      factors;
  std::size_t count = 0;
  for_cells(size, [&](int x, int y) {
    if (earlier.at(x, y) > kDark)
      factors[count++] = by * later.at(x, y) / earlier.at(x, y);
  });
  if (count == 0)
    return 1;
  const auto end = factors.begin() + static_cast<std::ptrdiff_t>(count);
  const auto middle = factors.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(factors.begin(), middle, end);
  const float factor = *middle;
  std::for_each(factors.begin(), end, [&](float &value) { value = std::abs(value - factor); });
  std::nth_element(factors.begin(), middle, end);
  const float in_spreads = std::abs(factor - 1) / (*middle + kLeastSpread);
  return 1 + std::clamp(in_spreads - 0.5F, 0.0F, 1.0F) * (factor - 1);
}

void multiply(float factor, const LayerSize &size, LayerFrame &frame) {
  for (int y = 0; y < size.height; ++y) {
    float *row = frame.luma.row(y);
    std::for_each(row - PixelMap::kMargin, row + size.width + PixelMap::kMargin,
                  [&](float &value) { value *= factor; });
  }
  for_cells(size, [&](int x, int y) { frame.mean.at(x, y) *= factor; });
}

} // namespace

void LightChange::take_out(const CellMap &earlier_mean, bool is_looked_for, const LayerSize &size,
                           LayerFrame &frame) {
  constexpr float kMost = 2; // of the factor, and one by it: else noise and rounding grow
  // Of what is left of the factor, in a frame: after a fade the contrast comes back in half a
  // minute, by at most 0.06 grey levels a frame.
  constexpr float kForgotten = 0.0005F;
  if (is_looked_for) {
    const float factor = factor_between(earlier_mean, frame.mean, factor_, size);
    const bool is_cut = factor < 1 / kMost || factor > kMost;
    factor_ = is_cut ? 1 : factor_ / factor;
    factor_ = std::clamp(factor_ + kForgotten * (1 - factor_), 1 / kMost, kMost);
  }
  if (factor_ != 1)
    multiply(factor_, size, frame);
}

} // namespace haptic
