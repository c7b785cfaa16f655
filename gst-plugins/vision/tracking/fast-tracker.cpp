// SPDX-License-Identifier: LGPL-2.1-or-later
// Tries four explanations of the pixels, the cheapest first, and stops at the first that fits:
//   1. nothing changed but noise
//   2. one translation of the whole region
//   3. two translations, side by side
//   4. a grid of patches, evenly spread, so that their mean is the mean over the region
#include "patches/clipped-pixels.hpp"
#include "patches/grid-motions.hpp"
#include "patches/pixel-motions.hpp"
#include "patches/pixel-votes.hpp"
#include "patches/start-set.hpp"
#include "patches/texture-period.hpp"
#include "pixels/frame-change.hpp"
#include "pixels/frame-reduction.hpp"
#include "samples/region-size.hpp"
#include "tracking/ladder.hpp"
#include "tracking/noise-estimate.hpp"
#include "tracking/sudden-change.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace haptic {
namespace {

constexpr int kReach = 20;        // px per frame that a search covers in a region of kPaperSide
constexpr int kLargestSide = 128; // px; larger regions are reduced first, which bounds the cost
constexpr float kLearningRate = 0.3F;

class FastTracker final : public Ladder {
public:
  explicit FastTracker(const FastTrackerOptions &options) : options_(options) { forget(0); }
  int margin(int region_side) const override {
    const int reduced = reductions(region_side);
    return (reach(region_side >> reduced) + 2) << reduced;
  }
  void set_max_points(int max_points) override {
    max_points_ = std::clamp(max_points, 1, kMaxPatches);
  }
  void measure(const CropPair &pair, Measurement &measurement) override;
  Explanation measure_simply(const CropPair &pair, Measurement &measurement) override;
  void measure_rest(Measurement &measurement) override;
  Displacement best_translation() const override {
    return static_cast<float>(1 << reductions_) * whole_.displacement;
  }
  void reset() override { forget(reductions_); }

private:
  const TrackerParts &parts() const { return options_.parts; }

  static int reductions(int side) {
    int count = 0;
    while ((side >> count) > kLargestSide)
      ++count;
    return count;
  }

  static int reach(int side) { return kReach * std::max(side, kPaperSide) / kPaperSide; }

  void forget(int reductions);
  CropPair reduced(const CropPair &pair, int count);
  Explanation explain_simply(const CropPair &pair, Measurement &measurement);
  void measure_reduced(const CropPair &pair, Measurement &measurement);
  void place(Measurement &measurement) const;
  void measure_grid(const Area &area, const Translation &whole, Measurement &measurement);
  bool has_fields(const CropPair &pair, int reductions) const;
  void measure_fields(const CropPair &pair, int reductions, Measurement &measurement);
  ChangeFinding region_change(const CropPair &pair) const;
  void build_pyramids(const CropPair &pair);
  void cover_with_blocks(const Area &area);
  void mask_blocks();
  Translation translate(Displacement start);
  Translation translate_level(std::size_t level, Displacement start, int iterations);
  Translation find_translation();
  float add_grid(const Area &area, const Translation &whole, Measurement &measurement);
  float add_patches(const PatchGrid &grid, float scale, Measurement &measurement);
  std::size_t coarse_level() const { return levels_ > 1 ? 1 : 0; }
  float coarse_scale() const { return static_cast<float>(1 << coarse_level()); }
  void keep_coarse();
  void align_coarse_grid(const Area &area, Displacement whole);
  void cover_with_grid(const Area &area);
  void align_grid();
  void realign_at_borders();
  void align_along(const BentMotion &motion, const Plane &later, std::span<const Template> patches);
  bool follow_bend();
  void follow_strain();
  void learn_from_grid();
  bool neighbours_are_apart() const;
  bool is_within_reach(Displacement displacement) const;
  std::size_t level_of_pixels() const;
  float count_votes(const Area &area, Measurement &measurement);
  float label_scale() const { return static_cast<float>(1 << level_of_pixels()); }
  bool label_from_coarse(const Area &area, Measurement &measurement);
  bool label_from_grid(const Area &area, Measurement &measurement);
  std::optional<TwoMotions> find_labels(const Area &area, std::span<const Patch> patches);
  bool explain_as_well(std::span<const Patch> patches) const;
  bool follow_labels(const TwoMotions &motions, std::span<Patch> patches) const;
  void separate_layers(const Area &area, float unexplained, Translation whole,
                       Measurement &measurement);

