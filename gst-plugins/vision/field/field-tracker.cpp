// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field/field-tracker.hpp"

#include "patches/texture-period.hpp"
#include "samples/region-size.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace haptic {
namespace {

// px. A frame with larger cells is reduced: it has more pixels than motion needs. It is reduced
// until its cells are below kLargestReducedCell, which costs no accuracy where the first halving
// cost none.
constexpr float kLargestCell = 32;
constexpr float kLargestReducedCell = 24;
constexpr std::size_t kLevels = 3; // a patch of the coarsest covers one cell or two
constexpr int kCoarseSpacing = 6;  // px between patches of the coarsest level
constexpr int kReach = 5;          // px of the coarsest level
constexpr float kBlockSpacing = 8; // px between the blocks of one translation
constexpr float kGridSpacing = 6;  // px between the patches of a cell that does not move as one
constexpr int kRefinements = 3; // most steps of a cell, whose start is right to a fraction of a px
constexpr float kGood = 0.9F;   // correlation of a translation that needs no better explanation

int blocks_along(float length) {
  return std::max(2, parts_of(length, kBlockSpacing));
}

int patches_along(float length) {
  return std::max(3, parts_of(length, kGridSpacing));
}

// Puts the patch into the middle of the area of a level of the earlier frame.
void place(const Plane &plane, const Area &area, Template &patch) {
  const auto first = [&](float from, float length, int available) {
    const float wanted =
        std::floor(from + length / 2 - static_cast<float>(patch.side) / 2) - kSmoothingRadius;
    return std::clamp(wanted, 1.0F, static_cast<float>(available - patch.side - 2));
  };
  patch.x = first(area.x, area.width, plane.width());
  patch.y = first(area.y, area.height, plane.height());
  prepare_templates(plane, {&patch, 1});
}

} // namespace

void FieldTracker::set_frame(int width, int height, const FieldShape &shape) {
  width_ = width;
  height_ = height;
  shape_ = shape;
  reductions_ = 0;
  const float cell_side = std::min(static_cast<float>(width) / static_cast<float>(shape.columns),
                                   static_cast<float>(height) / static_cast<float>(shape.rows));
  while (cell_side / static_cast<float>(1 << reductions_) >=
         (reductions_ == 0 ? kLargestCell : kLargestReducedCell))
    ++reductions_;
  for (ByteImage *frame : {&previous_, &current_}) {
    frame->width = width >> reductions_;
    frame->height = height >> reductions_;
    frame->pixels.resize(static_cast<std::size_t>(frame->width) *
                         static_cast<std::size_t>(frame->height));
  }
  const int least = std::min(current_.width, current_.height) - 2 * kSmoothingRadius;
  levels_ = 0;
  while (levels_ < kLevels && (least >> levels_) >= kSmallPatch + kRim)
    ++levels_;
  cells_.resize(static_cast<std::size_t>(shape.cells()));
  if (levels_ > 0) {
    const auto coarse = [&](int length) {
      return std::max(1, (length >> (levels_ - 1)) / kCoarseSpacing);
    };
    coarse_shape_ = {coarse(current_.width), coarse(current_.height)};
    coarse_.resize(static_cast<std::size_t>(coarse_shape_.cells()));
    coarse_is_needed_.resize(coarse_.size());
  }
  simple_.resize(cells_.size());
  layers_.set_frame(current_.width, current_.height, shape,
                    static_cast<float>(default_region_side(width)) /
                        static_cast<float>(1 << reductions_),
                    reductions_);
  forget();
}

void FieldTracker::forget_displacements() {
  for (Cell &cell : cells_)
    cell.last = {};
}

void FieldTracker::forget() {
  have_previous_ = false;
  previous_is_built_ = false;
  current_is_built_ = false;
  rows_read_ = 0;
  noise_.reset(assumed_variance(reductions_), assumed_variance(reductions_));
  forget_displacements();
  layers_.forget();
}

