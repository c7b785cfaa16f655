// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/region-layers.hpp"

#include "layers/layer-frame.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

float ramp(float value, float from, float to) {
  return std::clamp((value - from) / (to - from), 0.0F, 1.0F);
}

// What noise alone adds to the structure of the background in each direction, in units of its
// variance: 0.08 by the gradients of the pixels, 0.06 by those of the cells in a second; twice
// that.
Tensor beyond_noise(const Tensor &structure, float noise) {
  constexpr float kOfNoise = 0.28F;
  const float xx = std::max(0.0F, structure.xx - kOfNoise * noise);
  const float yy = std::max(0.0F, structure.yy - kOfNoise * noise);
  const float most = std::sqrt(xx * yy);
  return {xx, std::clamp(structure.xy, -most, most), yy};
}

} // namespace

void RegionLayers::forget() {
  is_cold_ = true;
  is_lost_ = true;
  frame_moves_ = 0;
  flat_parts_move_ = 0;
  flat_parts_seen_ = 0;
  region_ = {};
  light_.forget();
  translation_.forget();
  calm_.forget();
  things_.forget();
  background_.forget();
  foreground_.forget();
}

void RegionLayers::carry(int right, int down, const LumaView &earlier, float noise) {
  const CropMove move{right, down, size_, layer_size_of(earlier.width, earlier.height)};
  size_ = move.after;
  load_luma(earlier, size_, later());
  light_.take_out(later().mean, false, size_, later());
  find_structure(size_, noise, later());
  calm_.carry(move, later());
  things_.carry(move);
  background_.carry(move);
  foreground_.carry(move);
}

void RegionLayers::read(const LumaView &earlier_view, const LumaView &later_view, bool continues,
                        float noise, const std::optional<Displacement> &likely) {
  const LayerSize size = layer_size_of(later_view.width, later_view.height);
  if (!continues || size != size_ || is_cold_) {
    forget();
    size_ = size;
    prepare(earlier_view, size_, noise, later());
    calm_.update(later(), size_, {.seconds = 1, .noise = noise, .shift = {}});
  }
  now_ ^= 1U;
  load_luma(later_view, size_, later());
  light_.take_out(earlier().mean, frame_moves_ == 0, size_, later());
  find_structure(size_, noise, later());
  region_before_ = region_;
  // It costs as much as the rest of a quiet frame.
  if (frame_moves_ > 0 || is_lost_)
    region_ = translation_.find(earlier(), later(), noise, size_);
  else if (likely)
    region_ = translation_.judge(earlier(), later(), noise, size_, *likely);
  else
    region_ = {};
}

void RegionLayers::measure(const FrameMotion &frame, float seconds, float noise) {
  constexpr float kCertain = 0.5F;
  constexpr float kShift = 0.7F; // of the texture, that the region's translation explains
  constexpr float kSteady = 0.6F;
  const Displacement prior = frame.certainty * frame.displacement;
  // Less is the drift of clouds.
  const float counts = ramp(std::sqrt(norm2(prior)), 0.1F, 0.2F);
  const bool by_frame = frame.certainty > kCertain;
  calm_.update(later(), size_,
               {.seconds = seconds,
                .noise = noise,
                .shift = by_frame ? frame.displacement : region_.displacement,
                .has_shift = by_frame || region_.share >= kShift,
                .frame_moves = frame.certainty});
  things_.find(later(), calm_.rests(), size_, seconds);
  follow_flat_parts(seconds, frame.certainty);
  background_cells_ = calm_.background();
  for_cells(size_, [&](int x, int y) {
    background_cells_.at(x, y) = std::max(background_cells_.at(x, y), things_.cells().at(x, y));
  });
  segmentation_.find_luma(later(), background_cells_, size_);
  background_.update(earlier(), later(), segmentation_.luma(), calm_.background(), calm_.follows(),
                     size_,
                     {.seconds = seconds, .noise = noise, .prior = prior, .prior_counts = counts});
  segmentation_.divide(later(), noise, 1 - flat_parts_move_, size_);
  const bool is_steady = region_.share > kSteady && region_before_.share > kSteady;
  foreground_.step(
      earlier(), later(),
      {.frame = counts * prior,
       .change = is_steady ? region_.displacement - region_before_.displacement : Displacement{},
       .region = region_},
      noise, size_);
  background_motion_ = background_.motion();
  things_.move(foreground_.flow(), later().cell_structure, size_, background_motion_);
  const float apart = std::sqrt(norm2(region_.displacement - frame.displacement));
  blend_ =
      ramp(region_.share, 0.85F, 0.97F) * frame.certainty * counts * (1 - ramp(apart, 0.15F, 0.3F));
  frame_moves_ = frame.certainty;
  frame_displacement_ = frame.displacement;
  noise_used_ = noise;
  judge(noise);
  is_cold_ = false;
}

