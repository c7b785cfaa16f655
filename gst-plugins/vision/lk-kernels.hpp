// SPDX-License-Identifier: LGPL-2.1-or-later
// The pixel work of the fast tracker, one source for every instruction set (Google Highway,
// dispatched at run time).
#pragma once

#include "patch-tracker.hpp"
#include "tensor.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace haptic {

/// 8-bit luma without padding. Keeps its memory unless it has to grow.
struct ByteImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;

  LumaView view() const { return {pixels.data(), width, height, width}; }
};

/// Grey levels as floats. Rows are padded so that vectors may run over
/// their end.
class Plane {
public:
  /// Keeps its memory unless it has to grow.
  void resize(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  int stride() const { return stride_; }
  float *row(int y) { return values_.data() + static_cast<std::ptrdiff_t>(y) * stride_; }
  const float *row(int y) const {
    return values_.data() + static_cast<std::ptrdiff_t>(y) * stride_;
  }

private:
  int width_ = 0;
  int height_ = 0;
  int stride_ = 0;
  std::vector<float> values_;
};

/// A square piece of the earlier frame, ready for inverse-compositional Lucas-Kanade. Its
/// gradients are made orthogonal to a constant and to the grey levels themselves, so that a change
/// of offset or gain between the frames does not move the estimate.
struct Template {
  static constexpr std::size_t kMostPixels = 256;

  float x = 0; ///< sampling position of the first pixel in the plane, may be fractional
  float y = 0;
  int side = 8;        ///< px, 8 or 16
  Tensor structure;    ///< structure tensor of the projected gradients
  float energy = 0;    ///< sum of squared grey levels about their mean
  float slope = 0;     ///< sum of squared differences to the next pixel, along x and y
  float curvature = 0; ///< sum of the squared Laplacian
  alignas(64) std::array<float, kMostPixels> grey;
  alignas(64) std::array<float, kMostPixels> gradient_x;
  alignas(64) std::array<float, kMostPixels> gradient_y;
};

/// How the displacement changes from place to place, px per px.
struct Strain {
  float xx = 0; ///< of its x, along x
  float xy = 0; ///< of its x, along y
  float yx = 0;
  float yy = 0;
};

/// How well a template fits at a displacement.
struct Fit {
  Displacement gradient;                                   ///< sum of gradient * later frame
  float correlation = -1;                                  ///< zero-mean normalised, -1..1
  float residual = std::numeric_limits<float>::infinity(); ///< rms grey levels left after the best
                                                           ///< gain and offset
  bool inside = false; ///< false: the displaced template leaves the plane, nothing is known
};

/// Sums over the region that tell a still frame from a moving one.
struct ChangeSums {
  float sum = 0;       ///< of the differences later - earlier
  float squares = 0;   ///< of the squared differences
  Displacement moment; ///< of gradient * difference
  Tensor structure;    ///< of the gradients of the earlier frame
};

/// Differences inside the view; both views have the same size, at least 3x3. The outermost pixels
/// serve the gradients alone.
ChangeSums measure_change(const LumaView &previous, const LumaView &current);

/// Averages 2x2 pixels; an odd last row or column is left out.
void average_pairs(const LumaView &fine, ByteImage &coarse);

/// Smooths with the 3x3 binomial kernel. The plane lacks the outermost pixels of the view, which
/// is at least 10x10.
void smooth(const LumaView &view, Plane &plane);

/// Averages 2x2 pixels; an odd last row or column is left out.
void halve(const Plane &fine, Plane &coarse);

/// Fills in templates of one side from their positions. One more pixel is needed on every side, and
/// another to the right and below where the position is fractional.
void prepare_templates(const Plane &plane, std::span<Template> patches);

/// Fills in a template with what the frame will look like there after it was strained about the
/// template's middle, which then is what a displacement moves.
void prepare_strained_template(const Plane &plane, const Strain &strain, Template &patch);

/// Added to a structure tensor before it is inverted: what noise contributes, so that a patch
/// without texture stays where it started, and a share of the strongest direction, so that a patch
/// with a single edge does not run along it.
float regulariser(const Tensor &structure, float pixels);

/// How templates of one side fit when all are displaced alike.
void fit_templates(const Plane &plane, std::span<const Template> patches, Displacement displacement,
                   std::span<Fit> fits);

struct Alignment {
  Displacement displacement;
  Fit fit; ///< there, but for the last hundredths of a pixel
};

/// At most so many Gauss-Newton steps, each at most one pixel long, from the start that fits best.
Alignment align_template(const Plane &plane, const Template &patch,
                         std::span<const Displacement> starts, int iterations);

/// The best whole-pixel displacement within `radius` of `centre`, by correlation; also the best one
/// that is not its neighbour.
struct SearchResult {
  Displacement best;
  float correlation = -1;
  float runner_up = -1; ///< correlation of the best maximum elsewhere
};
SearchResult search_template(const Plane &plane, const Template &patch, Displacement centre,
                             int radius);

} // namespace haptic
