// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field-tracker.hpp"

#include "velocity-estimate.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

namespace haptic {
namespace {

constexpr int kNarrowestCell = 8;  // px of the frame
constexpr float kLargestCell = 32; // px of the reduced frame; half of it is enough
constexpr std::size_t kLevels = 3; // a patch of the coarsest covers one cell or two
constexpr int kCoarseSpacing = 6;  // px between patches of the coarsest level
constexpr int kReach = 5;          // px of the coarsest level
constexpr float kBlockSpacing = 8; // px between the blocks of one translation
constexpr float kGridSpacing = 6;  // px between the patches of a cell that does not move as one
constexpr int kIterations = 5;     // most Gauss-Newton steps of a patch
constexpr int kRefinements = 3;    // of a cell, whose start is good to a fraction of a pixel
constexpr float kSame2 = 1;        // px squared between starts not worth telling apart
constexpr float kUseless = 0.6F;   // correlation at which nothing was found again
constexpr float kGood = 0.9F;

int blocks_along(float length) {
  return std::max(2, parts_of(length, kBlockSpacing, 8));
}

int patches_along(float length) {
  return std::max(3, parts_of(length, kGridSpacing, 8));
}

float trust_of(const Translation &whole) {
  return std::clamp((whole.correlation - kUseless) / (kGood - kUseless), 0.0F, 1.0F);
}

} // namespace

FieldShape field_shape(int width, int height, double pixel_aspect, int columns) {
  const int most = std::max(1, std::min(width / kNarrowestCell, static_cast<int>(kMostFieldCells)));
  FieldShape shape;
  for (shape.columns = std::clamp(columns, 1, most);; --shape.columns) {
    const double side = width * pixel_aspect / shape.columns;
    shape.rows =
        static_cast<int>(std::clamp(std::round(height / side), 1.0, std::max(1.0, height / 8.0)));
    if (shape.columns == 1)
      shape.rows = std::min(shape.rows, static_cast<int>(kMostFieldCells));
    if (static_cast<std::size_t>(shape.cells()) <= kMostFieldCells)
      return shape;
  }
}

void FieldTracker::Starts::offer(Displacement start) {
  if (count_ < starts_.size() && std::ranges::none_of(view(), [&](Displacement other) {
        return norm2(other - start) < kSame2;
      }))
    starts_[count_++] = start;
}

void FieldTracker::set_frame(int width, int height, const FieldShape &shape) {
  width_ = width;
  height_ = height;
  shape_ = shape;
  reductions_ = 0;
  const float cell_side = std::min(static_cast<float>(width) / static_cast<float>(shape.columns),
                                   static_cast<float>(height) / static_cast<float>(shape.rows));
  while (cell_side / static_cast<float>(1 << reductions_) >= kLargestCell)
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
  forget();
}

float FieldTracker::noise_floor() const {
  constexpr float kRounding = 0.25F; // averages are rounded to 8 bits, two at a time
  return std::max(kRounding,
                  kAssumedNoise * kAssumedNoise / static_cast<float>(1 << (2 * reductions_)));
}

void FieldTracker::forget() {
  have_previous_ = false;
  previous_is_built_ = false;
  current_is_built_ = false;
  rows_read_ = 0;
  noise_ = noise_floor();
  for (Cell &cell : cells_)
    cell.last = {};
}

int FieldTracker::strip_rows() const {
  constexpr int kStrip = 16; // what fits into the fastest cache
  return std::max(kStrip, 1 << reductions_);
}

void FieldTracker::read(const LumaView &strip) {
  current_is_built_ = false;
  if (rows_read_ == current_.height)
    rows_read_ = 0;
  LumaView rows = strip;
  for (int i = 0; i < reductions_; ++i) {
    ByteImage &half = strips_[static_cast<std::size_t>(i & 1)];
    average_pairs(rows, half);
    rows = half.view();
  }
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

// Answers for the cells that did not change. False: there are no others.
bool FieldTracker::find_changes(std::span<FieldCell> cells) {
  bool any = false;
  for (int row = 0; row < shape_.rows; ++row)
    for (int column = 0; column < shape_.columns; ++column) {
      const std::size_t at = cell(row, shape_.columns, column);
      const Area area = area_of(row, column);
      const auto [change, energy] =
          find_change(part_of(previous_, area), part_of(current_, area), noise_);
      cells_[at].change = change;
      cells_[at].energy = energy;
      cells_[at].explained = false;
      cells[at] = {.confidence = change == Change::none ? 1.0F : 0.0F};
      any = any || change == Change::some;
    }
  return any;
}

void FieldTracker::build_pyramids() {
  if (!previous_is_built_)
    previous_pyramid_.build(previous_.view(), levels_);
  if (!current_is_built_)
    current_pyramid_.build(current_.view(), levels_);
  previous_is_built_ = current_is_built_ = true;
}

// Calls body(row, column) for the neighbours of a place and for itself.
template <typename Body>
void for_neighbours(const FieldShape &shape, int row, int column, Body &&body) {
  for (int y = std::max(0, row - 1); y <= std::min(shape.rows - 1, row + 1); ++y)
    for (int x = std::max(0, column - 1); x <= std::min(shape.columns - 1, column + 1); ++x)
      body(y, x);
}

// The place of another grid over the same frame that is nearest.
int parent(int index, int parts, int parent_parts) {
  return (2 * index + 1) * parent_parts / (2 * parts);
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

// Evenly spread patches of the coarsest level, wherever a cell near them changed.
void FieldTracker::follow_coarsely() {
  constexpr float kFound = 0.8F;
  constexpr float kClearlyBetter = 0.1F;
  const FieldShape &shape = coarse_shape_;
  const std::size_t level = levels_ - 1;
  const auto scale = static_cast<float>(1 << level);
  std::ranges::fill(coarse_is_needed_, std::uint8_t{0});
  std::ranges::fill(coarse_, Displacement{});
  for (int row = 0; row < shape_.rows; ++row)
    for (int column = 0; column < shape_.columns; ++column)
      if (cells_[cell(row, shape_.columns, column)].change == Change::some)
        for_neighbours(shape, parent(row, shape_.rows, shape.rows),
                       parent(column, shape_.columns, shape.columns),
                       [&](int y, int x) { coarse_is_needed_[cell(y, shape.columns, x)] = 1; });
  const Plane &earlier = previous_pyramid_.levels[level];
  const Plane &later = current_pyramid_.levels[level];
  patch_.side = kSmallPatch;
  for (int row = 0; row < shape.rows; ++row)
    for (int column = 0; column < shape.columns; ++column) {
      const std::size_t at = cell(row, shape.columns, column);
      if (!coarse_is_needed_[at])
        continue;
      const auto width = static_cast<float>(earlier.width()) / static_cast<float>(shape.columns);
      const auto height = static_cast<float>(earlier.height()) / static_cast<float>(shape.rows);
      place(earlier,
            {static_cast<float>(column) * width + kSmoothingRadius,
             static_cast<float>(row) * height + kSmoothingRadius, width, height},
            patch_);
      if (!has_texture(eigenvalues(patch_.structure).most, kSmallPatch * kSmallPatch,
                       noise_ / scale))
        continue;
      starts_.clear();
      starts_.offer({});
      starts_.offer(1 / scale *
                    cells_[cell(parent(row, shape.rows, shape_.rows), shape_.columns,
                                parent(column, shape.columns, shape_.columns))]
                        .last);
      if (column > 0)
        starts_.offer(coarse_[at - 1]);
      if (row > 0)
        starts_.offer(coarse_[cell(row - 1, shape.columns, column)]);
      Alignment found = align_template(later, patch_, starts_.view(), kIterations);
      if (found.fit.correlation < kFound) {
        const SearchResult elsewhere = search_template(later, patch_, {}, kReach);
        const Alignment other = align_template(later, patch_, {&elsewhere.best, 1}, kIterations);
        if (other.fit.correlation > found.fit.correlation + kClearlyBetter)
          found = other;
      }
      coarse_[at] = found.displacement;
    }
}

// One patch for each cell that changed, one level below the finest.
void FieldTracker::follow_cells() {
  const std::size_t level = levels_ > 1 ? 1 : 0;
  const float from_coarsest = static_cast<float>(1 << (levels_ - 1 - level));
  const float from_finest = 1 / static_cast<float>(1 << level);
  const Plane &earlier = previous_pyramid_.levels[level];
  const Plane &later = current_pyramid_.levels[level];
  patch_.side = kSmallPatch;
  for (int row = 0; row < shape_.rows; ++row)
    for (int column = 0; column < shape_.columns; ++column) {
      const std::size_t at = cell(row, shape_.columns, column);
      Cell &own = cells_[at];
      own.coarse = {};
      if (own.change != Change::some)
        continue;
      place(earlier, area_of(row, column).at_level(static_cast<int>(level)), patch_);
      starts_.clear();
      starts_.offer(from_finest * own.last);
      for_neighbours(coarse_shape_, parent(row, shape_.rows, coarse_shape_.rows),
                     parent(column, shape_.columns, coarse_shape_.columns), [&](int y, int x) {
                       starts_.offer(from_coarsest * coarse_[cell(y, coarse_shape_.columns, x)]);
                     });
      starts_.offer({});
      own.coarse =
          1 / from_finest * align_template(later, patch_, starts_.view(), kIterations).displacement;
    }
}

Translation FieldTracker::translate(int row, int column) {
  const Area area = area_of(row, column);
  blocks_.cover(previous_pyramid_.levels[0],
                {area.x - kSmoothingRadius, area.y - kSmoothingRadius, area.width, area.height},
                blocks_along(area.width), blocks_along(area.height), kSmallPatch, true);
  const Plane &later = current_pyramid_.levels[0];
  Cell &own = cells_[cell(row, shape_.columns, column)];
  starts_.clear();
  starts_.offer(own.coarse);
  for_neighbours(shape_, row, column, [&](int y, int x) {
    const Cell &other = cells_[cell(y, shape_.columns, x)];
    starts_.offer(other.coarse);
  });
  starts_.offer(own.last);
  Displacement start = starts_.view().front();
  if (starts_.view().size() > 1) {
    std::array<Fit, kMaxPatches> fits;
    float least = std::numeric_limits<float>::infinity();
    for (const Displacement other : starts_.view()) {
      const auto some = std::span(fits).first(blocks_.view().size());
      fit_templates(later, blocks_.view(), other, some);
      float squares = 0;
      float correlation = 0;
      for (const Fit &fit : some) {
        squares += fit.residual * fit.residual;
        correlation += fit.correlation;
      }
      if (squares < least) {
        least = squares;
        start = other;
      }
      if (correlation > kGood * static_cast<float>(some.size()))
        break;
    }
  }
  Translation whole = translate_blocks(later, blocks_.view(), start, kRefinements, noise_, true);
  const float longest = std::max(area.width, area.height);
  if (const float repeats =
          whole.one_direction ? 0 : period(previous_pyramid_.levels[0], blocks_.view(), longest);
      repeats > 0) {
    // Only the motion before can tell, and at first that slow motion is likelier than fast.
    whole = translate_blocks(later, blocks_.view(), own.last, kIterations, noise_, true);
    if (norm2(whole.displacement - own.last) > repeats * repeats / 16)
      whole.correlation = -1;
  }
  return whole;
}

// Most of what has texture was not found again.
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
      trust += trust_of(cell.whole);
    }
  return trust < kLeastTrust * candidates;
}

// The patches of a cell that does not move as one.
void FieldTracker::add_grid(int row, int column, const Area &area) {
  constexpr float kLeastTrust = 0.6F;
  const Plane &later = current_pyramid_.levels[0];
  grid_.cover(previous_pyramid_.levels[0], area, patches_along(area.width),
              patches_along(area.height), kSmallPatch, true);
  starts_.clear();
  starts_.offer(cells_[cell(row, shape_.columns, column)].whole.displacement);
  for_neighbours(shape_, row, column, [&](int y, int x) {
    const Cell &other = cells_[cell(y, shape_.columns, x)];
    if (other.change != Change::some)
      starts_.offer({});
    else if (other.explained)
      starts_.offer(other.whole.displacement);
  });
  float trust = 0;
  for (const Template &patch : grid_.view()) {
    const Alignment aligned = align_template(later, patch, starts_.view(), kIterations);
    trust += add_patch(patch, aligned.displacement, aligned.fit, noise_, measurement_);
  }
  if (trust < kLeastTrust * static_cast<float>(measurement_.candidates))
    measurement_.count = 0;
}

void FieldTracker::climb(int row, int column, double interval, FieldCell &answer) {
  constexpr float kNormalOnly = 0.4F; // across edges of one direction: half of the motion
  Cell &own = cells_[cell(row, shape_.columns, column)];
  if (own.change != Change::some || !own.has_texture) {
    own.last = {};
    return;
  }
  const Translation &whole = own.whole;
  own.last = own.explained ? whole.displacement : Displacement{};
  const Area cell_area = area_of(row, column);
  const Area area{cell_area.x - kSmoothingRadius, cell_area.y - kSmoothingRadius, cell_area.width,
                  cell_area.height};
  if (own.explained && is_still(whole)) {
    answer.confidence = 1;
    return;
  }
  measurement_.clear();
  if (own.explained && whole.correlation > kGood) {
    measurement_.candidates = 1;
    measurement_.add(patch_of(area, whole));
  } else {
    add_grid(row, column, area);
  }
  const auto scale = static_cast<float>(1 << reductions_);
  for (int i = 0; i < measurement_.count; ++i) {
    Patch &patch = measurement_.patches[static_cast<std::size_t>(i)];
    for (float *length : {&patch.x, &patch.y, &patch.width, &patch.height, &patch.dx, &patch.dy})
      *length *= scale;
    for (float *precision : {&patch.precision_xx, &patch.precision_xy, &patch.precision_yy})
      *precision /= scale * scale;
  }
  const VelocityEstimate estimate =
      estimate_velocity({.patches = measurement_.view(),
                         .candidates = measurement_.candidates,
                         .pointer_x = scale * (area.x + area.width / 2),
                         .pointer_y = scale * (area.y + area.height / 2),
                         .interval = interval,
                         .region_x = scale * area.x,
                         .region_y = scale * area.y,
                         .region_width = scale * area.width,
                         .region_height = scale * area.height},
                        Average::model, ModelChoice::automatic);
  if (!(estimate.confidence > 0))
    return;
  answer = {estimate.velocity_x, estimate.velocity_y,
            (estimate.aperture ? kNormalOnly : 1) * estimate.confidence};
}

// From the cells that turned out to stand still, whatever changed in them.
void FieldTracker::learn_noise() {
  constexpr float kLearning = 0.6F;
  constexpr float kMost = 150; // grey levels squared
  constexpr int kFew = 16;     // one cell in so many may be still by mistake
  float energy = 0;
  float count = 0;
  for (const Cell &cell : cells_)
    if (cell.change == Change::some && cell.explained && is_still(cell.whole)) {
      energy += cell.energy;
      ++count;
    }
  if (kFew * count >= static_cast<float>(cells_.size()))
    noise_ += kLearning * (std::clamp(energy / count / 2, noise_floor(), kMost) - noise_);
}

std::uint32_t FieldTracker::measure(double interval, std::span<FieldCell> cells) {
  std::ranges::fill(cells, FieldCell{});
  if (!have_previous_ || levels_ == 0)
    return 0;
  if (!find_changes(cells)) {
    for (Cell &cell : cells_)
      cell.last = {};
    const bool any_seen =
        std::ranges::any_of(cells, [](const FieldCell &cell) { return cell.confidence > 0; });
    return any_seen ? std::uint32_t{kStill} : 0;
  }
  build_pyramids();
  follow_coarsely();
  follow_cells();
  for (int row = 0; row < shape_.rows; ++row)
    for (int column = 0; column < shape_.columns; ++column) {
      Cell &own = cells_[cell(row, shape_.columns, column)];
      if (own.change != Change::some)
        continue;
      own.whole = translate(row, column);
      // What is left after the best fit tells more of the noise than what was learned before.
      own.has_texture = has_texture(eigenvalues(own.whole.structure).most, own.whole.pixels,
                                    std::min(noise_, own.whole.residual2 / kSmoothedNoise));
      own.explained = explains(own.whole, kSmallPatch, noise_);
    }
  if (is_cut()) {
    std::ranges::fill(cells, FieldCell{});
    for (Cell &cell : cells_)
      cell.last = {};
    return kCut;
  }
  for (int row = 0; row < shape_.rows; ++row)
    for (int column = 0; column < shape_.columns; ++column)
      climb(row, column, interval, cells[cell(row, shape_.columns, column)]);
  learn_noise();
  return 0;
}

} // namespace haptic
