// SPDX-License-Identifier: LGPL-2.1-or-later
// Lucas-Kanade on square patches. One source for every instruction set (Google Highway, dispatched
// at run time). Formulas and sources stand above the kernels.
#pragma once

#include "pixels/image-kernels.hpp"
#include "pixels/tensor.hpp"

#include <array>
#include <limits>
#include <span>

namespace haptic {

/// Grey levels squared of a pixel, added to the energy of a template before a division: a template
/// without contrast must not lose its gradients to noise.
inline constexpr float kEnergyRidge = 0.8F;

/// A square piece of the earlier frame, prepared for inverse-compositional Lucas-Kanade. Its
/// gradients are orthogonal to a constant and to the grey levels, so that a change of offset or
/// gain between the frames does not change the estimate.
struct Template {
  static constexpr std::size_t kMostPixels = 256;

  float x = 0; ///< sampling position of the first pixel in the plane, may be fractional
  float y = 0;
  int side = 8;        ///< px, 8 or 16
  float seen = 0;      ///< pixels, if some have no weight: their grey level and gradient are 0
  Tensor structure;    ///< structure tensor of the projected gradients
  Displacement bias;   ///< sum of projected gradient * grey level: what a fit at rest would step by
  float energy = 0;    ///< sum of squared grey levels about their mean
  float slope = 0;     ///< sum of squared differences to the next pixel, along x and y
  float curvature = 0; ///< sum of the squared Laplacian
  alignas(64) std::array<float, kMostPixels> grey;
  alignas(64) std::array<float, kMostPixels> gradient_x;
  alignas(64) std::array<float, kMostPixels> gradient_y;
};

/// Gradient of a displacement, px per px.
struct Strain {
  float xx = 0; ///< of its x, along x
  float xy = 0; ///< of its x, along y
  float yx = 0; ///< of its y, along x
  float yy = 0; ///< of its y, along y
};

/// How well a template fits at a displacement.
struct Fit {
  Displacement gradient;  ///< sum of projected gradient * later frame, less the template's bias
  float correlation = -1; ///< zero-mean normalised, -1..1
  /// Root mean square of the grey levels that the best gain and offset leave.
  float residual = std::numeric_limits<float>::infinity();
  bool inside = false; ///< false: the displaced template leaves the plane, nothing is known
};

/// Fills in templates of one side from their positions. They need one more pixel on every side, and
/// another to the right and below where the position is fractional.
void prepare_templates(const Plane &plane, std::span<Template> patches);

/// Added to the diagonal of a structure tensor before it is inverted: the contribution of noise, so
/// that a patch without texture stays at its start, and a share of the trace, so that a patch with
/// a single edge does not run along it.
float regulariser(const Tensor &structure, float pixels);

/// Fits of templates of one side that all have the same displacement.
void fit_templates(const Plane &plane, std::span<const Template> patches, Displacement displacement,
                   std::span<Fit> fits);

struct Alignment {
  Displacement displacement;
  Fit fit; ///< there, or some hundredths of a pixel before it
};

/// At most `iterations` Gauss-Newton steps, each at most 1 px long, from the start that fits best.
/// There is at least one start.
Alignment align_template(const Plane &plane, const Template &patch,
                         std::span<const Displacement> starts, int iterations);

/// The same for templates of one side, at most kMaxPatches, each with its starts. What `found`
/// holds stays where no start fits better than it, and where there is no start. A new Alignment
/// fits worse than any.
void align_templates(const Plane &plane, std::span<const Template> patches,
                     std::span<const std::span<const Displacement>> starts, int iterations,
                     std::span<Alignment> found, const Strain *strain = nullptr);

/// The same for a patch that a strain about its middle bends too. The displacement is that of the
/// middle.
Alignment align_strained(const Plane &plane, const Template &patch, const Strain &strain,
                         Displacement start, int iterations);

struct SearchResult {
  Displacement best;
  float correlation = -1;
};

/// The whole-pixel displacement of largest correlation, at most `radius` px (and at most 12) from
/// `centre` along each axis.
SearchResult search_template(const Plane &plane, const Template &patch, Displacement centre,
                             int radius);

} // namespace haptic
