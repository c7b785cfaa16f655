// SPDX-License-Identifier: LGPL-2.1-or-later
// Looks for a patch in the surroundings of a place.
#pragma once

#include "hold/nearby-luma.hpp"
#include "hold/patch-kernels.hpp"

#include <optional>
#include <vector>

namespace haptic {

struct FoundPatch {
  float x = 0; ///< reduced px
  float y = 0;
  float correlation = 0; ///< -1..1
  float next_best = -1;  ///< correlation of the best place more than three pixels away
};

/// Not thread-safe.
class PatchSearch {
public:
  /// The best place within `radius` pixels of the layer. Nothing: the layer shows none of it.
  std::optional<FoundPatch> find(const LumaLayer &layer, const PatchSamples &weights,
                                 const PatchSamples &grey, float x, float y, int radius);

private:
  std::vector<float> scores_;
};

} // namespace haptic
