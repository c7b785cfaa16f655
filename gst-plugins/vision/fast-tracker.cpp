// A ladder: each rung is climbed only when the one below does not explain the pixels.
//   1. nothing changed but noise
//   2. one translation of the whole region
//   3. a grid of patches, evenly spread so that their mean is the mean over the region
#include "lk-kernels.hpp"
#include "patch-tracker.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

namespace haptic {
namespace {

constexpr int kMostLevels = 5;
constexpr int kSmallPatch = 8;      // px
constexpr int kLargePatch = 16;     // px
constexpr int kRim = 4;             // px around a patch, for gradients and interpolation
constexpr int kSmoothingRadius = 1; // px by which planes are smaller than the crop on every side
constexpr int kIterations = 5;      // most Gauss-Newton steps of the whole region at a level
constexpr int kSmallSide = 30;      // px, the region of the paper
constexpr int kReach =
    20; // px per picture that the search covers there; what is larger moves further
constexpr int kLargestSide =
    128; // px; larger regions are averaged down first, so that the cost stays bounded

// Smoothing correlates the noise of neighbouring pixels: there are fewer independent ones than it
// seems.
constexpr float kNoiseCorrelation = 5;
// What interpolation leaves of the displacement's error even without noise, px.
constexpr float kDisplacementFloor = 0.02F;
// Variance of a smoothed pixel's gradient from white noise of variance 1: (1 2 0 -2 -1)/8 along, (1
// 2 1)/4 across.
constexpr float kGradientNoise = 10.0F / 64 * 6 / 16;
// Variance of a smoothed pixel itself: (6/16)^2.
constexpr float kSmoothedNoise = 36.0F / 256;
constexpr float kTextureOverNoise = 3;
constexpr float kLeastResidual2 = 0.05F; // grey levels squared, rounding to 8 bits

Displacement operator+(Displacement a, Displacement b) {
  return {a.x + b.x, a.y + b.y};
}
Displacement operator-(Displacement a, Displacement b) {
  return {a.x - b.x, a.y - b.y};
}
Displacement operator*(float scale, Displacement d) {
  return {scale * d.x, scale * d.y};
}
float norm2(Displacement d) {
  return d.x * d.x + d.y * d.y;
}

Tensor &operator+=(Tensor &sum, const Tensor &t) {
  sum.xx += t.xx;
  sum.xy += t.xy;
  sum.yy += t.yy;
  return sum;
}

Displacement solve(const Tensor &t, Displacement right, float regularised) {
  const float xx = t.xx + regularised;
  const float yy = t.yy + regularised;
  const float inverse = 1 / (xx * yy - t.xy * t.xy);
  return {(yy * right.x - t.xy * right.y) * inverse, (xx * right.y - t.xy * right.x) * inverse};
}

float quadratic(const Tensor &t, Displacement d) {
  return t.xx * d.x * d.x + 2 * t.xy * d.x * d.y + t.yy * d.y * d.y;
}

struct Eigenvalues {
  float least;
  float most;
};

Eigenvalues eigenvalues(const Tensor &t) {
  const float mean = (t.xx + t.yy) / 2;
  const float half_difference = (t.xx - t.yy) / 2;
  const float spread = std::sqrt(half_difference * half_difference + t.xy * t.xy);
  return {mean - spread, mean + spread};
}

// Unit vector of the larger eigenvalue.
Displacement strong_direction(const Tensor &t) {
  const float most = eigenvalues(t).most;
  const Displacement along =
      t.xx > t.yy ? Displacement{most - t.yy, t.xy} : Displacement{t.xy, most - t.xx};
  const float length2 = norm2(along);
  return length2 > 0 ? 1 / std::sqrt(length2) * along : Displacement{1, 0};
}

// What is left of a tensor when the weaker direction counts as unknown.
Tensor strong_part(const Tensor &t) {
  const Displacement strong = strong_direction(t);
  const float most = eigenvalues(t).most;
  return {most * strong.x * strong.x, most * strong.x * strong.y, most * strong.y * strong.y};
}

// A rectangle in pixels of some level; pixel i covers i..i+1.
struct Area {
  float x;
  float y;
  float width;
  float height;

  Area at_level(int level) const {
    const float scale = 1 / static_cast<float>(1 << level);
    return {x * scale, y * scale, width * scale, height * scale};
  }
};

// One picture's crop, from fine to coarse.
struct Pyramid {
  std::array<Plane, kMostLevels> levels;

