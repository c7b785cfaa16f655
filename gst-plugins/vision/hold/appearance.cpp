// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hold/appearance.hpp"

#include "hold/patch-kernels.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr float kSpread = 4.5F;     // samples, standard deviation of the nearness
constexpr float kMiddle = 6.4F;     // samples, radius of the middle
constexpr float kMaskFloor = 0.02F; // part of the nearness of a sample that never fits
constexpr float kJudgeFloor = 0.1F; // the same of a sample of the middle
constexpr float kTolerance = 2.5F;  // times the errors of what fits
constexpr float kLeastErrors = 2;   // grey levels
constexpr float kJudgedNoise2 = 4;  // grey levels squared
constexpr float kUnusual = 3;       // times the usual difference
constexpr float kLeastUsual = 3;    // grey levels

// Of a sample, from its distance from the middle of the patch, squared.
template <typename Function>
PatchSamples window_of(Function &&weight) {
  PatchSamples window;
  for (int y = 0; y < kPatchSide; ++y)
    for (int x = 0; x < kPatchSide; ++x) {
      const auto dx = static_cast<float>(x - kPatchRadius);
      const auto dy = static_cast<float>(y - kPatchRadius);
      window[y * kPatchSide + x] = weight(dx * dx + dy * dy);
    }
  return window;
}

// The part on which a likeness is judged.
const PatchSamples &middle() {
  static const PatchSamples window = window_of(
      [](float distance2) { return std::max(0.0F, 1 - distance2 / (kMiddle * kMiddle)); });
  return window;
}

} // namespace

const PatchSamples &Appearance::nearness() {
  static const PatchSamples window =
      window_of([](float distance2) { return std::exp(-distance2 / (2 * kSpread * kSpread)); });
  return window;
}

void Appearance::begin(const PatchSamples &grey, const PatchSamples &fits) {
  patch_.grey = grey;
  fits_ = fits;
  update_mask();
}

void Appearance::learn(const PatchSamples &now, float error_scale, float fit_rate,
                       float grey_rate) {
  const PatchMoments moments = compare_patches(mask_, now, patch_.grey);
  const float gain =
      std::clamp(std::sqrt((moments.variance_b + 1) / (moments.variance_a + 1)), 0.6F, 1.6F);
  learn_samples(now, gain, moments.mean_b - gain * moments.mean_a,
                kTolerance * std::max(error_scale, kLeastErrors), {fit_rate, grey_rate},
                patch_.grey, fits_);
  update_mask();
}

void Appearance::update_mask() {
  const PatchSamples &near = nearness();
  const PatchSamples &about_middle = middle();
  for (int at = 0; at < kPatchRoom; ++at) {
    mask_[at] = near[at] * (kMaskFloor + fits_[at] * fits_[at]);
    judged_[at] = about_middle[at] * (kJudgeFloor + fits_[at]);
  }
}

Likeness Appearance::compare(const PatchSamples &now, float usual_difference) const {
  const PatchMoments moments = compare_patches(judged_, now, patch_.grey);
  PatchSamples errors;
  subtract_patches(judged_, now, patch_.grey, 1, 0, errors);
  const SmallErrors small =
      sum_small_errors(judged_, errors, kUnusual * std::max(kLeastUsual, usual_difference));
  return {(moments.covariance + kJudgedNoise2) / std::sqrt((moments.variance_a + kJudgedNoise2) *
                                                           (moments.variance_b + kJudgedNoise2)),
          small.weight / moments.weight, small.limited / moments.weight};
}

const PatchTemplate &Appearance::patch() {
  differentiate(patch_);
  return patch_;
}

} // namespace haptic