int FieldTracker::strip_rows() const {
  constexpr int kStrip = 16; // rows that fit into the fastest cache
  return std::max(kStrip, 1 << reductions_);
}

void FieldTracker::read(const LumaView &strip) {
  current_is_built_ = false;
  if (rows_read_ == current_.height)
    rows_read_ = 0;
  const LumaView rows = reduction_.reduce(strip, reductions_);
  const int count = std::min(rows.height, current_.height - rows_read_);
  for (int y = 0; y < count; ++y, ++rows_read_)
    std::memcpy(current_.pixels.data() + cell(rows_read_, current_.width, 0),
                rows.pixels + y * rows.stride, static_cast<std::size_t>(current_.width));
}

void FieldTracker::keep() {
  std::swap(previous_, current_);
  std::swap(previous_pyramid_, current_pyramid_);
  previous_is_built_ = std::exchange(current_is_built_, false);
  have_previous_ = true;
}

bool FieldTracker::repeats() const {
  return have_previous_ && std::memcmp(previous_.pixels.data(), current_.pixels.data(),
                                       cell(current_.height, current_.width, 0)) == 0;
}

Area FieldTracker::area_of(int row, int column) const {
  const float scale = 1 / static_cast<float>(1 << reductions_);
  const float width = scale * static_cast<float>(width_) / static_cast<float>(shape_.columns);
  const float height = scale * static_cast<float>(height_) / static_cast<float>(shape_.rows);
  return {static_cast<float>(column) * width, static_cast<float>(row) * height, width, height};
}

LumaView FieldTracker::part_of(const ByteImage &frame, const Area &area) const {
  constexpr int kLeast = 3;
  const auto clip = [](float from, float length, int limit) {
    const int begin = std::clamp(static_cast<int>(from), 0, std::max(0, limit - kLeast));
    const int end = std::clamp(static_cast<int>(std::ceil(from + length)), begin + kLeast, limit);
    return std::pair(begin, end - begin);
  };
  const auto [x, width] = clip(area.x, area.width, frame.width);
  const auto [y, height] = clip(area.y, area.height, frame.height);
  return {frame.pixels.data() + cell(y, frame.width, x), width, height, frame.width};
}

// Fills in the cells that did not change. Returns whether there are others.
bool FieldTracker::find_changes(std::span<FieldCell> cells) {
  bool any = false;
  for_places(shape_, [&](int row, int column) {
    const Area area = area_of(row, column);
    const auto [change, energy] =
        find_change(part_of(previous_, area), part_of(current_, area), noise_.variance());
    Cell &own = at(row, column);
    own.change = change;
    own.energy = energy;
    own.explained = false;
    cells[cell(row, shape_.columns, column)] = {.confidence = change == Change::none ? 1.0F : 0.0F};
    any = any || change == Change::some;
  });
  return any;
}

void FieldTracker::build_pyramids() {
  if (!previous_is_built_)
    previous_pyramid_.build(previous_.view(), levels_);
  if (!current_is_built_)
    current_pyramid_.build(current_.view(), levels_);
  previous_is_built_ = current_is_built_ = true;
}

// A coarse patch is needed wherever a cell near it changed.
void FieldTracker::mark_coarse_patches() {
  std::ranges::fill(coarse_is_needed_, std::uint8_t{0});
  for_places(shape_, [&](int row, int column) {
    if (at(row, column).change == Change::some)
      for_neighbours(
          coarse_shape_, nearest_part(row, shape_.rows, coarse_shape_.rows),
          nearest_part(column, shape_.columns, coarse_shape_.columns),
          [&](int y, int x) { coarse_is_needed_[cell(y, coarse_shape_.columns, x)] = 1; });
  });
}

// Aligns the evenly spread patches of the coarsest level.
void FieldTracker::align_coarse_patches() {
  mark_coarse_patches();
  std::ranges::fill(coarse_, Displacement{});
  for_places(coarse_shape_, [&](int row, int column) {
    if (coarse_is_needed_[cell(row, coarse_shape_.columns, column)])
      align_coarse_patch(row, column);
  });
}