  const FastTrackerOptions options_;
  int max_points_ = kUsualPatches;
  int reductions_ = 0;         // of the frames
  bool have_previous_ = false; // current_ holds the earlier frame of the next pair
  Rectangle last_crop_;
  Rectangle crop_; // of the pair in hand, before any reduction
  Area area_;      // its region, in the planes
  Translation whole_;
  Pyramid previous_;
  Pyramid current_;
  int side_ = 0; // px, of the region
  std::size_t built_levels_ = 0;
  std::size_t levels_ = 1; // of the pyramids that are large enough for a patch
  std::array<PatchGrid, kMostLevels> blocks_;
  PatchGrid coarse_grid_;
  std::array<Displacement, kMaxPatches> coarse_; // of coarse_grid_, px of the finest level
  PatchGrid grid_;
  std::array<Alignment, kMaxPatches> aligned_;   // of grid_, or of coarse_grid_ before it
  std::array<Displacement, kMaxPatches> before_; // the alignment
  bool is_explained_ = false; // by one motion of all patches, or two of the pixels
  std::array<StartSet, kMaxPatches> start_sets_;
  std::array<std::span<const Displacement>, kMaxPatches> starts_;
  std::array<float, kMaxPatches> residuals2_;
  ClippedPixels clipped_; // of the earlier frame
  PixelVotes votes_;
  MotionLabels labels_;
  FrameReduction previous_reduction_;
  FrameReduction current_reduction_;
  SuddenChange sudden_;
  Displacement last_;                      // px, between the two frames before
  NoiseEstimate noise_{kLearningRate};     // of a scene at rest
  NoiseEstimate fit_noise_{kLearningRate}; // of what fits, also while it moves
};

// The region of one of the views.
LumaView inside(const CropPair &pair, const LumaView &view) {
  return part_of(view, {pair.region.x - pair.crop.x, pair.region.y - pair.crop.y, pair.region.width,
                        pair.region.height});
}

// After so many reductions.
bool is_wide_enough(const CropPair &pair, int reductions) {
  const auto least = [&](const Rectangle &r) { return std::min(r.width, r.height) >> reductions; };
  return least(pair.region) >= kSmallestRegion / 2 &&
         least(pair.crop) >= kSmallPatch + kRim + 2 * kSmoothingRadius;
}

// Every other row from row `parity` on.
CropPair field_of(const CropPair &pair, int parity) {
  const auto field = [&](const LumaView &view) {
    return LumaView{view.pixels + parity * view.stride, view.width, view.height / 2,
                    2 * view.stride};
  };
  CropPair fields = pair;
  fields.previous = field(pair.previous);
  fields.current = field(pair.current);
  fields.crop.height = pair.crop.height / 2;
  fields.region.y = pair.crop.y + (pair.region.y - pair.crop.y) / 2;
  fields.region.height = pair.region.height / 2;
  return fields;
}

// Begins anew, with frames that are reduced so many times.
void FastTracker::forget(int reductions) {
  reductions_ = reductions;
  have_previous_ = false;
  last_ = {};
  sudden_ = {};
  noise_.reset(assumed_variance(reductions), kRoundingVariance);
  fit_noise_.reset(assumed_variance(reductions), assumed_variance(reductions));
}

ChangeFinding FastTracker::region_change(const CropPair &pair) const {
  return find_change(inside(pair, pair.previous), inside(pair, pair.current), noise_.variance());
}

void FastTracker::build_pyramids(const CropPair &pair) {
  // One level more for each doubling of the region: its largest displacement doubles too.
  side_ = std::max(pair.region.width, pair.region.height);
  const auto wanted =
      static_cast<std::size_t>(std::min(options_.levels + doublings(side_), kMostLevels));
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
    blocks_[level].cover(previous_.levels[level], a, parts_of(a.width, length),
                         parts_of(a.height, length), side, level == 0);
  }
}

// Clipped pixels have no weight, unless the others show nothing: what is black and white moves too.
void FastTracker::mask_blocks() {
  const auto blocks = blocks_[0].view();
  Tensor structure;
  float pixels = 0;
  for (Template &block : blocks) {
    clipped_.mask(block);
    structure += block.structure;
    pixels += static_cast<float>(block.side * block.side);
  }
  if (has_texture(eigenvalues(structure).least, pixels, noise_.variance()))
    return;
  clipped_.forget();
  prepare_templates(previous_.levels[0], blocks);
}

