// SPDX-License-Identifier: LGPL-2.1-or-later
// A square of samples about a thing, the pose at which it is sampled, and the sums over the
// samples. One source for every instruction set (Google Highway, dispatched at run time).
#pragma once

#include "pixels/image-kernels.hpp"

#include <array>

namespace haptic {

inline constexpr int kPatchRadius = 10; ///< samples on each side of the middle one
inline constexpr int kPatchSide = 2 * kPatchRadius + 1;
inline constexpr int kPatchSamples = kPatchSide * kPatchSide;
inline constexpr int kPatchRoom = 448; ///< whole vectors; the rest is 0

/// Row after row.
struct alignas(64) PatchSamples {
  std::array<float, kPatchRoom> values{};

  float &operator[](int at) { return values[static_cast<std::size_t>(at)]; }
  float operator[](int at) const { return values[static_cast<std::size_t>(at)]; }
  float *data() { return values.data(); }
  const float *data() const { return values.data(); }
};

/// Grey levels with their gradients by row and column, per sample.
struct PatchTemplate {
  PatchSamples grey;
  PatchSamples gradient_x;
  PatchSamples gradient_y;
};

/// Where sample (u, v) of a patch lies: (a b; c d) (u, v) spacing + (x, y), px.
struct PatchPose {
  float a = 1, b = 0, c = 0, d = 1;
  float x = 0, y = 0;

  float area() const { return a * d - b * c; }
};

/// Bilinear samples of a plane; the pose is in its pixels, and the middle of pixel i is at i. All
/// samples must lie within the middles of the outermost pixels.
void sample_plane(const Plane &plane, const PatchPose &pose, PatchSamples &samples);

/// Central differences; 0 in the outermost rows or columns.
void differentiate(PatchTemplate &patch);

/// Weighted moments of two patches.
struct PatchMoments {
  float weight = 0;
  float mean_a = 0, mean_b = 0;
  float variance_a = 0, variance_b = 0, covariance = 0; ///< of one sample
};
PatchMoments compare_patches(const PatchSamples &weights, const PatchSamples &a,
                             const PatchSamples &b);

/// Overwrites `errors` with gain * now + offset - before, and returns the weighted sum of their
/// amounts.
float subtract_patches(const PatchSamples &weights, const PatchSamples &now,
                       const PatchSamples &before, float gain, float offset, PatchSamples &errors);

/// Weighted sums over the samples whose error is smaller than `limit`.
struct SmallErrors {
  float weight = 0;
  float amount = 0;  ///< of |error|
  float limited = 0; ///< of min(|error|, limit), over all samples
};
SmallErrors sum_small_errors(const PatchSamples &weights, const PatchSamples &errors, float limit);

/// Of a translation (x, y) and, after it, a change of scale and an angle.
struct NormalEquations {
  std::array<float, 10> matrix{}; ///< lower triangle, row after row
  std::array<float, 4> right{};
  float squares = 0; ///< of the errors, weighted
  float weight = 0;
};

/// Robust: a sample weighs w / (1 + error^2 / c^2)^2, which is Geman and McClure's function.
/// `has_similarity`: with scale and angle, else their sums stay 0.
NormalEquations sum_normal_equations(const PatchTemplate &patch, const PatchSamples &errors,
                                     const PatchSamples &weights, float c, bool has_similarity);

/// How fast an appearance follows what is seen.
struct LearningRates {
  float fits = 0;       ///< 0..1
  float appearance = 0; ///< 0..1, of samples that fit
};

/// k = exp(-error^2 / (2 tolerance^2)) says how well a sample fits: `fits` moves towards it, and
/// `appearance` towards `now` where it is high. Errors are those of gain * now + offset.
void learn_samples(const PatchSamples &now, float gain, float offset, float tolerance,
                   LearningRates rates, PatchSamples &appearance, PatchSamples &fits);

/// Zero-mean normalised correlations of every second sample of the 17x17 in the middle, at whole
/// pixels. `scores` gets (2 radius + 1)^2 of them, row after row; -1 where a sample lies outside
/// the plane. (x, y): the pixel under the middle sample of the score in the middle.
void correlate(const Plane &plane, int x, int y, int radius, const PatchSamples &weights,
               const PatchSamples &grey, float *scores);

} // namespace haptic
