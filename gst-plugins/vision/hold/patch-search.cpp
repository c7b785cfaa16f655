// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hold/patch-search.hpp"

#include "hold/patch-kernels.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {

std::optional<FoundPatch> PatchSearch::find(const LumaLayer &layer, const PatchSamples &weights,
                                            const PatchSamples &grey, float x, float y,
                                            int radius) {
  constexpr int kPeak = 3; // pixels about a peak that belong to it
  const int middle_x = static_cast<int>(std::lround(layer.column(x)));
  const int middle_y = static_cast<int>(std::lround(layer.row(y)));
  const int side = 2 * radius + 1;
  scores_.resize(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  correlate(layer.plane, middle_x, middle_y, radius, weights, grey, scores_.data());
  const auto best = std::ranges::max_element(scores_);
  if (*best <= -1)
    return std::nullopt;
  const int at = static_cast<int>(best - scores_.begin());
  const int best_x = at % side;
  const int best_y = at / side;
  FoundPatch found{layer.x + (static_cast<float>(middle_x - radius + best_x) + 0.5F) * layer.unit,
                   layer.y + (static_cast<float>(middle_y - radius + best_y) + 0.5F) * layer.unit,
                   *best};
  for (int i = 0; i < side * side; ++i)
    if (std::abs(i / side - best_y) > kPeak || std::abs(i % side - best_x) > kPeak)
      found.next_best = std::max(found.next_best, scores_[static_cast<std::size_t>(i)]);
  return found;
}

} // namespace haptic