// Starts of a coarse patch: zero, the motion before, and the patches aligned already on its left
// and above it. `scale`: px of the finest level per px of the coarsest.
void FieldTracker::add_coarse_starts(int row, int column, float scale) {
  const FieldShape &shape = coarse_shape_;
  starts_.clear();
  starts_.add({});
  starts_.add(1 / scale *
              at(nearest_part(row, shape.rows, shape_.rows),
                 nearest_part(column, shape.columns, shape_.columns))
                  .last);
  if (column > 0)
    starts_.add(coarse_[cell(row, shape.columns, column - 1)]);
  if (row > 0)
    starts_.add(coarse_[cell(row - 1, shape.columns, column)]);
}

void FieldTracker::align_coarse_patch(int row, int column) {
  const std::size_t level = levels_ - 1;
  const auto scale = static_cast<float>(1 << level);
  const Plane &earlier = previous_pyramid_.levels[level];
  const Plane &later = current_pyramid_.levels[level];
  const auto width =
      static_cast<float>(earlier.width()) / static_cast<float>(coarse_shape_.columns);
  const auto height = static_cast<float>(earlier.height()) / static_cast<float>(coarse_shape_.rows);
  patch_.side = kSmallPatch;
  place(earlier,
        {static_cast<float>(column) * width + kSmoothingRadius,
         static_cast<float>(row) * height + kSmoothingRadius, width, height},
        patch_);
  if (!has_texture(eigenvalues(patch_.structure).most, kSmallPatch * kSmallPatch,
                   noise_.variance() / scale))
    return;
  add_coarse_starts(row, column, scale);
  Alignment found = align_template(later, patch_, starts_.view(), kMostSteps);
  if (!is_found(found.fit.correlation)) {
    const SearchResult elsewhere = search_template(later, patch_, {}, kReach);
    const Alignment other = align_template(later, patch_, {&elsewhere.best, 1}, kMostSteps);
    if (is_clearly_better(other.fit.correlation, found.fit.correlation))
      found = other;
  }
  coarse_[cell(row, coarse_shape_.columns, column)] = found.displacement;
}

// Aligns one patch in the middle of a cell, one level below the finest.
void FieldTracker::align_cell_patch(int row, int column) {
  const std::size_t level = levels_ > 1 ? 1 : 0;
  const auto from_coarsest = static_cast<float>(1 << (levels_ - 1 - level));
  const auto scale = static_cast<float>(1 << level);
  Cell &own = at(row, column);
  own.coarse = {};
  if (own.change != Change::some)
    return;
  patch_.side = kSmallPatch;
  place(previous_pyramid_.levels[level], area_of(row, column).at_level(static_cast<int>(level)),
        patch_);
  starts_.clear();
  starts_.add(1 / scale * own.last);
  for_neighbours(coarse_shape_, nearest_part(row, shape_.rows, coarse_shape_.rows),
                 nearest_part(column, shape_.columns, coarse_shape_.columns), [&](int y, int x) {
                   starts_.add(from_coarsest * coarse_[cell(y, coarse_shape_.columns, x)]);
                 });
  starts_.add({});
  own.coarse =
      scale * align_template(current_pyramid_.levels[level], patch_, starts_.view(), kMostSteps)
                  .displacement;
}

// The start with the least squared residual over the blocks, or the first with a good correlation.
Displacement FieldTracker::best_start(const Plane &later) {
  Displacement best = starts_.view().front();
  if (starts_.view().size() == 1)
    return best;
  std::array<Fit, kMaxPatches> storage;
  const auto fits = std::span(storage).first(blocks_.view().size());
  float least = std::numeric_limits<float>::infinity();
  for (const Displacement start : starts_.view()) {
    fit_templates(later, blocks_.view(), start, fits);
    float squares = 0;
    float correlation = 0;
    for (const Fit &fit : fits) {
      squares += fit.residual * fit.residual;
      correlation += fit.correlation;
    }
    if (squares < least) {
      least = squares;
      best = start;
    }
    if (correlation > kGood * static_cast<float>(fits.size()))
      break;
  }
  return best;
}

