// SPDX-License-Identifier: LGPL-2.1-or-later
// Least squares for the strain S of displacements d_i at the places x_i with the weights w_i, about
// their weighted means m_d and m_x, with a ridge r:
//   S = (sum w (d - m_d) (x - m_x)^T) (sum w (x - m_x) (x - m_x)^T + r I)^-1
#include "patches/grid-motions.hpp"

#include "patches/patch-trust.hpp"
#include "patches/start-set.hpp"

#include <algorithm>
#include <array>

namespace haptic {
namespace {

class StrainSums {
public:
  explicit StrainSums(float ridge) : places_{ridge, 0, ridge} {}

  void add(Displacement away, Displacement moved, float weight = 1) {
    places_ += weight * Tensor{away.x * away.x, away.x * away.y, away.y * away.y};
    x_moved_ += weight * moved.x * away;
    y_moved_ += weight * moved.y * away;
    squares_ += weight * norm2(moved);
  }
  Strain strain() const {
    const Displacement of_x = solve(places_, x_moved_, 0);
    const Displacement of_y = solve(places_, y_moved_, 0);
    return {of_x.x, of_x.y, of_y.x, of_y.y};
  }
  // Share of the squares of the displacements.
  bool explains(const Strain &strain, float share) const {
    return dot({strain.xx, strain.xy}, x_moved_) + dot({strain.yx, strain.yy}, y_moved_) >=
           share * squares_;
  }

private:
  Tensor places_;
  Displacement x_moved_;
  Displacement y_moved_;
  float squares_ = 0;
};

bool is_larger(const Strain &s, float than) {
  return s.xx * s.xx + s.xy * s.xy + s.yx * s.yx + s.yy * s.yy >= than * than;
}

} // namespace

Displacement middle_of(const Template &patch) {
  const float half = 0.5F * static_cast<float>(patch.side - 1);
  return {patch.x + half, patch.y + half};
}

Displacement BentMotion::at(Displacement other) const {
  const Displacement away = other - place;
  return displacement +
         Displacement{dot({strain.xx, strain.xy}, away), dot({strain.yx, strain.yy}, away)};
}

bool BentMotion::is_bent() const {
  constexpr float kNoticeable = 0.01F; // px per px
  return is_larger(strain, kNoticeable);
}

BentMotion BentMotion::finer(float scale) const {
  const float half = 0.5F * (scale - 1); // between the middles of a pixel and of its parts
  return {scale * place + Displacement{half, half}, scale * displacement, strain};
}

std::optional<BentMotion> find_bent_motion(std::span<const Template> patches,
                                           std::span<const Alignment> aligned, float most) {
  constexpr float kTexture = 300;  // grey levels squared: less structure weighs less
  constexpr float kTrusted = 0.6F; // of the patches
  constexpr float kRidge = 16;     // px squared
  std::array<float, kMaxPatches> weights;
  BentMotion motion;
  float trust = 0;
  float weight = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const float least = std::max(0.0F, eigenvalues(patches[i].structure).least);
    const float trusted = aligned[i].fit.inside ? trust_of(aligned[i].fit.correlation) : 0;
    weights[i] = trusted * least / (least + kTexture);
    trust += trusted;
    weight += weights[i];
    motion.place += weights[i] * middle_of(patches[i]);
    motion.displacement += weights[i] * aligned[i].displacement;
  }
  if (!(weight > 0) || trust < kTrusted * static_cast<float>(patches.size()))
    return {};
  motion.place = 1 / weight * motion.place;
  motion.displacement = 1 / weight * motion.displacement;
  StrainSums sums(kRidge);
  for (std::size_t i = 0; i < patches.size(); ++i)
    sums.add(middle_of(patches[i]) - motion.place, aligned[i].displacement - motion.displacement,
             weights[i]);
  motion.strain = sums.strain();
  for (std::size_t i = 0; i < patches.size(); ++i)
    if (weights[i] * norm2(aligned[i].displacement - motion.at(middle_of(patches[i]))) >
        most * most)
      return {};
  return motion;
}

std::optional<Strain> strain_at(const PatchGrid &grid, int row, int column,
                                std::span<const Alignment> aligned,
                                std::span<const Displacement> displacements) {
  constexpr float kSignificant = 0.03F; // px per px: less moves no corner of a patch noticeably
  constexpr float kLargest = 0.25F;     // px per px: neighbours that differ by more are apart
  constexpr float kCommon = 0.2F;       // of the squares of moved, that the strain explains
  constexpr float kRidge = 0.5F;        // in neighbours: without them there is no strain
  const std::size_t at = cell(row, grid.columns, column);
  const Template &patch = grid.patches[at];
  StrainSums sums(kRidge * static_cast<float>(patch.side * patch.side));
  const bool are_together = all_neighbours(grid, row, column, [&](int y, int x) {
    const std::size_t other = cell(y, grid.columns, x);
    if (other == at || !aligned[other].fit.inside)
      return true;
    const Displacement away{grid.patches[other].x - patch.x, grid.patches[other].y - patch.y};
    const Displacement moved = displacements[other] - displacements[at];
    if (norm2(moved) > kLargest * kLargest * norm2(away))
      return false;
    sums.add(away, moved);
    return true;
  });
  if (!are_together)
    return {};
  const Strain strain = sums.strain();
  if (!is_larger(strain, kSignificant) || !sums.explains(strain, kCommon))
    return {};
  return strain;
}

std::optional<Displacement> commonest_of(std::span<const GstHapticPatch> patches,
                                         std::optional<Displacement> other) {
  constexpr float kNear2 = 0.5F;        // px squared
  constexpr float kSame2 = 0.1F * 0.1F; // px squared: those near to one are near to the other
  constexpr float kFits2 = 20;          // grey levels squared: larger residuals weigh less
  std::array<Displacement, kMaxPatches> displacements;
  std::array<Displacement, kMaxPatches> tried;
  std::array<float, kMaxPatches> weights;
  std::size_t count = 0;
  std::size_t tries = 0;
  for (const GstHapticPatch &patch : patches) {
    const Displacement displacement{patch.dx, patch.dy};
    if (other && are_close(displacement, *other))
      continue;
    displacements[count] = displacement;
    weights[count++] = kFits2 / (kFits2 + patch.residual * patch.residual);
  }
  std::optional<Displacement> found;
  float most = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto is_same = [&](Displacement one) { return norm2(one - displacements[i]) < kSame2; };
    if (std::any_of(tried.begin(), tried.begin() + static_cast<std::ptrdiff_t>(tries), is_same))
      continue;
    tried[tries++] = displacements[i];
    Displacement sum;
    float weight = 0;
    for (std::size_t j = 0; j < count; ++j) {
      const float near = norm2(displacements[j] - displacements[i]) < kNear2 ? weights[j] : 0;
      sum += near * displacements[j];
      weight += near;
    }
    if (weight > most) {
      most = weight;
      found = 1 / weight * sum;
    }
  }
  return found;
}

} // namespace haptic
