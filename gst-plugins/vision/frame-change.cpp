// SPDX-License-Identifier: LGPL-2.1-or-later
#include "frame-change.hpp"

#include "image-kernels.hpp"

#include <algorithm>

namespace haptic {

ChangeFinding find_change(const LumaView &previous, const LumaView &current, float noise) {
  constexpr float kOverNoise = 1.3F;
  constexpr float kSignificant = 7; // F distribution with 2 degrees of freedom: 1 in 1000
  const auto sums = measure_change(previous, current);
  if (sums.squares == 0)
    return {};
  const auto pixels = static_cast<float>((previous.width - 2) * (previous.height - 2));
  const float mean = sums.sum / pixels;
  const float energy = std::max(0.0F, sums.squares / pixels - mean * mean);
  if (energy > 2 * kOverNoise * noise)
    return {Change::some, energy};
  const Displacement moved = solve(sums.structure, sums.moment, 1);
  if (quadratic(sums.structure, moved) > 2 * kSignificant * energy)
    return {Change::some, energy};
  // Nothing can be said of a region whose texture could hide such a motion. (A plain central
  // difference of white noise of variance 1 has variance 1/2.)
  constexpr float kHidden = 0.15F; // px
  const float texture = eigenvalues(sums.structure).least - 0.5F * noise * pixels;
  return {texture > 2 * noise / (kHidden * kHidden) ? Change::none : Change::unseen, energy};
}

} // namespace haptic