Translation FieldTracker::translate(int row, int column) {
  const Area area = area_of(row, column);
  const Plane &earlier = previous_pyramid_.levels[0];
  const Plane &later = current_pyramid_.levels[0];
  blocks_.cover(earlier, area.in_plane(), blocks_along(area.width), blocks_along(area.height),
                kSmallPatch, true);
  const Cell &own = at(row, column);
  starts_.clear();
  starts_.add(own.coarse);
  for_neighbours(shape_, row, column, [&](int y, int x) { starts_.add(at(y, x).coarse); });
  starts_.add(own.last);
  Translation whole = translate_blocks(later, blocks_.view(), best_start(later), kRefinements,
                                       noise_.variance(), true);
  if (!resolve_period(earlier, later, blocks_.view(), std::max(area.width, area.height), own.last,
                      noise_.variance(), whole))
    whole.correlation = -1;
  return whole;
}

void FieldTracker::translate_cells() {
  for_places(shape_, [&](int row, int column) {
    Cell &own = at(row, column);
    if (own.change != Change::some)
      return;
    own.whole = translate(row, column);
    // The residual of the best fit shows the noise of this cell better than the estimate for the
    // whole frame. That of both frames together is the cautious choice.
    own.has_texture = has_texture(eigenvalues(own.whole.structure).most, own.whole.pixels,
                                  std::min(noise_.variance(), 2 * noise_of(own.whole.residual2)));
    own.explained = explains(own.whole, kSmallPatch, noise_.variance());
  });
}

// Whether most cells with texture were not found again.
bool FieldTracker::is_cut() const {
  constexpr float kLeastTrust = 0.35F;
  float candidates = 0;
  float trust = 0;
  for (const Cell &cell : cells_)
    if (cell.change == Change::none) {
      ++candidates;
      ++trust;
    } else if (cell.change == Change::some && cell.has_texture) {
      ++candidates;
      trust += trust_of(cell.whole.correlation);
    }
  return trust < kLeastTrust * candidates;
}

// Measures a cell that does not move as one, patch by patch.
void FieldTracker::add_grid(int row, int column, const Area &area) {
  grid_.cover(previous_pyramid_.levels[0], area, patches_along(area.width),
              patches_along(area.height), kSmallPatch, true);
  starts_.clear();
  starts_.add(at(row, column).whole.displacement);
  for_neighbours(shape_, row, column, [&](int y, int x) {
    const Cell &other = at(y, x);
    if (other.change != Change::some)
      starts_.add({});
    else if (other.explained)
      starts_.add(other.whole.displacement);
  });
  float trust = 0;
  for (const Template &patch : grid_.view())
    trust += add_patch(
        patch, align_template(current_pyramid_.levels[0], patch, starts_.view(), kMostSteps),
        noise_.variance(), measurement_);
  if (!is_same_scene(trust, measurement_.candidates))
    measurement_.count = 0;
}

// Returns the displacement of a cell that moves as one, or nothing.
std::optional<Displacement> FieldTracker::displacement_of(const Cell &cell) {
  if (cell.change == Change::none)
    return Displacement{};
  if (cell.change == Change::some && cell.explained)
    return cell.whole.displacement;
  return {};
}

// Whether a neighbour moves in another way, so that the border between both may lie in this cell.
bool FieldTracker::is_near_border(int row, int column) {
  const Displacement own = at(row, column).whole.displacement;
  return !all_neighbours(shape_, row, column, [&](int y, int x) {
    const auto other = displacement_of(at(y, x));
    return !other || are_close(*other, own);
  });
}