  void build(const LumaView &view, std::size_t count) {
    smooth(view, levels[0]);
    for (std::size_t i = 1; i < count; ++i)
      halve(levels[i - 1], levels[i]);
  }
};

// Patches side by side over an area, on one level of the earlier picture.
struct PatchGrid {
  int columns = 0;
  int rows = 0;
  std::array<Template, kMaxPatches> patches;

  std::span<Template> view() { return {patches.data(), static_cast<std::size_t>(columns * rows)}; }
};

// Index into a table with so many columns.
std::size_t cell(int row, int columns, int column) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
         static_cast<std::size_t>(column);
}

bool fits_into(const Plane &plane, int side) {
  return std::min(plane.width(), plane.height()) >= side + kRim;
}

// Column or row of a patch's first pixel, kept inside the plane with pixels to spare for gradients
// and interpolation.
int first_pixel(float from, float length, int index, int parts, int side, int available) {
  const float centre =
      from + (static_cast<float>(index) + 0.5F) * length / static_cast<float>(parts);
  return std::clamp(static_cast<int>(std::floor(centre - 0.5F * static_cast<float>(side))), 1,
                    available - side - 2);
}

int parts_of(float length, float part, int most) {
  return std::clamp(static_cast<int>(std::lround(length / part)), 1, most);
}

// What one translation of all blocks explains.
struct Translation {
  Displacement displacement;
  Tensor structure;
  float pixels = 0;
  float correlation = -1;     // mean over the blocks, weighted by their contrast
  float residual2 = 0;        // mean squared grey levels
  float interpolation2 = 0;   // how much of it interpolation may cause
  float disagreement = 0;     // chi-squared of what each block alone would correct
  bool one_direction = false; // only the component along strong_direction() is known

  float variance() const { return kNoiseCorrelation * std::max(residual2, kLeastResidual2); }
};

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
  enum class Change { none, unseen, some };
  Change change(const CropPair &pair);
  void take_pictures(const CropPair &pair);
  void cover(const Area &area, std::size_t level, int columns, int rows, int side, PatchGrid &grid);
  void cover_with_blocks(const Area &area);
  Translation translate(Displacement start);
  Translation translate_level(std::size_t level, Displacement start, int iterations);
  Translation find_translation();
  static bool has_texture(float least_eigenvalue, float pixels, float noise) {
    return least_eigenvalue > kTextureOverNoise * kGradientNoise * noise * pixels;
  }
  bool explains(const Translation &whole) const;
  static bool is_still(const Translation &whole);
  static bool is_precise(const Translation &whole);
  float period();
  void add_whole(const Area &area, const Translation &whole, Measurement &measurement);
  void add_grid(const Area &area, const Translation &whole, Measurement &measurement);
  std::optional<Strain> strain_at(int row, int column, std::span<const Displacement> displacements,
                                  std::span<const Alignment> aligned) const;
  void follow_strain(std::span<Alignment> aligned);
  void add_patch(const Template &patch, Displacement moved, const Fit &fit,
                 Measurement &measurement);

  const FastTrackerOptions options_;
  int max_points_ = kMaxPatches;
  bool have_previous_ = false; // current_ holds the picture that comes next as the earlier one
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
  Displacement last_;                           // px, of the picture before
  float noise_ = kAssumedNoise * kAssumedNoise; // variance of a pixel, learned from still pictures
  float expected_residual2_ = 2 * kSmoothedNoise * noise_; // grey levels squared, of what fits
  float trust_ = 0;         // sum over the grid's patches that have texture, 0..1 each
  float change_energy_ = 0; // mean squared difference about its mean
};

// Nothing, if the differences are no larger than noise and do not line up with the gradients: a
// translation would make them do so.
FastTracker::Change FastTracker::change(const CropPair &pair) {
  constexpr float kOverNoise = 1.3F;
  constexpr float kSignificant = 7; // F distribution with 2 degrees of freedom: 1 in 1000
  const std::ptrdiff_t x = pair.region.x - pair.crop.x;
  const std::ptrdiff_t y = pair.region.y - pair.crop.y;
  const auto inside = [&](const LumaView &view) {
    return LumaView{view.pixels + y * view.stride + x, pair.region.width, pair.region.height,
                    view.stride};
  };
  const auto sums = measure_change(inside(pair.previous), inside(pair.current));
  if (sums.squares == 0)
    return Change::none;
  const auto pixels = static_cast<float>((pair.region.width - 2) * (pair.region.height - 2));
  const float mean = sums.sum / pixels;
  change_energy_ = std::max(0.0F, sums.squares / pixels - mean * mean);
  if (change_energy_ > 2 * kOverNoise * noise_)
    return Change::some;
  const Displacement moved = solve(sums.structure, sums.moment, 1);
  if (quadratic(sums.structure, moved) > 2 * kSignificant * change_energy_)
    return Change::some;
  // Nothing can be said of a region whose texture could hide such a motion. (A plain central
  // difference of white noise of variance 1 has variance 1/2.)
  constexpr float kHidden = 0.15F; // px
  const float texture = eigenvalues(sums.structure).least - 0.5F * noise_ * pixels;
  return texture > 2 * noise_ / (kHidden * kHidden) ? Change::none : Change::unseen;
}

