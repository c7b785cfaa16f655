// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patches/texture-period.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace haptic {

// With the sums over all blocks energy E = sum t^2, slope S = sum |grad t|^2 and curvature
// C = sum (laplacian t)^2, and the power spectrum P(w) of the texture t:
//   S / E = mean of w^2 under P, C / E = mean of w^4 under P.
// The mean of w^4 is at least the square of the mean of w^2 (Jensen), and equal where P holds one
// frequency only: E C / S^2 = 1.
float texture_period(const Plane &earlier, std::span<const Template> blocks, float longest) {
  constexpr float kNarrowBand = 1.6F; // one frequency alone gives 1
  constexpr float kRepeats = 0.8F;    // correlation with the texture one period further
  constexpr int kDirections = 32;     // of half a turn
  float energy = 0;
  float slope = 0;
  float curvature = 0;
  for (const Template &block : blocks) {
    energy += block.energy;
    slope += block.slope;
    curvature += block.curvature;
  }
  if (!(energy > 0) || energy * curvature > kNarrowBand * slope * slope)
    return 0;
  // The squared difference to the next pixel of a wave of angular frequency w has the mean
  // (2 - 2 cos w) times the power of the wave.
  const float length =
      2 * std::numbers::pi_v<float> / std::acos(std::clamp(1 - slope / energy / 2, -1.0F, 1.0F));
  if (length > longest)
    return 0;
  std::array<Fit, kMaxPatches> storage;
  const auto fits = std::span(storage).first(blocks.size());
  for (int i = 0; i < kDirections; ++i) {
    const float angle = std::numbers::pi_v<float> * static_cast<float>(i) / kDirections;
    fit_templates(earlier, blocks, length * Displacement{std::cos(angle), std::sin(angle)}, fits);
    float correlation = 0;
    float inside = 0;
    for (const Fit &fit : fits)
      if (fit.inside) {
        correlation += fit.correlation;
        ++inside;
      }
    if (inside > 0 && correlation > kRepeats * inside)
      return length;
  }
  return 0;
}

bool resolve_period(const Plane &earlier, const Plane &later, std::span<const Template> blocks,
                    float longest, Displacement last, float noise, Translation &whole) {
  // Along an edge nothing is known anyway.
  if (whole.one_direction)
    return true;
  const float period = texture_period(earlier, blocks, longest);
  if (!(period > 0))
    return true;
  whole = translate_blocks(later, blocks, last, kMostSteps, noise, true);
  // Half a period away, the displacement in the other direction is as likely. Half of that is
  // certain enough.
  return norm2(whole.displacement - last) <= period * period / 16;
}

} // namespace haptic
