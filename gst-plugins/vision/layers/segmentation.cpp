// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/segmentation.hpp"

#include "layers/layer-kernels.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {

void Segmentation::find_luma(const LayerFrame &frame, const CellMap &background,
                             const LayerSize &size) {
  constexpr float kLeastWeight = 1e-4F;
  static const auto kSpread = gaussian<4>(1.5F);
  CellMap sums;
  for_cells(size, [&](int x, int y) { sums.at(x, y) = background.at(x, y) * frame.mean.at(x, y); });
  blur(kSpread, size, sums, luma_);
  blur(kSpread, size, background, weights_);
  for_cells(size,
            [&](int x, int y) { luma_.at(x, y) /= std::max(weights_.at(x, y), kLeastWeight); });
}

void Segmentation::divide(const LayerFrame &frame, float noise, float most, const LayerSize &size) {
  constexpr float kLeastKnown = 0.02F;
  const float least = 10 + 2 * std::sqrt(noise); // grey levels
  share_background(frame.luma, luma_, weights_, kLeastKnown, least, size, share_);
  if (most == 1)
    return;
  for (int y = 0; y < size.height; ++y)
    std::for_each(share_.row(y), share_.row(y) + size.width, [=](float &share) { share *= most; });
}

} // namespace haptic