void FastTracker::take_pictures(const CropPair &pair) {
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

void FastTracker::cover(const Area &area, std::size_t level, int columns, int rows, int side,
                        PatchGrid &grid) {
  grid.columns = columns;
  grid.rows = rows;
  const Plane &plane = previous_.levels[level];
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      // Interpolation draws displacements towards whole pixels. At the finest level, neighbours are
      // sampled a quarter and three quarters of a pixel off the raster, so that the bias of one
      // cancels the other's.
      const float off_raster = level > 0 ? 0 : ((i + j) & 1) == 0 ? 0.25F : 0.75F;
      const auto first = [&](float from, float length, int index, int parts, int available) {
        return static_cast<float>(first_pixel(from, length, index, parts, side, available)) +
               off_raster;
      };
      Template &patch = grid.patches[cell(j, columns, i)];
      patch.side = side;
      patch.x = first(area.x, area.width, i, columns, plane.width());
      patch.y = first(area.y, area.height, j, rows, plane.height());
    }
  prepare_templates(plane, grid.view());
}

void FastTracker::cover_with_blocks(const Area &area) {
  for (std::size_t level = 0; level < levels_; ++level) {
    const Area a = area.at_level(static_cast<int>(level));
    const bool large = std::min(a.width, a.height) >= (level > 0 ? 12.0F : 24.0F) &&
                       fits_into(previous_.levels[level], kLargePatch);
    const int side = large ? kLargePatch : kSmallPatch;
    const auto length = static_cast<float>(side);
    cover(a, level, parts_of(a.width, length, 8), parts_of(a.height, length, 8), side,
          blocks_[level]);
  }
}