// The patches of the cell, and one at its side for each neighbour that moves in another way than
// the patch nearest to that side: of what shows little of itself in a cell, no patch may be there.
void FieldTracker::gather_voters(int row, int column, const Area &area) {
  voters_.clear();
  for (const Patch &patch : measurement_.view())
    voters_.add(patch);
  for_neighbours(shape_, row, column, [&](int y, int x) {
    const auto moved = displacement_of(at(y, x));
    if (!moved || (y == row && x == column))
      return;
    Patch voter = measurement_.view()[0];
    voter.x = area.x + area.width * static_cast<float>(1 + x - column) / 2;
    voter.y = area.y + area.height * static_cast<float>(1 + y - row) / 2;
    const Patch nearest =
        *std::ranges::min_element(measurement_.view(), {}, [&](const Patch &patch) {
          return norm2({patch.x - voter.x, patch.y - voter.y});
        });
    if (are_close(*moved, {nearest.dx, nearest.dy}))
      return;
    constexpr float kPrecision = 100; // 1/px²: surely textured
    voter.dx = moved->x;
    voter.dy = moved->y;
    voter.precision_xx = voter.precision_yy = kPrecision;
    voter.precision_xy = 0;
    voters_.add(voter);
  });
}

// Returns the mean displacement over the pixels of the cell, by the votes of the patches in
// measurement_ and of the neighbours. Nothing if all are close, or if the pixels do not decide.
std::optional<Displacement> FieldTracker::vote(int row, int column, const Area &area) {
  constexpr float kCounted = 0.5F;
  if (measurement_.count == 0)
    return {};
  gather_voters(row, column, area);
  const auto displacement = [](const Patch &patch) { return Displacement{patch.dx, patch.dy}; };
  const std::span<Patch> voters = voters_.view();
  if (std::ranges::all_of(voters, [&](const Patch &patch) {
        return are_close(displacement(patch), displacement(voters[0]));
      }))
    return {};
  votes_.count(previous_pyramid_.levels[0], current_pyramid_.levels[0], 0, area, noise_.variance(),
               voters);
  float shares = 0;
  Displacement mean;
  for (const Patch &patch : voters) {
    shares += patch.share;
    mean += patch.share * displacement(patch);
  }
  return shares > kCounted ? std::optional(mean) : std::nullopt;
}

VelocityEstimate FieldTracker::estimate(const Area &area, double interval) {
  const auto scale = static_cast<float>(1 << reductions_);
  measurement_.scale(scale);
  return estimate_velocity({.patches = measurement_.view(),
                            .candidates = measurement_.candidates,
                            .pointer_x = scale * (area.x + area.width / 2),
                            .pointer_y = scale * (area.y + area.height / 2),
                            .interval = interval,
                            .region_x = scale * area.x,
                            .region_y = scale * area.y,
                            .region_width = scale * area.width,
                            .region_height = scale * area.height},
                           Average::model, ModelChoice::automatic);
}

void FieldTracker::measure_patches(int row, int column, double interval, FieldCell &result) {
  constexpr float kNormalOnly = 0.4F;   // confidence across edges of one direction: half the motion
  constexpr float kDisagreement = 0.7F; // px of the reduced frame, between model and votes
  const Translation &whole = at(row, column).whole;
  const Area area = area_of(row, column).in_plane();
  measurement_.clear();
  std::optional<Displacement> voted;
  if (at(row, column).explained && whole.correlation > kGood && !is_near_border(row, column)) {
    measurement_.candidates = 1;
    measurement_.add(patch_of(area, whole));
  } else {
    add_grid(row, column, area);
    voted = vote(row, column, area);
  }
  const VelocityEstimate found = estimate(area, interval);
  if (!(found.confidence > 0))
    return;
  result = {found.velocity_x, found.velocity_y,
            (found.aperture ? kNormalOnly : 1) * found.confidence};
  if (!voted || found.aperture)
    return;
  const auto time = static_cast<float>(interval) / static_cast<float>(1 << reductions_);
  const Displacement apart = *voted - time * Displacement{result.velocity_x, result.velocity_y};
  const Displacement velocity = 1 / time * *voted;
  if (!(norm2(velocity) < kFastestMotion * kFastestMotion)) {
    result = {};
    return;
  }
  result = {velocity.x, velocity.y,
            result.confidence * std::exp(-std::sqrt(norm2(apart)) / kDisagreement)};
}