// Grass has flat parts, which look like a background. But they are as bright as its texture, there
// are fewer of them, and the texture moves. A pan moves all texture. The limits were chosen on the
// tuning films of tests/measure/felt.
void RegionLayers::follow_flat_parts(float seconds, float frame_moves) {
  constexpr float kMemory = 0.5F;         // s
  constexpr float kLeastInterval = 1e-3F; // s
  constexpr float kLeastVariance = 1;     // grey levels squared
  constexpr float kFew = 10; // flat cells, that differ by chance: their brightness counts by half
  struct Brightness {
    float count = 0;
    float sum = 0;
    float squares = 0;
    void add(float luma) {
      ++count;
      sum += luma;
      squares += luma * luma;
    }
    float mean() const { return sum / std::max(count, 1.0F); }
    float variance() const { return squares / std::max(count, 1.0F) - mean() * mean(); }
  } moving, flat;
  for_cells(size_, [&](int x, int y) {
    const float luma = later().mean.at(x, y);
    if (calm_.rests().at(x, y) < 0)
      moving.add(luma);
    if (calm_.background().at(x, y) > 0)
      flat.add(luma);
  });
  const float share = moving.count / std::max(moving.count + flat.count, 1.0F);
  const float spread = std::sqrt(std::max(moving.variance() + flat.variance(), kLeastVariance));
  const float apart =
      std::abs(moving.mean() - flat.mean()) / spread * flat.count / (flat.count + kFew);
  const float move = ramp(share, 0.5F, 0.6F) * (1 - ramp(apart, 0.6F, 1)) * (1 - frame_moves);
  flat_parts_seen_ += std::max(seconds, kLeastInterval);
  // A mean over all pairs, as long as they are few.
  flat_parts_move_ += std::max(seconds / flat_parts_seen_, 1 - std::exp(-seconds / kMemory)) *
                      (move - flat_parts_move_);
}

void RegionLayers::judge(float noise) {
  constexpr float kHalf = 30; // trace that counts by half
  float unexplained = 0;
  float unexplained_after = 0;
  float all = 1;
  float before = 0;
  float after = 0;
  std::size_t count = 0;
  for_cells(size_, [&](int x, int y) {
    const float trace = later().cell_structure.xx.at(x, y) + later().cell_structure.yy.at(x, y);
    const float weight = trace / (trace + kHalf);
    all += weight;
    const float most = 6 + 2.4F * noise + 0.16F * trace;
    if (foreground_.energy_before().at(x, y) > most)
      unexplained += weight;
    if (foreground_.energy_after().at(x, y) > most)
      unexplained_after += weight;
    before += foreground_.energy_before().at(x, y);
    after += foreground_.energy_after().at(x, y);
    sorted_[count++] = foreground_.energy_after().at(x, y);
  });
  is_lost_ = unexplained > 0.5F * all;
  is_unexplained_ = unexplained_after > 0.5F * all;
  const auto cells = static_cast<float>(count);
  // Of two pictures that have nothing in common, the difference has the energy of both.
  const float expected = earlier().energy + later().energy;
  is_unrelated_ = expected > 16 + 4 * noise && before > 0.7F * expected * cells &&
                  after > 0.25F * expected * cells;
  // Where little moves, or what moves is followed well, noise alone is left. A quarter of the cells
  // of pure noise have less than 0.54 of its energy (sigma 1 to 4, with the part that the fit
  // takes).
  constexpr float kOfQuarter = 0.54F;
  const auto quarter = sorted_.begin() + static_cast<std::ptrdiff_t>(count / 4);
  std::nth_element(sorted_.begin(), quarter, sorted_.begin() + static_cast<std::ptrdiff_t>(count));
  noise_ = *quarter / (kOfQuarter * 2 * smoothed_noise());
}