Translation FastTracker::translate_level(std::size_t level, Displacement start, int iterations) {
  return translate_blocks(current_.levels[level], blocks_[level].view(), start, iterations,
                          noise_.variance(), level == 0);
}

Translation FastTracker::translate(Displacement start) {
  Translation t;
  t.displacement = 1 / static_cast<float>(1 << levels_) * start;
  for (std::size_t level = levels_; level-- > 0;)
    t = translate_level(level, 2 * t.displacement, kMostSteps);
  return t;
}

Translation FastTracker::find_translation() {
  Translation whole = translate(parts().prior ? last_ : Displacement{});
  if (is_found(whole.correlation) || !parts().search)
    return whole;
  const std::size_t coarsest = levels_ - 1;
  const auto blocks = blocks_[coarsest].view();
  const SearchResult found = search_template(current_.levels[coarsest], blocks[blocks.size() / 2],
                                             {}, (reach(side_) >> coarsest) + 1);
  if (are_close(found.best, 1 / static_cast<float>(1 << coarsest) * whole.displacement))
    return whole;
  const Translation other = translate(static_cast<float>(1 << coarsest) * found.best);
  return is_clearly_better(other.correlation, whole.correlation) ? other : whole;
}

void FastTracker::align_coarse_grid(const Area &area, Displacement whole) {
  constexpr float kSpacing = 5; // px of the half-size frame
  const std::size_t level = coarse_level();
  const float scale = coarse_scale();
  const Area half = area.at_level(static_cast<int>(level));
  coarse_grid_.cover(previous_.levels[level], half, parts_of(half.width, kSpacing),
                     parts_of(half.height, kSpacing), kSmallPatch, level == 0 && parts().dither);
  const std::array<Displacement, 2> starts = {1 / scale * whole, Displacement{}};
  const auto patches = coarse_grid_.view();
  std::fill_n(starts_.begin(), patches.size(), starts);
  std::fill_n(aligned_.begin(), patches.size(), Alignment{});
  align_templates(current_.levels[level], patches, std::span(starts_).first(patches.size()),
                  options_.iterations, aligned_);
  keep_coarse();
}

void FastTracker::keep_coarse() {
  const float scale = coarse_scale();
  for (std::size_t i = 0; i < coarse_grid_.view().size(); ++i)
    coarse_[i] = scale * aligned_[i].displacement;
}

void FastTracker::cover_with_grid(const Area &area) {
  constexpr float kSparse = 9; // px between patches, from which on large ones are used
  int columns = parts_of(area.width, options_.spacing);
  int rows = parts_of(area.height, options_.spacing);
  while (columns * rows > max_points_)
    --(columns > rows ? columns : rows);
  const bool sparse = std::max(area.width / static_cast<float>(columns),
                               area.height / static_cast<float>(rows)) > kSparse;
  const int side =
      sparse && fits_into(previous_.levels[0], kLargePatch) ? kLargePatch : kSmallPatch;
  grid_.cover(previous_.levels[0], area, columns, rows, side, parts().dither);
  if (clipped_.any())
    for (Template &patch : grid_.view())
      clipped_.mask(patch);
}

// Starts from the coarse patches around each patch, the nearest one first.
void FastTracker::align_grid() {
  for_places(grid_, [&](int row, int column) {
    const int coarse_row = nearest_part(row, grid_.rows, coarse_grid_.rows);
    const int coarse_column = nearest_part(column, grid_.columns, coarse_grid_.columns);
    StartSet &starts = start_sets_[cell(row, grid_.columns, column)];
    const auto add = [&](int y, int x) { starts.add(coarse_[cell(y, coarse_grid_.columns, x)]); };
    starts.clear();
    add(coarse_row, coarse_column);
    for_neighbours(coarse_grid_, coarse_row, coarse_column, add);
    starts_[cell(row, grid_.columns, column)] = starts.view();
  });
  const auto patches = grid_.view();
  std::fill_n(aligned_.begin(), patches.size(), Alignment{});
  align_templates(current_.levels[0], patches, std::span(starts_).first(patches.size()),
                  options_.iterations, aligned_);
}