// What the layers say of the cells, for which what one translation explains is a hint. An edge says
// nothing of the motion along it.
std::span<const LayerFinding> FieldTracker::divide(double interval) {
  std::ranges::transform(cells_, simple_.begin(), [&](const Cell &cell) {
    CellFinding simple{.is_unchanged = cell.change != Change::some, .translation = {}};
    if (cell.change == Change::none)
      simple.translation = Displacement{};
    else if (cell.change == Change::some && cell.explained &&
             has_texture(eigenvalues(cell.whole.structure).least, cell.whole.pixels,
                         noise_.variance()))
      simple.translation = cell.whole.displacement;
    return simple;
  });
  return layers_.measure(previous_.view(), current_.view(), static_cast<float>(interval), simple_);
}

// What one translation explains moves by it, if little of it is background; the rest as the layers
// say.
void FieldTracker::measure_cell(int row, int column, double interval, const LayerFinding &layers,
                                FieldCell &result) {
  constexpr float kLittle = 0.3F; // background, of a cell
  constexpr float kMuch = 0.5F;
  Cell &own = at(row, column);
  const bool is_seen = own.change == Change::some && own.has_texture;
  const bool is_one = is_seen && own.explained;
  own.last = is_one ? own.whole.displacement : Displacement{};
  const bool rests =
      own.change == Change::none || (is_one && is_still(own.whole, noise_.variance()));
  if (rests)
    result.confidence = 1;
  // Half of the way from rest to the motion of the frame would be neither.
  if (rests && (layers.is_slow || layers.counts < 1))
    return;
  const float part =
      layers.counts *
      (is_one ? std::clamp((layers.background - kLittle) / (kMuch - kLittle), 0.0F, 1.0F) : 1);
  if (is_seen && !rests && part < 1)
    measure_patches(row, column, interval, result);
  const auto scale = static_cast<float>(1 << reductions_) / static_cast<float>(interval);
  const Displacement velocity = scale * layers.displacement;
  if (!(part > 0) || !(norm2(velocity) < kFastestMotion * kFastestMotion))
    return;
  if (!(result.confidence > 0))
    result = {velocity.x, velocity.y, 0};
  result.velocity_x += part * (velocity.x - result.velocity_x);
  result.velocity_y += part * (velocity.y - result.velocity_y);
  result.confidence += part * (layers.confidence - result.confidence);
}

// Learns from the cells that stand still although their pixels changed.
void FieldTracker::learn_noise() {
  constexpr int kFew = 16; // one cell in so many may be still by mistake
  float energy = 0;
  float count = 0;
  for (const Cell &cell : cells_)
    if (cell.change == Change::some && cell.explained && is_still(cell.whole, noise_.variance())) {
      energy += cell.energy;
      ++count;
    }
  if (kFew * count >= static_cast<float>(cells_.size()))
    noise_.learn(energy / count);
}

std::uint32_t FieldTracker::measure(double interval, std::span<FieldCell> cells) {
  std::ranges::fill(cells, FieldCell{});
  if (!have_previous_ || levels_ == 0)
    return 0;
  if (!find_changes(cells)) {
    forget_displacements();
    const bool any_seen =
        std::ranges::any_of(cells, [](const FieldCell &cell) { return cell.confidence > 0; });
    return any_seen ? std::uint32_t{kStill} : 0;
  }
  build_pyramids();
  align_coarse_patches();
  for_places(shape_, [&](int row, int column) { align_cell_patch(row, column); });
  translate_cells();
  if (is_cut()) {
    std::ranges::fill(cells, FieldCell{});
    forget_displacements();
    layers_.forget();
    return kCut;
  }
  const auto layers = divide(interval);
  for_places(shape_, [&](int row, int column) {
    const std::size_t i = cell(row, shape_.columns, column);
    measure_cell(row, column, interval, layers[i], cells[i]);
  });
  learn_noise();
  return 0;
}

} // namespace haptic