bool RegionLayers::flat_parts_follow(Displacement by, float noise) {
  constexpr float kMostEnergy = 100; // grey levels squared: a leaf that passes is no evidence
  constexpr float kBeyondNoise = 0.5F;
  constexpr float kOfNoise = 0.15F;
  compare(earlier().smooth, later().smooth, size_, rest_energy_);
  compare_displaced(earlier().smooth, later().smooth, by, size_, moved_energy_);
  float rest = 0;
  float moved = 0;
  float cells = 0;
  for_cells(size_, [&](int x, int y) {
    if (calm_.background().at(x, y) <= 0 || !comes_from_inside(x, y, by, size_))
      return;
    rest += std::min(rest_energy_.at(x, y), kMostEnergy);
    moved += std::min(moved_energy_.at(x, y), kMostEnergy);
    ++cells;
  });
  // Displaced by parts of a pixel, a frame has less noise: with noise alone, it fits better.
  const float by_noise = smoothed_noise() * noise * cells;
  const float change = rest - 2 * by_noise;
  const float left = moved - (1 + noise_left(by)) * by_noise;
  return change - left > kOfNoise * 2 * by_noise + kBeyondNoise * std::max(0.0F, change);
}

void RegionLayers::sum(const Rectangle &region, int columns, int rows,
                       std::span<LayerTile> tiles) const {
  // Smoothing correlates the noise of neighbouring pixels: fewer of them are independent.
  constexpr float kCorrelation = 5;
  constexpr float kLeastResidual2 = 0.05F; // rounding to 8 bits
  constexpr float kBackgroundNoise = 1;    // of the mean of a cell, grey levels squared
  constexpr float kOfFrame = 100; // 1/px^2: the translation of the frame is right to 0.1 px
  constexpr std::size_t kMostTiles = 64;
  std::array<TileSums, kMostTiles> sums;
  const LayerFrame &frame = frames_[now_];
  sum_tiles(
      {frame, foreground_.flow(), background_motion_, segmentation_.share(), foreground_.term()},
      size_, region, columns, rows, sums);
  const float wide = static_cast<float>(region.width) / static_cast<float>(columns);
  const float high = static_cast<float>(region.height) / static_cast<float>(rows);
  const TensorMap<CellMap> &known = background_.structure();
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const std::size_t i = tile_at(row, columns, column);
      const TileSums &of = sums[i];
      const float moving = std::max(of.pixels - of.share, 1e-3F * of.pixels);
      const auto cell = [](int begin, float at, int cells) {
        return std::clamp(static_cast<int>((static_cast<float>(begin) + at) / kCellSide), 0,
                          cells - 1);
      };
      const int x = cell(region.x, (static_cast<float>(column) + 0.5F) * wide, size_.columns());
      const int y = cell(region.y, (static_cast<float>(row) + 0.5F) * high, size_.rows());
      LayerTile &tile = tiles[i];
      tile.residual2 = of.leftover / moving;
      tile.background = of.share / of.pixels;
      tile.precision =
          1 / (kCorrelation * std::max(tile.residual2, kLeastResidual2)) * of.structure;
      tile.precision +=
          of.share / (kCellSide * kCellSide * kBackgroundNoise) *
          beyond_noise({known.xx.at(x, y), known.xy.at(x, y), known.yy.at(x, y)}, noise_used_);
      const float by_frame = kOfFrame * frame_moves_ * calm_.shows().at(x, y) * tile.background;
      tile.precision += {by_frame, 0, by_frame};
      tile.displacement = 1 / of.pixels * of.motion;
      tile.displacement += blend_ * (frame_displacement_ - tile.displacement);
    }
}

} // namespace haptic
