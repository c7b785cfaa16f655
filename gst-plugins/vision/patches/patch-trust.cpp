// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patches/patch-trust.hpp"

#include <algorithm>

namespace haptic {
namespace {

// Zero-mean normalised correlations between a patch and the later frame.
constexpr float kUseless = 0.6F; // unrelated patches reach this by chance
constexpr float kFound = 0.8F;
constexpr float kGood = 0.9F;
constexpr float kClearlyBetter = 0.1F;

} // namespace

float largest_residual2(float noise) {
  constexpr float kOverNoise = 4;
  return std::max(kCompressionResidual2, kOverNoise * 2 * kSmoothedNoise * noise);
}

float displacement_noise(float residual2) {
  // Smoothing correlates the noise of neighbouring pixels: fewer of them are independent.
  constexpr float kNoiseCorrelation = 5;
  constexpr float kLeastResidual2 = 0.05F; // grey levels squared, rounding to 8 bits
  return kNoiseCorrelation * std::max(residual2, kLeastResidual2);
}

bool has_texture(float eigenvalue, float pixels, float noise) {
  constexpr float kTextureOverNoise = 3;
  // Variance of a smoothed pixel's gradient from white noise of variance 1: the squared weights of
  // (1 2 0 -2 -1)/8 along the gradient times those of (1 2 1)/4 across it.
  constexpr float kGradientNoise = 10.0F / 64 * 6 / 16;
  return eigenvalue > kTextureOverNoise * kGradientNoise * noise * pixels;
}

float trust_of(float correlation) {
  return std::clamp((correlation - kUseless) / (kGood - kUseless), 0.0F, 1.0F);
}

bool is_found(float correlation) {
  return correlation >= kFound;
}

bool is_clearly_better(float correlation, float than) {
  return correlation > than + kClearlyBetter;
}

bool is_same_scene(float trust, int candidates) {
  // Patches of the same scene have a mean trust close to 1, those of another scene stay below this.
  constexpr float kLeastTrust = 0.6F;
  return trust >= kLeastTrust * static_cast<float>(candidates);
}

float add_patch(const Template &patch, const Alignment &aligned, float noise,
                Measurement &measurement) {
  const Fit &fit = aligned.fit;
  if (!fit.inside) {
    ++measurement.candidates;
    return 0;
  }
  const auto side = static_cast<float>(patch.side);
  const auto [least, most] = eigenvalues(patch.structure);
  const float trust = trust_of(fit.correlation);
  const bool is_candidate = has_texture(most, side * side, noise);
  if (is_candidate)
    ++measurement.candidates;
  // Its precision would be 0, which says that the precision is not known.
  if (trust <= 0)
    return 0;
  const float residual2 = fit.residual * fit.residual;
  const bool is_two_dimensional =
      has_texture(least, side * side, std::min(noise, noise_of(residual2)));
  const Tensor precision = trust / displacement_noise(residual2) *
                           (is_two_dimensional ? patch.structure : strong_part(patch.structure));
  measurement.add({patch.x + side / 2, patch.y + side / 2, side, side, aligned.displacement.x,
                   aligned.displacement.y, precision.xx, precision.xy, precision.yy, fit.residual});
  return is_candidate ? trust : 0;
}

} // namespace haptic
