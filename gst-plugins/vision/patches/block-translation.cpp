// SPDX-License-Identifier: LGPL-2.1-or-later
#include "patches/block-translation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

// Gauss-Newton for one displacement d of all blocks b (Lucas and Kanade 1981; inverse compositional
// after Baker and Matthews 2004, where J_b and the gradients belong to the earlier frame):
//   d <- d - (sum_b J_b + r I)^-1 sum_b g_b(d)
// with the structure tensor J_b of a block, its Fit::gradient g_b and regulariser() r. The sums run
// over the blocks inside the frame.
class Descent {
public:
  Descent(const Plane &later, std::span<const Template> blocks, Translation &result)
      : later_(later), blocks_(blocks), result_(result),
        block_pixels_(static_cast<float>(blocks[0].side * blocks[0].side)) {
    for (const Template &block : blocks)
      result_.structure += block.structure;
    least_ = eigenvalues(result_.structure).least;
    strong_ = strong_direction(result_.structure);
  }

  // Smaller eigenvalue of the structure of all blocks.
  float least() const { return least_; }
  float all_pixels() const { return block_pixels_ * static_cast<float>(blocks_.size()); }

  void run(Displacement start, int iterations, bool judged);
  float disagreement() const;

private:
  Displacement along_strong(Displacement d) const { return dot(d, strong_) * strong_; }
  Displacement fit();

  const Plane &later_;
  std::span<const Template> blocks_;
  Translation &result_;
  float block_pixels_;
  float least_;
  Displacement strong_;
  std::array<Fit, kMaxPatches> fits_;
};

// Fits all blocks at the displacement. Returns the sum of their gradients.
Displacement Descent::fit() {
  Displacement gradient;
  float energy = 0;
  float correlation = 0;
  float squares = 0;
  float curvature = 0;
  result_.structure = {};
  result_.pixels = 0;
  fit_templates(later_, blocks_, result_.displacement, std::span(fits_).first(blocks_.size()));
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Fit &fit = fits_[i];
    const Template &block = blocks_[i];
    if (!fit.inside)
      continue;
    gradient += fit.gradient;
    correlation += fit.correlation * block.energy;
    energy += block.energy;
    squares += fit.residual * fit.residual;
    result_.structure += block.structure;
    result_.pixels += block_pixels_;
    curvature += block.curvature;
  }
  const float seen_pixels = std::max(result_.pixels, block_pixels_);
  // Half way between pixels, bilinear interpolation is off by an eighth of the second derivative,
  // in both frames.
  result_.interpolation2 = 2.0F / 64 * curvature / seen_pixels;
  // Less than half of the region does not stand for all of it.
  const float seen = std::min(1.0F, 2 * result_.pixels / all_pixels());
  result_.correlation = energy > 0 ? seen * correlation / energy : -1;
  result_.residual2 = squares * block_pixels_ / seen_pixels;
  return gradient;
}

void Descent::run(Displacement start, int iterations, bool judged) {
  // Coarser ones are starts, and where they are judged, a tenth of that changes no decision.
  const float converged = judged ? 1e-4F : 3e-3F; // px squared
  result_.displacement = result_.one_direction ? along_strong(start) : start;
  Displacement gradient = fit();
  for (int step = 0; step < iterations; ++step) {
    Displacement move =
        solve(result_.structure, gradient, regulariser(result_.structure, result_.pixels + 1));
    if (result_.one_direction)
      move = along_strong(move);
    const float length2 = norm2(move);
    if (length2 > 1)
      move = 1 / std::sqrt(length2) * move;
    result_.displacement -= move;
    if (length2 < converged)
      break;
    gradient = fit();
  }
}

// Sum over the blocks of |c|^2 / (variance of c along itself + floor^2), where c is the correction
// that a block alone would make. Chi-squared if all blocks have the same displacement.
float Descent::disagreement() const {
  constexpr float kFloor = 0.02F; // px, error of the interpolation without any noise
  float sum = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (!fits_[i].inside)
      continue;
    const Tensor &structure = blocks_[i].structure;
    const Displacement correction =
        solve(structure, fits_[i].gradient, regulariser(structure, block_pixels_));
    const float length2 = norm2(correction);
    const float information =
        quadratic(structure, correction) / std::max(length2, 1e-12F) / result_.variance();
    sum += length2 / (1 / std::max(information, 1e-6F) + kFloor * kFloor);
  }
  return sum;
}

} // namespace

float Translation::variance() const {
  return displacement_noise(residual2);
}

Translation translate_blocks(const Plane &later, std::span<const Template> blocks,
                             Displacement start, int iterations, float noise, bool judged) {
  Translation result;
  Descent descent(later, blocks, result);
  // Where the weak direction may be noise, only the strong one is estimated: otherwise the estimate
  // would run along an edge. The residual then shows the noise of these frames (with whatever
  // else does not fit), and the weak direction gets a second chance.
  result.one_direction = !has_texture(descent.least(), descent.all_pixels(), noise);
  descent.run(start, iterations, judged);
  if (result.one_direction && has_texture(descent.least(), descent.all_pixels(),
                                          std::min(noise, noise_of(result.residual2)))) {
    result.one_direction = false;
    descent.run(start, iterations, judged);
  }
  if (judged)
    result.disagreement = descent.disagreement();
  return result;
}

bool explains(const Translation &whole, int side, float noise) {
  constexpr float kFits = 0.7F; // correlation
  const float blocks = whole.pixels / static_cast<float>(side * side);
  // Chi-squared with two degrees of freedom per block: its mean and a standard deviation.
  return has_texture(eigenvalues(whole.structure).most, whole.pixels, noise) &&
         whole.correlation > kFits && whole.disagreement < 2 * blocks + 2 * std::sqrt(blocks);
}

bool is_still(const Translation &whole, float noise) {
  constexpr float kSignificant = 12; // chi-squared with 2 degrees of freedom: 1 in 400
  // A bad fit makes every displacement insignificant: it says nothing about stillness.
  return whole.residual2 < largest_residual2(noise) &&
         quadratic(whole.structure, whole.displacement) < kSignificant * whole.variance();
}

bool is_precise(const Translation &whole) {
  constexpr float kPrecise = 0.1F; // px
  const auto [least, most] = eigenvalues(whole.structure);
  return (whole.one_direction ? most : least) > whole.variance() / (kPrecise * kPrecise);
}

Patch patch_of(const Area &area, const Translation &whole) {
  const Tensor precision =
      1 / whole.variance() * (whole.one_direction ? strong_part(whole.structure) : whole.structure);
  return {area.x + area.width / 2,
          area.y + area.height / 2,
          area.width,
          area.height,
          whole.displacement.x,
          whole.displacement.y,
          precision.xx,
          precision.xy,
          precision.yy,
          std::sqrt(whole.residual2)};
}

} // namespace haptic
