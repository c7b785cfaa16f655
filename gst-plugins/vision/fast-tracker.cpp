// SPDX-License-Identifier: LGPL-2.1-or-later
// A ladder: each rung is climbed only when the one below does not explain the pixels.
//   1. nothing changed but noise
//   2. one translation of the whole region
//   3. a grid of patches, evenly spread so that their mean is the mean over the region
#include "block-translation.hpp"
#include "frame-change.hpp"
#include "patch-tracker.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <utility>

namespace haptic {
namespace {

constexpr int kIterations = 5; // most Gauss-Newton steps of the whole region at a level
constexpr int kSmallSide = 30; // px, the region of the paper
constexpr int kReach =
    20; // px per frame that the search covers there; what is larger moves further
constexpr int kLargestSide =
    128; // px; larger regions are averaged down first, so that the cost stays bounded

class FastTracker final : public PatchTracker {
public:
  explicit FastTracker(const FastTrackerOptions &options) : options_(options) {}
  int margin(int region_side) const override {
    const int reduced = reductions(region_side);
    return (reach(region_side >> reduced) + 2) << reduced;
  }
  void set_max_points(int max_points) override {
    max_points_ = std::clamp(max_points, 1, kMaxPatches);
  }
  void measure(const CropPair &pair, Measurement &measurement) override;
  void reset() override {
    have_previous_ = false;
    last_ = {};
    noise_ = kAssumedNoise * kAssumedNoise;
    expected_residual2_ = 2 * kSmoothedNoise * noise_;
  }

private:
  static int reductions(int side) {
    int count = 0;
    while ((side >> count) > kLargestSide)
      ++count;
    return count;
  }

  static int reach(int side) { return kReach * std::max(side, kSmallSide) / kSmallSide; }

  void measure_reduced(const CropPair &pair, Measurement &measurement);
  ChangeFinding change(const CropPair &pair) const;
  void take_frames(const CropPair &pair);
  void cover_with_blocks(const Area &area);
  Translation translate(Displacement start);
  Translation translate_level(std::size_t level, Displacement start, int iterations);
  Translation find_translation();
  void add_grid(const Area &area, const Translation &whole, Measurement &measurement);
  std::optional<Strain> strain_at(int row, int column, std::span<const Displacement> displacements,
                                  std::span<const Alignment> aligned) const;
  void follow_strain(std::span<Alignment> aligned);

