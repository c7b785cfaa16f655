// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/region-translation.hpp"

#include "layers/layer-kernels.hpp"

#include <algorithm>

namespace haptic {
namespace {

constexpr float kMostStep = 1.5F; // px, of one Gauss-Newton step
constexpr float kFarthest = 26;   // px
constexpr float kLittle = 0.5F;   // of the texture

Displacement clamped(Displacement d) {
  return {std::clamp(d.x, -kFarthest, kFarthest), std::clamp(d.y, -kFarthest, kFarthest)};
}

} // namespace

ExplainedTranslation RegionTranslation::refine(const LayerFrame &earlier, const LayerFrame &later,
                                               float noise, const LayerSize &size,
                                               Displacement start, int steps) {
  constexpr float kArrived2 = 0.01F * 0.01F;
  constexpr float kRidge = 1;
  constexpr float kFewest = 2; // cells
  Displacement at = start;
  TranslationFit fit = fit_translation(earlier, later, at, noise, size, energy_);
  for (int i = 0; i < steps; ++i) {
    const Displacement step = at_most(kMostStep, solve(fit.structure, fit.moment, kRidge));
    at = clamped(at + step);
    fit = fit_translation(earlier, later, at, noise, size, energy_);
    if (norm2(step) < kArrived2)
      break;
  }
  return {at, fit.all > kFewest ? fit.explained / fit.all : 0};
}

// The displacement by whole cells after which the means of the cells fit best, without the slow
// changes of light.
Displacement RegionTranslation::search(const LayerFrame &earlier, const LayerFrame &later,
                                       const LayerSize &size) {
  constexpr int kReach = 5; // cells
  static const auto kSlow = gaussian<4>(1.5F);
  const auto detail_of = [&](const CellMap &mean) {
    CellMap slow;
    blur(kSlow, size, mean, slow);
    for_cells(size, [&](int x, int y) { slow.at(x, y) = mean.at(x, y) - slow.at(x, y); });
    return slow;
  };
  return search_cells(detail_of(earlier.mean), detail_of(later.mean), kReach, size);
}

ExplainedTranslation RegionTranslation::find(const LayerFrame &earlier, const LayerFrame &later,
                                             float noise, const LayerSize &size) {
  constexpr int kFewSteps = 2;
  constexpr int kManySteps = 5;
  constexpr float kClearly = 0.1F; // of the texture
  const auto from = [&](Displacement start, int steps) {
    return refine(earlier, later, noise, size, start, steps);
  };
  ExplainedTranslation best = from(found_.displacement, kFewSteps);
  if (best.share < kLittle) {
    if (norm2(found_.displacement) > 0)
      if (const auto other = from({}, kFewSteps); other.share > best.share)
        best = other;
    if (best.share < kLittle)
      if (const Displacement start = search(earlier, later, size); norm2(start) > 0)
        if (const auto other = from(start, kManySteps); other.share > best.share + kClearly)
          best = other;
  }
  found_ = best;
  return best;
}

} // namespace haptic