// At the border of an object, a patch may have followed the wrong side. Its neighbours show the
// other side, those before it as realigned.
void FastTracker::realign_at_borders() {
  for_places(grid_, [&](int row, int column) {
    const std::size_t at = cell(row, grid_.columns, column);
    Alignment &own = aligned_[at];
    std::array<Displacement, 5> starts = {own.displacement};
    std::size_t count = 1;
    const auto add = [&](int y, int x) {
      if (x < 0 || x >= grid_.columns || y < 0 || y >= grid_.rows)
        return;
      const Displacement start = aligned_[cell(y, grid_.columns, x)].displacement;
      if (!are_close(own.displacement, start))
        starts[count++] = start;
    };
    add(row, column - 1);
    add(row, column + 1);
    add(row - 1, column);
    add(row + 1, column);
    if (count > 1)
      own = align_template(current_.levels[0], grid_.patches[at], std::span(starts).first(count),
                           options_.iterations);
  });
}

// A patch that only shifts does not fit what turns or is stretched.
void FastTracker::follow_strain() {
  constexpr float kBetter = 0.95F; // of the residual, else there was no strain
  for (std::size_t i = 0; i < grid_.view().size(); ++i)
    before_[i] = aligned_[i].displacement;
  for_places(grid_, [&](int row, int column) {
    const auto strain = strain_at(grid_, row, column, aligned_, before_);
    if (!strain)
      return;
    const std::size_t at = cell(row, grid_.columns, column);
    const Alignment better = align_strained(current_.levels[0], grid_.patches[at], *strain,
                                            before_[at], options_.iterations);
    if (better.fit.residual < kBetter * aligned_[at].fit.residual)
      aligned_[at] = better;
  });
}

// Aligns the patches from where the motion puts each, strained as it is.
void FastTracker::align_along(const BentMotion &motion, const Plane &later,
                              std::span<const Template> patches) {
  for (std::size_t i = 0; i < patches.size(); ++i) {
    before_[i] = motion.at(middle_of(patches[i]));
    starts_[i] = {&before_[i], 1};
  }
  std::fill_n(aligned_.begin(), patches.size(), Alignment{});
  align_templates(later, patches, std::span(starts_).first(patches.size()), options_.iterations,
                  aligned_, motion.is_bent() ? &motion.strain : nullptr);
}

// One affine motion of the coarse patches, and then of those of the grid. Where it bends them, the
// coarse ones are aligned again. Returns whether all but one patch follow it.
bool FastTracker::follow_bend() {
  constexpr float kRoughly = 1;   // px: without strain, patches err
  constexpr float kNearly = 0.3F; // px
  constexpr int kApart = 1;       // patches
  const auto coarse = coarse_grid_.view();
  const std::size_t level = coarse_level();
  const float scale = coarse_scale();
  auto motion = find_bent_motion(coarse, aligned_, kRoughly / scale);
  if (!motion)
    return false;
  if (motion->is_bent()) {
    align_along(*motion, current_.levels[level], coarse);
    keep_coarse();
  }
  motion = find_bent_motion(coarse, aligned_, kNearly / scale);
  if (!motion)
    return false;
  const auto patches = grid_.view();
  align_along(motion->finer(scale), current_.levels[0], patches);
  int apart = 0;
  for (std::size_t i = 0; i < patches.size(); ++i)
    apart +=
        !aligned_[i].fit.inside || norm2(aligned_[i].displacement - before_[i]) > kNearly * kNearly;
  return apart <= kApart;
}

// The residuals of patches that fit are alike, and then they are noise. Others show what no patch
// follows, and say nothing.
void FastTracker::learn_from_grid() {
  constexpr float kAlike = 2.5F; // the residual of a patch varies by a quarter, of 64 pixels
  const auto squares = residuals2_.begin();
  std::size_t count = 0;
  for (std::size_t i = 0; i < grid_.view().size(); ++i)
    if (const Fit &fit = aligned_[i].fit; fit.inside)
      residuals2_[count++] = fit.residual * fit.residual;
  constexpr std::size_t kFew = 8;
  if (count < kFew)
    return;
  const auto end = squares + static_cast<std::ptrdiff_t>(count);
  const auto low = squares + static_cast<std::ptrdiff_t>(count / 5);
  const auto high = squares + static_cast<std::ptrdiff_t>(count - 1 - count / 5);
  std::nth_element(squares, low, end);
  std::nth_element(low, high, end);
  if (*high < kAlike * *low)
    fit_noise_.learn(noise_of(*low + *high)); // twice that of their mean
}