Translation FastTracker::translate_level(std::size_t level, Displacement start, int iterations) {
  const auto blocks = blocks_[level].view();
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

  // Blocks that leave the picture have no say.
  const auto fit_all = [&] {
    Displacement gradient;
    float energy = 0;
    float correlation = 0;
    float squares = 0;
    result.structure = {};
    result.pixels = 0;
    float curvature = 0;
    fit_templates(current_.levels[level], blocks, result.displacement,
                  std::span(fits).first(blocks.size()));
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
    // in both pictures.
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
  // pictures, smoothed, and whatever else does not fit).
  result.one_direction = !has_texture(least, all_pixels, noise_);
  if (result.one_direction)
    result.displacement = along_strong(start);
  descend();
  if (result.one_direction &&
      has_texture(least, all_pixels, std::min(noise_, result.residual2 / (2 * kSmoothedNoise)))) {
    result.one_direction = false;
    result.displacement = start;
    descend();
  }
  if (level > 0)
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

bool FastTracker::explains(const Translation &whole) const {
  constexpr float kFits = 0.7F;
  const auto side = static_cast<float>(blocks_[0].patches[0].side);
  const float blocks = whole.pixels / (side * side);
  // Chi-squared with two degrees of freedom per block: its mean and a standard deviation.
  return has_texture(eigenvalues(whole.structure).most, whole.pixels, noise_) &&
         whole.correlation > kFits && whole.disagreement < 2 * blocks + 2 * std::sqrt(blocks);
}

bool FastTracker::is_still(const Translation &whole) {
  constexpr float kSignificant = 12; // chi-squared with 2 degrees of freedom: 1 in 400
  return quadratic(whole.structure, whole.displacement) < kSignificant * whole.variance();
}

// A texture of one spatial frequency looks the same one period further, so that two pictures cannot
// tell which way it went. 0: no such texture, else the period in px.
float FastTracker::period() {
  constexpr float kNarrowBand = 1.6F; // one frequency alone gives 1
  constexpr float kRepeats = 0.8F;
  constexpr int kDirections = 32; // of half a turn
  float energy = 0;
  float slope = 0;
  float curvature = 0;
  const auto blocks = blocks_[0].view();
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
  if (length > static_cast<float>(2 * reach(side_)))
    return 0;
  std::array<Fit, kMaxPatches> fits;
  for (int i = 0; i < kDirections; ++i) {
    const float angle = std::numbers::pi_v<float> * static_cast<float>(i) / kDirections;
    const Displacement further = length * Displacement{std::cos(angle), std::sin(angle)};
    fit_templates(previous_.levels[0], blocks, further, std::span(fits).first(blocks.size()));
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

bool FastTracker::is_precise(const Translation &whole) {
  constexpr float kPrecise = 0.1F; // px
  const auto [least, most] = eigenvalues(whole.structure);
  return (whole.one_direction ? most : least) > whole.variance() / (kPrecise * kPrecise);
}

void FastTracker::add_whole(const Area &area, const Translation &whole, Measurement &measurement) {
  const Tensor precision = whole.one_direction ? strong_part(whole.structure) : whole.structure;
  const float scale = 1 / whole.variance();
  measurement.candidates = 1;
  measurement.add({area.x + area.width / 2, area.y + area.height / 2, area.width, area.height,
                   whole.displacement.x, whole.displacement.y, precision.xx * scale,
                   precision.xy * scale, precision.yy * scale, std::sqrt(whole.residual2)});
}

void FastTracker::add_patch(const Template &patch, Displacement moved, const Fit &fit,
                            Measurement &measurement) {
  constexpr float kUseless = 0.6F;
  constexpr float kGood = 0.9F;
  if (!fit.inside) {
    ++measurement.candidates;
    return;
  }
  const auto side = static_cast<float>(patch.side);
  const auto [least, most] = eigenvalues(patch.structure);
  const float trust = std::clamp((fit.correlation - kUseless) / (kGood - kUseless), 0.0F, 1.0F);
  if (has_texture(most, side * side, noise_)) {
    ++measurement.candidates;
    trust_ += trust;
    if (trust <= 0)
      return;
  }
  const float scale =
      trust / (kNoiseCorrelation * std::max(fit.residual * fit.residual, kLeastResidual2));
  const float noise = std::min(noise_, fit.residual * fit.residual / (2 * kSmoothedNoise));
  const Tensor known =
      has_texture(least, side * side, noise) ? patch.structure : strong_part(patch.structure);
  measurement.add({patch.x + side / 2, patch.y + side / 2, side, side, moved.x, moved.y,
                   known.xx * scale, known.xy * scale, known.yy * scale, fit.residual});
}

void FastTracker::add_grid(const Area &area, const Translation &whole, Measurement &measurement) {
  constexpr float kCoarseSpacing = 5; // px of the half-size picture
  constexpr float kSame2 = 1.0F;      // px squared between starts that are not worth telling apart

  const std::size_t coarse_level = levels_ > 1 ? 1 : 0;
  const auto coarse_scale = static_cast<float>(1 << coarse_level);
  const Area half = area.at_level(static_cast<int>(coarse_level));
  const int coarse_columns = parts_of(half.width, kCoarseSpacing, 8);
  const int coarse_rows = parts_of(half.height, kCoarseSpacing, 8);
  cover(half, coarse_level, coarse_columns, coarse_rows, kSmallPatch, coarse_grid_);
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
  cover(area, 0, columns, rows, side, grid_);
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
    add_patch(grid_.patches[i], aligned[i].displacement, aligned[i].fit, measurement);
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
  const Change changed = change(pair);
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
  take_pictures(pair);
  const Area area{static_cast<float>(pair.region.x - pair.crop.x - kSmoothingRadius),
                  static_cast<float>(pair.region.y - pair.crop.y - kSmoothingRadius),
                  static_cast<float>(pair.region.width), static_cast<float>(pair.region.height)};
  cover_with_blocks(area);
  Translation whole = find_translation();
  if (const float repeats = whole.one_direction ? 0 : period(); repeats > 0) {
    // Only the motion before can tell, and at first that slow motion is likelier than fast.
    whole = translate_level(0, last_, kIterations);
    if (norm2(whole.displacement - last_) > repeats * repeats / 16) {
      measurement.candidates = 1;
      last_ = {};
      return;
    }
  }
  last_ = whole.displacement;
  const bool explained = explains(whole);
  if (explained && is_still(whole)) {
    constexpr float kLearning = 0.3F;
    measurement.flags = kStill;
    noise_ += kLearning * (std::clamp(change_energy_ / 2, 0.25F, 150.0F) - noise_);
    return;
  }
  if (explained && !options_.always_grid && is_precise(whole) &&
      whole.residual2 < kOverExpected * expected_residual2_ + whole.interpolation2) {
    add_whole(area, whole, measurement);
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
  // A strip along a picture's border may have become too narrow for patches.
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