  const FastTrackerOptions options_;
  int max_points_ = kUsualPatches;
  bool have_previous_ = false; // current_ holds the frame that comes next as the earlier one
  Rectangle last_crop_;
  Pyramid previous_;
  Pyramid current_;
  int side_ = 0; // px, of the region
  std::size_t built_levels_ = 0;
  std::size_t levels_ = 1; // of the pyramids that are large enough to be of use
  std::array<PatchGrid, kMostLevels> blocks_;
  PatchGrid coarse_grid_;
  PatchGrid grid_;
  Template strained_;
  std::array<ByteImage, 2> reduced_previous_;
  std::array<ByteImage, 2> reduced_current_;
  Displacement last_;                           // px, of the frame before
  float noise_ = kAssumedNoise * kAssumedNoise; // variance of a pixel, learned from still frames
  float expected_residual2_ = 2 * kSmoothedNoise * noise_; // grey levels squared, of what fits
  float trust_ = 0; // sum over the grid's patches that have texture, 0..1 each
};

ChangeFinding FastTracker::change(const CropPair &pair) const {
  const std::ptrdiff_t x = pair.region.x - pair.crop.x;
  const std::ptrdiff_t y = pair.region.y - pair.crop.y;
  const auto inside = [&](const LumaView &view) {
    return LumaView{view.pixels + y * view.stride + x, pair.region.width, pair.region.height,
                    view.stride};
  };
  return find_change(inside(pair.previous), inside(pair.current), noise_);
}

void FastTracker::take_frames(const CropPair &pair) {
  // A level more for each doubling of the region: its largest displacement doubles too.
  side_ = std::max(pair.region.width, pair.region.height);
  const int doublings = std::bit_width(static_cast<unsigned>(std::max(side_ / kSmallSide, 1))) - 1;
  const auto wanted = static_cast<std::size_t>(std::min(options_.levels + doublings, kMostLevels));
  if (pair.continues && have_previous_ && pair.crop == last_crop_ && wanted == built_levels_)
    std::swap(previous_, current_);
  else
    previous_.build(pair.previous, wanted);
  current_.build(pair.current, wanted);
  built_levels_ = wanted;
  have_previous_ = true;
  last_crop_ = pair.crop;
  levels_ = 1;
  while (levels_ < wanted && fits_into(previous_.levels[levels_], kSmallPatch))
    ++levels_;
}

void FastTracker::cover_with_blocks(const Area &area) {
  for (std::size_t level = 0; level < levels_; ++level) {
    const Area a = area.at_level(static_cast<int>(level));
    const bool large = std::min(a.width, a.height) >= (level > 0 ? 12.0F : 24.0F) &&
                       fits_into(previous_.levels[level], kLargePatch);
    const int side = large ? kLargePatch : kSmallPatch;
    const auto length = static_cast<float>(side);
    blocks_[level].cover(previous_.levels[level], a, parts_of(a.width, length, 8),
                         parts_of(a.height, length, 8), side, level == 0);
  }
}

Translation FastTracker::translate_level(std::size_t level, Displacement start, int iterations) {
  return translate_blocks(current_.levels[level], blocks_[level].view(), start, iterations, noise_,
                          level == 0);
}

Translation FastTracker::translate(Displacement start) {
  Translation t;
  t.displacement = 1 / static_cast<float>(1 << levels_) * start;
  for (std::size_t level = levels_; level-- > 0;)
    t = translate_level(level, 2 * t.displacement, kIterations);
  return t;
}

Translation FastTracker::find_translation() {
  constexpr float kGood = 0.8F;
  constexpr float kClearlyBetter = 0.1F;
  Translation whole = translate(last_);
  if (whole.correlation >= kGood)
    return whole;
  const std::size_t coarsest = levels_ - 1;
  const auto blocks = blocks_[coarsest].view();
  const SearchResult found = search_template(current_.levels[coarsest], blocks[blocks.size() / 2],
                                             {}, (reach(side_) >> coarsest) + 1);
  const Translation other = translate(static_cast<float>(1 << coarsest) * found.best);
  return other.correlation > whole.correlation + kClearlyBetter ? other : whole;
}

void FastTracker::add_grid(const Area &area, const Translation &whole, Measurement &measurement) {
  constexpr float kCoarseSpacing = 5; // px of the half-size frame
  constexpr float kSame2 = 1.0F;      // px squared between starts that are not worth telling apart

  const std::size_t coarse_level = levels_ > 1 ? 1 : 0;
  const auto coarse_scale = static_cast<float>(1 << coarse_level);
  const Area half = area.at_level(static_cast<int>(coarse_level));
  const int coarse_columns = parts_of(half.width, kCoarseSpacing, 8);
  const int coarse_rows = parts_of(half.height, kCoarseSpacing, 8);
  coarse_grid_.cover(previous_.levels[coarse_level], half, coarse_columns, coarse_rows, kSmallPatch,
                     coarse_level == 0);
  std::array<Displacement, kMaxPatches> coarse;
  const std::array<Displacement, 2> coarse_starts = {1 / coarse_scale * whole.displacement,
                                                     Displacement{}};
  for (std::size_t i = 0; i < coarse_grid_.view().size(); ++i)
    coarse[i] =
        coarse_scale * align_template(current_.levels[coarse_level], coarse_grid_.patches[i],
                                      coarse_starts, options_.iterations)
                           .displacement;

  trust_ = 0;
  int columns = parts_of(area.width, options_.spacing, 8);
  int rows = parts_of(area.height, options_.spacing, 8);
  while (columns * rows > max_points_)
    --(columns > rows ? columns : rows);
  const bool sparse = std::max(area.width / static_cast<float>(columns),
                               area.height / static_cast<float>(rows)) > 9;
  const int side =
      sparse && fits_into(previous_.levels[0], kLargePatch) ? kLargePatch : kSmallPatch;
  grid_.cover(previous_.levels[0], area, columns, rows, side, true);
  std::array<Alignment, kMaxPatches> aligned;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int parent_x = (2 * i + 1) * coarse_columns / (2 * columns);
      const int parent_y = (2 * j + 1) * coarse_rows / (2 * rows);
      std::array<Displacement, 10> starts;
      std::size_t count = 0;
      const auto offer = [&](int x, int y) {
        const Displacement start = coarse[cell(y, coarse_columns, x)];
        if (std::ranges::none_of(std::span(starts).first(count),
                                 [&](Displacement other) { return norm2(other - start) < kSame2; }))
          starts[count++] = start;
      };
      offer(parent_x, parent_y);
      for (int y = std::max(0, parent_y - 1); y <= std::min(coarse_rows - 1, parent_y + 1); ++y)
        for (int x = std::max(0, parent_x - 1); x <= std::min(coarse_columns - 1, parent_x + 1);
             ++x)
          offer(x, y);
      const Template &patch = grid_.patches[cell(j, columns, i)];
      aligned[cell(j, columns, i)] = align_template(
          current_.levels[0], patch, std::span(starts).first(count), options_.iterations);
    }
  // Beside the border of an object, a patch may have followed the wrong side.
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      Alignment &own = aligned[cell(j, columns, i)];
      std::array<Displacement, 5> starts = {own.displacement};
      std::size_t count = 1;
      const auto offer = [&](int x, int y) {
        if (x < 0 || x >= columns || y < 0 || y >= rows)
          return;
        const Displacement start = aligned[cell(y, columns, x)].displacement;
        if (norm2(own.displacement - start) > kSame2)
          starts[count++] = start;
      };
      offer(i - 1, j);
      offer(i + 1, j);
      offer(i, j - 1);
      offer(i, j + 1);
      const Template &patch = grid_.patches[cell(j, columns, i)];
      if (count > 1)
        own = align_template(current_.levels[0], patch, std::span(starts).first(count),
                             options_.iterations);
    }
  follow_strain(aligned);
  for (std::size_t i = 0; i < grid_.view().size(); ++i)
    trust_ +=
        add_patch(grid_.patches[i], aligned[i].displacement, aligned[i].fit, noise_, measurement);
}

