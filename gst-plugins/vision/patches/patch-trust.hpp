// SPDX-License-Identifier: LGPL-2.1-or-later
// How far a patch can be trusted, from its texture, its correlation and its residual.
#pragma once

#include "patches/patch-grid.hpp"
#include "pixels/tensor.hpp"

namespace haptic {

/// Variance of a smoothed pixel from white noise of variance 1: sum of the squared weights
/// (1 2 1)/4 x (1 2 1)/4, which is (6/16)^2.
inline constexpr float kSmoothedNoise = 36.0F / 256;

/// Noise of a pixel (variance, grey levels squared) that explains the mean squared residual of a
/// fit: both frames are noisy, and both are smoothed.
inline float noise_of(float residual2) {
  return residual2 / (2 * kSmoothedNoise);
}

/// Mean squared residual from which on a fit does not explain the pixels, whatever the reason: more
/// than compression of a still scene leaves, and four times what the noise (variance of a pixel)
/// does.
float largest_residual2(float noise);

/// Variance of a displacement times its structure tensor, from the mean squared residual.
float displacement_noise(float residual2);

/// Whether an eigenvalue of the structure of so many pixels is larger than noise (variance of a
/// pixel, grey levels squared) alone makes it.
bool has_texture(float eigenvalue, float pixels, float noise);

/// How far a fit of this correlation can be trusted, 0..1.
float trust_of(float correlation);

/// Whether a start led to the right place; below, a search is worth its cost.
bool is_found(float correlation);

/// Whether a fit found elsewhere replaces another one.
bool is_clearly_better(float correlation, float than);

/// Whether patches with this sum of trust show the same scene in both frames.
bool is_same_scene(float trust, int candidates);

/// Adds the patch unless it cannot be trusted, and counts it as a candidate if it has texture or
/// left the frame. Returns the trust in a candidate with texture, 0..1, otherwise 0.
float add_patch(const Template &patch, const Alignment &aligned, float noise,
                Measurement &measurement);

} // namespace haptic