// Whether two neighbours follow different things, so that it matters how much of the region each
// is. Patches without trust count: many of them lie on a border of two things.
bool FastTracker::neighbours_are_apart() const {
  const auto differ = [&](std::size_t a, std::size_t b) {
    return !are_close(aligned_[a].displacement, aligned_[b].displacement);
  };
  bool apart = false;
  for_places(grid_, [&](int row, int column) {
    const std::size_t at = cell(row, grid_.columns, column);
    apart = apart || (column > 0 && differ(at, at - 1)) ||
            (row > 0 && differ(at, cell(row - 1, grid_.columns, column)));
  });
  return apart;
}

bool FastTracker::is_within_reach(Displacement displacement) const {
  const auto furthest = static_cast<float>(reach(side_));
  return std::max(std::abs(displacement.x), std::abs(displacement.y)) <= furthest;
}

// Returns the sum of the trust in the patches that have texture.
float FastTracker::add_grid(const Area &area, const Translation &whole, Measurement &measurement) {
  constexpr float kOneMotion = 0.96F; // correlation of the whole region: light changes the rest
  const bool may_hold_two = parts().labels && whole.correlation <= kOneMotion && !clipped_.any();
  is_explained_ = false;
  if (parts().coarse_starts) {
    align_coarse_grid(area, whole.displacement);
  } else {
    coarse_grid_.columns = coarse_grid_.rows = 1;
    coarse_[0] = whole.displacement;
  }
  // Returns the trust if the pixels follow two motions.
  const auto labelled = [&](const PatchGrid &grid, float scale,
                            auto label) -> std::optional<float> {
    const float trust = add_patches(grid, scale, measurement);
    is_explained_ =
        is_same_scene(trust, measurement.candidates) && (this->*label)(area, measurement);
    if (is_explained_)
      return trust;
    measurement.clear();
    return {};
  };
  if (may_hold_two && parts().coarse_starts)
    if (const auto trust = labelled(coarse_grid_, coarse_scale(), &FastTracker::label_from_coarse))
      return *trust;
  cover_with_grid(area);
  if (parts().bend && parts().coarse_starts && follow_bend()) {
    is_explained_ = true;
  } else {
    align_grid();
    if (may_hold_two && neighbours_are_apart())
      if (const auto trust = labelled(grid_, 1, &FastTracker::label_from_grid))
        return *trust;
    if (parts().second_pass)
      realign_at_borders();
    if (parts().strain)
      follow_strain();
  }
  if (parts().noise_of_fits)
    learn_from_grid();
  return add_patches(grid_, 1, measurement);
}

// The patches of a grid as aligned, in the pixels of a plane that is `scale` times as large.
// Returns the sum of the trust in those that have texture.
float FastTracker::add_patches(const PatchGrid &grid, float scale, Measurement &measurement) {
  if (!parts().trust)
    for (Alignment &aligned : aligned_)
      aligned.fit.correlation = 1;
  float trust = 0;
  for (std::size_t i = 0; i < grid.count(); ++i) {
    // Nothing was searched there: the steps of a patch ran away to what looks alike.
    if (!is_within_reach(scale * aligned_[i].displacement))
      aligned_[i].fit.inside = false;
    trust += add_patch(grid.patches[i], aligned_[i], noise_.variance(), measurement);
  }
  measurement.scale(scale);
  return trust;
}

void FastTracker::measure_grid(const Area &area, const Translation &whole,
                               Measurement &measurement) {
  constexpr float kSameScene = 0.5F; // correlation of the whole region
  const float trust = add_grid(area, whole, measurement);
  // No patch has texture: that none of them moved says nothing.
  if (measurement.candidates == 0) {
    measurement.clear();
    return;
  }
  if (parts().cut && !is_same_scene(trust, measurement.candidates)) {
    if (whole.correlation < kSameScene)
      measurement.flags |= kCut;
    measurement.count = 0;
    last_ = {};
  } else if (parts().votes && !is_explained_ && neighbours_are_apart()) {
    const float unexplained = count_votes(area, measurement);
    if (parts().layers)
      separate_layers(area, unexplained, whole, measurement);
  }
}