// What the neighbours of a patch tell of the strain there; nothing where there is none, and beside
// another motion, where nobody knows.
std::optional<Strain> FastTracker::strain_at(int row, int column,
                                             std::span<const Displacement> displacements,
                                             std::span<const Alignment> aligned) const {
  constexpr float kSignificant = 0.03F; // px per px: less moves no corner of a patch noticeably
  constexpr float kLargest = 0.25F;     // neighbours that differ by more move on their own
  constexpr float kPrior = 0.5F;        // in neighbours: without them there is no strain
  const std::size_t at = cell(row, grid_.columns, column);
  const Template &patch = grid_.patches[at];
  const float prior = kPrior * static_cast<float>(patch.side * patch.side);
  Tensor offsets{prior, 0, prior};
  Displacement x_moved;
  Displacement y_moved;
  for (int y = std::max(0, row - 1); y <= std::min(grid_.rows - 1, row + 1); ++y)
    for (int x = std::max(0, column - 1); x <= std::min(grid_.columns - 1, column + 1); ++x) {
      const std::size_t other = cell(y, grid_.columns, x);
      if (other == at || !aligned[other].fit.inside)
        continue;
      const Displacement away{grid_.patches[other].x - patch.x, grid_.patches[other].y - patch.y};
      const Displacement moved = displacements[other] - displacements[at];
      if (norm2(moved) > kLargest * kLargest * norm2(away))
        return {};
      offsets += {away.x * away.x, away.x * away.y, away.y * away.y};
      x_moved = x_moved + moved.x * away;
      y_moved = y_moved + moved.y * away;
    }
  const Displacement of_x = solve(offsets, x_moved, 0);
  const Displacement of_y = solve(offsets, y_moved, 0);
  if (norm2(of_x) + norm2(of_y) < kSignificant * kSignificant)
    return {};
  return Strain{of_x.x, of_x.y, of_y.x, of_y.y};
}

// A patch that only shifts does not fit what turns or is stretched.
void FastTracker::follow_strain(std::span<Alignment> aligned) {
  constexpr float kBetter = 0.95F; // of the residual, else the strain was none
  std::array<Displacement, kMaxPatches> before;
  for (std::size_t i = 0; i < grid_.view().size(); ++i)
    before[i] = aligned[i].displacement;
  for (int row = 0; row < grid_.rows; ++row)
    for (int column = 0; column < grid_.columns; ++column) {
      const auto strain = strain_at(row, column, before, aligned);
      if (!strain)
        continue;
      const std::size_t at = cell(row, grid_.columns, column);
      Template &patch = grid_.patches[at];
      strained_.x = patch.x;
      strained_.y = patch.y;
      strained_.side = patch.side;
      prepare_strained_template(previous_.levels[0], *strain, strained_);
      const Alignment better =
          align_template(current_.levels[0], strained_, {&before[at], 1}, options_.iterations);
      if (better.fit.residual < kBetter * aligned[at].fit.residual) {
        patch = strained_;
        aligned[at] = better;
      }
    }
}

