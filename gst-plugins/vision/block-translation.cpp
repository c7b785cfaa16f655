// SPDX-License-Identifier: LGPL-2.1-or-later
#include "block-translation.hpp"

#include <numbers>

namespace haptic {
namespace {

// Smoothing correlates the noise of neighbouring pixels: there are fewer independent ones than it
// seems.
constexpr float kNoiseCorrelation = 5;
// What interpolation leaves of the displacement's error even without noise, px.
constexpr float kDisplacementFloor = 0.02F;
// Variance of a smoothed pixel's gradient from white noise of variance 1: (1 2 0 -2 -1)/8 along, (1
// 2 1)/4 across.
constexpr float kGradientNoise = 10.0F / 64 * 6 / 16;
constexpr float kTextureOverNoise = 3;
constexpr float kLeastResidual2 = 0.05F; // grey levels squared, rounding to 8 bits

} // namespace

float Translation::variance() const {
  return kNoiseCorrelation * std::max(residual2, kLeastResidual2);
}

bool has_texture(float eigenvalue, float pixels, float noise) {
  return eigenvalue > kTextureOverNoise * kGradientNoise * noise * pixels;
}

Translation translate_blocks(const Plane &later, std::span<const Template> blocks,
                             Displacement start, int iterations, float noise, bool judged) {
  const auto block_pixels = static_cast<float>(blocks[0].side * blocks[0].side);
  const float all_pixels = block_pixels * static_cast<float>(blocks.size());
  Translation result;
  result.displacement = start;
  for (const Template &block : blocks)
    result.structure += block.structure;
  const float least = eigenvalues(result.structure).least;
  const Displacement strong = strong_direction(result.structure);
  const auto along_strong = [&](Displacement d) {
    return (d.x * strong.x + d.y * strong.y) * strong;
  };
  std::array<Fit, kMaxPatches> fits;

  // Blocks that leave the frame have no say.
  const auto fit_all = [&] {
    Displacement gradient;
    float energy = 0;
    float correlation = 0;
    float squares = 0;
    result.structure = {};
    result.pixels = 0;
    float curvature = 0;
    fit_templates(later, blocks, result.displacement, std::span(fits).first(blocks.size()));
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      if (!fits[i].inside)
        continue;
      gradient = gradient + fits[i].gradient;
      correlation += fits[i].correlation * blocks[i].energy;
      energy += blocks[i].energy;
      squares += fits[i].residual * fits[i].residual;
      result.structure += blocks[i].structure;
      result.pixels += block_pixels;
      curvature += blocks[i].curvature;
    }
    // Half way between pixels bilinear interpolation is off by an eighth of the second derivative,
    // in both frames.
    result.interpolation2 = 2.0F / 64 * curvature / std::max(result.pixels, block_pixels);
    // What is seen of less than half of the region stands for the rest with less right.
    const float seen = std::min(1.0F, 2 * result.pixels / all_pixels);
    result.correlation = energy > 0 ? seen * correlation / energy : -1;
    result.residual2 = squares * block_pixels / std::max(result.pixels, block_pixels);
    return gradient;
  };
  const auto descend = [&] {
    Displacement gradient = fit_all();
    for (int step = 0; step < iterations; ++step) {
      Displacement move =
          solve(result.structure, gradient, regulariser(result.structure, result.pixels + 1));
      if (result.one_direction)
        move = along_strong(move);
      const float length2 = norm2(move);
      if (length2 > 1)
        move = 1 / std::sqrt(length2) * move;
      result.displacement = result.displacement - move;
      if (length2 < 1e-5F)
        break;
      gradient = fit_all();
    }
  };

  // Where the weak direction may be noise, only the strong one is followed, else the estimate would
  // run along an edge. The residual then tells how much noise there really is (that of both
  // frames, smoothed, and whatever else does not fit).
  result.one_direction = !has_texture(least, all_pixels, noise);
  if (result.one_direction)
    result.displacement = along_strong(start);
  descend();
  if (result.one_direction &&
      has_texture(least, all_pixels, std::min(noise, result.residual2 / (2 * kSmoothedNoise)))) {
    result.one_direction = false;
    result.displacement = start;
    descend();
  }
  if (!judged)
    return result;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!fits[i].inside)
      continue;
    const Tensor &structure = blocks[i].structure;
    const Displacement own =
        solve(structure, fits[i].gradient, regulariser(structure, block_pixels));
    const float length2 = norm2(own);
    const float information =
        quadratic(structure, own) / std::max(length2, 1e-12F) / result.variance();
    result.disagreement +=
        length2 / (1 / std::max(information, 1e-6F) + kDisplacementFloor * kDisplacementFloor);
  }
  return result;
}