Explanation FastTracker::explain_simply(const CropPair &pair, Measurement &measurement) {
  constexpr float kOverExpected = 1.2F;
  if (!pair.continues)
    last_ = {};
  const auto [change, energy] = region_change(pair);
  const bool is_sudden = sudden_.add(energy) && parts().sudden;
  if (change != Change::some && parts().still_pixels) {
    if (change == Change::none)
      measurement.flags = kStill;
    have_previous_ = false;
    last_ = {};
    return change == Change::none ? Explanation::rest : Explanation::unseen;
  }
  if (is_sudden) {
    measurement.candidates = 1;
    have_previous_ = false;
    last_ = {};
    return Explanation::sudden;
  }
  build_pyramids(pair);
  area_ = Area{static_cast<float>(pair.region.x - pair.crop.x),
               static_cast<float>(pair.region.y - pair.crop.y),
               static_cast<float>(pair.region.width), static_cast<float>(pair.region.height)}
              .in_plane();
  cover_with_blocks(area_);
  clipped_.find(pair.previous, area_);
  if (clipped_.any())
    mask_blocks();
  whole_ = find_translation();
  if (parts().period &&
      !resolve_period(previous_.levels[0], current_.levels[0], blocks_[0].view(),
                      static_cast<float>(2 * reach(side_)), last_, noise_.variance(), whole_)) {
    measurement.candidates = 1;
    last_ = {};
    return Explanation::periodic;
  }
  last_ = whole_.displacement;
  const bool explained = explains(whole_, blocks_[0].patches[0].side, noise_.variance());
  if (explained && parts().still_translation && is_still(whole_, noise_.variance())) {
    measurement.flags = kStill;
    if (parts().noise_at_rest)
      noise_.learn(energy);
    return Explanation::rest;
  }
  if (explained && !options_.always_grid && is_precise(whole_) &&
      whole_.residual2 <
          kOverExpected * 2 * kSmoothedNoise * fit_noise_.variance() + whole_.interpolation2) {
    if (parts().noise_of_fits)
      fit_noise_.learn(2 * noise_of(whole_.residual2));
    measurement.candidates = 1;
    measurement.add(patch_of(area_, whole_));
    return Explanation::translation;
  }
  return Explanation::none;
}

void FastTracker::measure_reduced(const CropPair &pair, Measurement &measurement) {
  if (explain_simply(pair, measurement) == Explanation::none)
    measure_grid(area_, whole_, measurement);
}

// Level of the pyramid where a region of any size has about the pixels of a small one.
std::size_t FastTracker::level_of_pixels() const {
  return std::min(static_cast<std::size_t>(doublings(side_)), levels_ - 1);
}

// A larger region is voted on in a smaller frame, where the patches are as close. Returns the share
// of the pixels that no patch explains.
float FastTracker::count_votes(const Area &area, Measurement &measurement) {
  const std::size_t level = level_of_pixels();
  return votes_.count(previous_.levels[level], current_.levels[level], static_cast<int>(level),
                      area, noise_.variance(), measurement.view());
}

// Where layers lie over one another, as in a reflection, patches follow one or the other. The one
// that most pixels follow is the answer. Objects side by side leave few pixels unexplained, or a
// common motion that the blocks contradict.
void FastTracker::separate_layers(const Area &area, float unexplained, Translation whole,
                                  Measurement &measurement) {
  constexpr float kUnexplained = 0.35F; // of the pixels, by any patch
  constexpr float kDisagreement = 5;    // of a block
  const auto side = static_cast<float>(blocks_[0].patches[0].side);
  if (unexplained < kUnexplained || clipped_.any() ||
      whole.disagreement * side * side > kDisagreement * whole.pixels)
    return;
  const std::size_t level = level_of_pixels();
  const auto scale = static_cast<float>(1 << level);
  const DominantMotion dominant = find_dominant_motion(
      previous_.levels[level], current_.levels[level], area.at_level(static_cast<int>(level)),
      1 / scale * whole.displacement, noise_.variance());
  if (dominant.share >= unexplained)
    return;
  whole.displacement = scale * dominant.displacement;
  measurement.clear();
  measurement.candidates = 1;
  measurement.add(patch_of(area, whole));
}

