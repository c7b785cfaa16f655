// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pixels/frame-change.hpp"

#include "pixels/image-kernels.hpp"

#include <algorithm>

namespace haptic {

// With the energy E (mean squared difference about its mean) and J = sum g g^T, m = sum g D of
// measure_change: the least squares displacement d = J^-1 m explains d^T J d of the squared
// differences. If only noise changed, (d^T J d / 2) / E has the F distribution with 2 degrees of
// freedom above and as many as pixels below.
ChangeFinding find_change(const LumaView &previous, const LumaView &current, float noise) {
  constexpr float kOverNoise = 1.3F;
  constexpr float kSignificant = 7; // by chance 1 in 1000
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
  // A region without enough texture could hide a motion. (A central difference of white noise of
  // variance 1 has variance 1/2.)
  constexpr float kHidden = 0.15F; // px
  const float texture = eigenvalues(sums.structure).least - 0.5F * noise * pixels;
  return {texture > 2 * noise / (kHidden * kHidden) ? Change::none : Change::unseen, energy};
}

// An edge makes a row differ from the next by half the energy of the difference to the second next,
// texture that is resolved by less.
bool is_combed(const LumaView &view, float noise) {
  constexpr float kCombed = 0.6F;
  const auto [next, second] = compare_rows(view);
  return next - 2 * noise > kCombed * (second - 2 * noise);
}

} // namespace haptic