bool explains(const Translation &whole, int side, float noise) {
  constexpr float kFits = 0.7F;
  const float blocks = whole.pixels / static_cast<float>(side * side);
  // Chi-squared with two degrees of freedom per block: its mean and a standard deviation.
  return has_texture(eigenvalues(whole.structure).most, whole.pixels, noise) &&
         whole.correlation > kFits && whole.disagreement < 2 * blocks + 2 * std::sqrt(blocks);
}

bool is_still(const Translation &whole) {
  constexpr float kSignificant = 12; // chi-squared with 2 degrees of freedom: 1 in 400
  return quadratic(whole.structure, whole.displacement) < kSignificant * whole.variance();
}

float period(const Plane &earlier, std::span<const Template> blocks, float longest) {
  constexpr float kNarrowBand = 1.6F; // one frequency alone gives 1
  constexpr float kRepeats = 0.8F;
  constexpr int kDirections = 32; // of half a turn
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
  // The mean squared difference to the next pixel of a wave of angular frequency w is 2 - 2 cos w
  // times its power.
  const float length =
      2 * std::numbers::pi_v<float> / std::acos(std::clamp(1 - slope / energy / 2, -1.0F, 1.0F));
  if (length > longest)
    return 0;
  std::array<Fit, kMaxPatches> fits;
  for (int i = 0; i < kDirections; ++i) {
    const float angle = std::numbers::pi_v<float> * static_cast<float>(i) / kDirections;
    const Displacement further = length * Displacement{std::cos(angle), std::sin(angle)};
    fit_templates(earlier, blocks, further, std::span(fits).first(blocks.size()));
    float correlation = 0;
    float inside = 0;
    for (const Fit &fit : std::span(fits).first(blocks.size()))
      if (fit.inside) {
        correlation += fit.correlation;
        ++inside;
      }
    if (inside > 0 && correlation > kRepeats * inside)
      return length;
  }
  return 0;
}

bool is_precise(const Translation &whole) {
  constexpr float kPrecise = 0.1F; // px
  const auto [least, most] = eigenvalues(whole.structure);
  return (whole.one_direction ? most : least) > whole.variance() / (kPrecise * kPrecise);
}

Patch patch_of(const Area &area, const Translation &whole) {
  const Tensor precision = whole.one_direction ? strong_part(whole.structure) : whole.structure;
  const float scale = 1 / whole.variance();
  return {area.x + area.width / 2,
          area.y + area.height / 2,
          area.width,
          area.height,
          whole.displacement.x,
          whole.displacement.y,
          precision.xx * scale,
          precision.xy * scale,
          precision.yy * scale,
          std::sqrt(whole.residual2)};
}

float add_patch(const Template &patch, Displacement moved, const Fit &fit, float noise,
                Measurement &measurement) {
  constexpr float kUseless = 0.6F;
  constexpr float kGood = 0.9F;
  if (!fit.inside) {
    ++measurement.candidates;
    return 0;
  }
  const auto side = static_cast<float>(patch.side);
  const auto [least, most] = eigenvalues(patch.structure);
  const float trust = std::clamp((fit.correlation - kUseless) / (kGood - kUseless), 0.0F, 1.0F);
  const bool is_candidate = has_texture(most, side * side, noise);
  if (is_candidate) {
    ++measurement.candidates;
    if (trust <= 0)
      return 0;
  }
  const float scale =
      trust / (kNoiseCorrelation * std::max(fit.residual * fit.residual, kLeastResidual2));
  const float seen_noise = std::min(noise, fit.residual * fit.residual / (2 * kSmoothedNoise));
  const Tensor known =
      has_texture(least, side * side, seen_noise) ? patch.structure : strong_part(patch.structure);
  measurement.add({patch.x + side / 2, patch.y + side / 2, side, side, moved.x, moved.y,
                   known.xx * scale, known.xy * scale, known.yy * scale, fit.residual});
  return is_candidate ? trust : 0;
}

} // namespace haptic