// Keeps at most so many patches, one of each stretch of the list.
void thin(Measurement &measurement, int most) {
  const int count = measurement.count;
  if (count <= most)
    return;
  const auto patch = [&](int i) -> Patch & {
    return measurement.patches[static_cast<std::size_t>(i)];
  };
  for (int i = 0; i < most; ++i)
    patch(i) = patch((2 * i + 1) * count / (2 * most));
  measurement.count = most;
  measurement.candidates = measurement.candidates * most / count;
}

// Where two motions explain the pixels, each pixel follows one of them, and each patch that of the
// pixel at its middle. These return whether. Without the patches of the grid, fewer pixels may be
// left unexplained; that spares the time for the grid.
bool FastTracker::label_from_coarse(const Area &area, Measurement &measurement) {
  constexpr float kUnexplained = 0.15F; // of the pixels
  const auto motions = find_labels(area, measurement.view());
  if (!motions || motions->unexplained > kUnexplained)
    return false;
  thin(measurement, max_points_);
  return follow_labels(*motions, measurement.view());
}

bool FastTracker::label_from_grid(const Area &area, Measurement &measurement) {
  constexpr float kUnexplained = 0.3F; // of the pixels
  const auto motions = find_labels(area, measurement.view());
  return motions && motions->unexplained <= kUnexplained && explain_as_well(measurement.view()) &&
         follow_labels(*motions, measurement.view());
}

// Two motions which most patches follow, fitted to the pixels and labelled.
std::optional<TwoMotions> FastTracker::find_labels(const Area &area,
                                                   std::span<const Patch> patches) {
  constexpr float kNear2 = 0.5F * 0.5F; // px squared: one of the two, and neither bends
  const auto first = commonest_of(patches, {});
  const auto second = first ? commonest_of(patches, first) : first;
  if (!second || are_close(*first, *second))
    return {};
  const auto is_near = [&](const Patch &patch) {
    const Displacement displacement{patch.dx, patch.dy};
    return std::min(norm2(displacement - *first), norm2(displacement - *second)) < kNear2;
  };
  if (10 * std::ranges::count_if(patches, is_near) < 6 * std::ssize(patches))
    return {};
  const std::size_t level = level_of_pixels();
  const float scale = label_scale();
  TwoMotions motions = labels_.find(previous_.levels[level], current_.levels[level],
                                    area.at_level(static_cast<int>(level)), 1 / scale * *first,
                                    1 / scale * *second, noise_.variance());
  motions.first = scale * motions.first;
  motions.second = scale * motions.second;
  if (are_close(motions.first, motions.second))
    return {};
  return motions;
}

// Whether the residuals of the patches are about as large as those of the motions at their middles.
bool FastTracker::explain_as_well(std::span<const Patch> patches) const {
  constexpr float kAsWell = 1.2F;
  const float most = largest_residual2(noise_.variance());
  const float scale = label_scale();
  float of_labels = 0;
  float of_patches = 0;
  for (const Patch &patch : patches) {
    of_labels += labels_.energy(patch.x / scale, patch.y / scale);
    of_patches += std::min(most, patch.residual * patch.residual);
  }
  return of_labels <= kAsWell * of_patches;
}

// Returns false if all patches follow one motion; then they stay as they are.
bool FastTracker::follow_labels(const TwoMotions &motions, std::span<Patch> patches) const {
  const float scale = label_scale();
  const auto follows_second = [&](const Patch &patch) {
    return labels_.follows_second(patch.x / scale, patch.y / scale);
  };
  const auto seconds = std::ranges::count_if(patches, follows_second);
  const auto firsts = std::ssize(patches) - seconds;
  if (firsts == 0 || seconds == 0)
    return false;
  for (Patch &patch : patches) {
    const bool is_second = follows_second(patch);
    const Displacement moved = is_second ? motions.second : motions.first;
    patch.dx = moved.x;
    patch.dy = moved.y;
    patch.share = is_second ? motions.share / static_cast<float>(seconds)
                            : (1 - motions.share) / static_cast<float>(firsts);
  }
  return true;
}