void FastTracker::measure_reduced(const CropPair &pair, Measurement &measurement) {
  constexpr float kOverExpected = 1.2F;
  constexpr float kSameScene = 0.5F;
  // Patches of the same scene come close to 1 in the mean, those of another scene stay below.
  constexpr float kLeastTrust = 0.6F;
  if (!pair.continues)
    last_ = {};
  const auto [changed, energy] = change(pair);
  switch (changed) {
  case Change::none:
  case Change::unseen:
    if (changed == Change::none)
      measurement.flags = kStill;
    have_previous_ = false;
    last_ = {};
    return;
  case Change::some:
    break;
  }
  take_frames(pair);
  const Area area{static_cast<float>(pair.region.x - pair.crop.x - kSmoothingRadius),
                  static_cast<float>(pair.region.y - pair.crop.y - kSmoothingRadius),
                  static_cast<float>(pair.region.width), static_cast<float>(pair.region.height)};
  cover_with_blocks(area);
  Translation whole = find_translation();
  if (const float repeats = whole.one_direction ? 0
                                                : period(previous_.levels[0], blocks_[0].view(),
                                                         static_cast<float>(2 * reach(side_)));
      repeats > 0) {
    // Only the motion before can tell, and at first that slow motion is likelier than fast.
    whole = translate_level(0, last_, kIterations);
    if (norm2(whole.displacement - last_) > repeats * repeats / 16) {
      measurement.candidates = 1;
      last_ = {};
      return;
    }
  }
  last_ = whole.displacement;
  const bool explained = explains(whole, blocks_[0].patches[0].side, noise_);
  if (explained && is_still(whole)) {
    constexpr float kLearning = 0.3F;
    measurement.flags = kStill;
    noise_ += kLearning * (std::clamp(energy / 2, 0.25F, 150.0F) - noise_);
    return;
  }
  if (explained && !options_.always_grid && is_precise(whole) &&
      whole.residual2 < kOverExpected * expected_residual2_ + whole.interpolation2) {
    measurement.candidates = 1;
    measurement.add(patch_of(area, whole));
    return;
  }
  add_grid(area, whole, measurement);
  if (trust_ < kLeastTrust * static_cast<float>(measurement.candidates)) {
    if (whole.correlation < kSameScene)
      measurement.flags |= kCut;
    measurement.count = 0;
    last_ = {};
  }
}

void FastTracker::measure(const CropPair &pair, Measurement &measurement) {
  measurement.clear();
  const int count = reductions(std::max(pair.region.width, pair.region.height));
  CropPair reduced = pair;
  for (int i = 0; i < count; ++i) {
    const auto slot = static_cast<std::size_t>(i & 1);
    average_pairs(reduced.previous, reduced_previous_[slot]);
    average_pairs(reduced.current, reduced_current_[slot]);
    reduced.previous = reduced_previous_[slot].view();
    reduced.current = reduced_current_[slot].view();
  }
  if (count > 0) {
    // The corner of the crop stays: it need not lie on a multiple of the reduction.
    const int scale = 1 << count;
    reduced.crop = {pair.crop.x, pair.crop.y, reduced.previous.width, reduced.previous.height};
    reduced.region = {pair.crop.x + (pair.region.x - pair.crop.x) / scale,
                      pair.crop.y + (pair.region.y - pair.crop.y) / scale,
                      pair.region.width / scale, pair.region.height / scale};
  }
  // A strip along a frame's border may have become too narrow for patches.
  const auto least = [](const Rectangle &r) { return std::min(r.width, r.height); };
  if (least(reduced.region) < kSmallestRegion / 2 ||
      least(reduced.crop) < kSmallPatch + kRim + 2 * kSmoothingRadius)
    return;
  measure_reduced(reduced, measurement);

  const auto scale = static_cast<float>(1 << count);
  for (int i = 0; i < measurement.count; ++i) {
    Patch &patch = measurement.patches[static_cast<std::size_t>(i)];
    patch.x += kSmoothingRadius;
    patch.y += kSmoothingRadius;
    for (float *length : {&patch.x, &patch.y, &patch.width, &patch.height, &patch.dx, &patch.dy})
      *length *= scale;
    for (float *precision : {&patch.precision_xx, &patch.precision_xy, &patch.precision_yy})
      *precision /= scale * scale;
    patch.x += static_cast<float>(pair.crop.x);
    patch.y += static_cast<float>(pair.crop.y);
  }
}

} // namespace

std::unique_ptr<PatchTracker> make_fast_tracker(const FastTrackerOptions &options) {
  return std::make_unique<FastTracker>(options);
}

} // namespace haptic