// The pair halved so many times. The corner of the crop stays: it need not lie on a multiple of the
// reduction.
CropPair FastTracker::reduced(const CropPair &pair, int count) {
  if (count == 0)
    return pair;
  const int scale = 1 << count;
  CropPair reduced = pair;
  reduced.previous = previous_reduction_.reduce(pair.previous, count);
  reduced.current = current_reduction_.reduce(pair.current, count);
  reduced.crop = {pair.crop.x, pair.crop.y, reduced.previous.width, reduced.previous.height};
  reduced.region = {pair.crop.x + (pair.region.x - pair.crop.x) / scale,
                    pair.crop.y + (pair.region.y - pair.crop.y) / scale, pair.region.width / scale,
                    pair.region.height / scale};
  return reduced;
}

// Whether the fields differ, before any reduction, which would mix them. Averaging 2x2 pixels
// quarters the variance of their noise.
bool FastTracker::has_fields(const CropPair &pair, int reductions) const {
  const float noise = static_cast<float>(1 << (2 * reductions)) *
                      std::max(noise_.variance(), fit_noise_.variance());
  return pair.region.width >= kSmallPatch && is_wide_enough(field_of(pair, 1), reductions) &&
         is_combed(inside(pair, pair.current), noise);
}

// A row has the time of its field, and the next frame a row of the same field at the same place.
// Each field lacks every other row. What that does to its displacement, it does to that of the
// other field with the opposite sign: the patches of both go to the average.
void FastTracker::measure_fields(const CropPair &pair, int reductions, Measurement &measurement) {
  const int points = max_points_;
  max_points_ = std::max(1, points / 2);
  measurement.flags = kStill;
  for (int parity = 0; parity < std::min(2, points); ++parity) {
    Measurement field;
    have_previous_ = false;
    last_.y /= 2;
    measure_reduced(reduced(field_of(pair, parity), reductions), field);
    last_.y *= 2;
    measurement.candidates += field.candidates;
    measurement.flags = static_cast<std::uint16_t>((measurement.flags & field.flags & kStill) |
                                                   ((measurement.flags | field.flags) & kCut));
    field.shift(kSmoothingRadius, kSmoothingRadius);
    field.scale(static_cast<float>(1 << reductions));
    for (Patch patch : field.view()) {
      patch.y = 2 * patch.y + static_cast<float>(parity) - 0.5F;
      patch.height *= 2;
      patch.dy *= 2;
      patch.precision_xy /= 2;
      patch.precision_yy /= 4;
      patch.share /= 2;
      measurement.add(patch);
    }
  }
  if (measurement.flags & kCut)
    measurement.count = 0;
  have_previous_ = false;
  max_points_ = points;
}

// From the planes to the frame.
void FastTracker::place(Measurement &measurement) const {
  measurement.shift(kSmoothingRadius, kSmoothingRadius);
  measurement.scale(static_cast<float>(1 << reductions_));
  measurement.shift(static_cast<float>(crop_.x), static_cast<float>(crop_.y));
}

Explanation FastTracker::measure_simply(const CropPair &pair, Measurement &measurement) {
  measurement.clear();
  for (int i = 0; i < std::min(pair.repeats, 100); ++i)
    sudden_.add(0);
  const int count = reductions(std::max(pair.region.width, pair.region.height));
  if (count != reductions_)
    forget(count);
  crop_ = pair.crop;
  // A strip along a border of the frame may have become too narrow for patches.
  if (!is_wide_enough(pair, count)) {
    have_previous_ = false;
    last_ = {};
    return Explanation::narrow;
  }
  if (has_fields(pair, count)) {
    measure_fields(pair, count, measurement);
    measurement.shift(static_cast<float>(crop_.x), static_cast<float>(crop_.y));
    return Explanation::fields;
  }
  const Explanation found = explain_simply(reduced(pair, count), measurement);
  place(measurement);
  return found;
}

void FastTracker::measure_rest(Measurement &measurement) {
  measurement.clear();
  measure_grid(area_, whole_, measurement);
  place(measurement);
}

void FastTracker::measure(const CropPair &pair, Measurement &measurement) {
  if (measure_simply(pair, measurement) == Explanation::none)
    measure_rest(measurement);
}

} // namespace

std::unique_ptr<PatchTracker> make_fast_tracker(const FastTrackerOptions &options) {
  return std::make_unique<FastTracker>(options);
}

std::unique_ptr<Ladder> make_ladder() {
  return std::make_unique<FastTracker>(FastTrackerOptions{});
}

} // namespace haptic
