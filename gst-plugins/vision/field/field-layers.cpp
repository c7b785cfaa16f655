// SPDX-License-Identifier: LGPL-2.1-or-later
#include "field/field-layers.hpp"

#include "pixels/frame-change.hpp"
#include "samples/region-size.hpp"
#include "tracking/layer-tiles.hpp"
#include "velocity/velocity-estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace haptic {
namespace {

constexpr float kAsleep = 1; // s without a change, after which a block is not read

// A frame in memory.
class WholeLuma final : public LumaSource {
public:
  explicit WholeLuma(const LumaView &view) : view_(view) {}
  LumaView plane(const Rectangle &area) const override { return part_of(view_, area); }
  void convert(const Rectangle &area, std::uint8_t *to, std::ptrdiff_t stride) const override {
    const LumaView part = part_of(view_, area);
    for (int y = 0; y < part.height; ++y)
      std::copy_n(part.pixels + y * part.stride, part.width, to + y * stride);
  }

private:
  LumaView view_;
};

int edge(int index, int length, int parts) {
  return index * length / parts;
}

} // namespace

void FieldLayers::forget(Block &block) const {
  block.layers.forget();
  block.noise.reset(assumed_variance(all_reductions_), kRoundingVariance);
  block.seen = 0;
  block.continues = false;
}

void FieldLayers::set_frame(int width, int height, const FieldShape &shape, float region,
                            int reductions) {
  reductions_ = 0;
  while (region / static_cast<float>(1 << reductions_) > kLargestLayerRegion)
    ++reductions_;
  all_reductions_ = reductions + reductions_;
  width_ = width >> reductions_;
  height_ = height >> reductions_;
  shape_ = shape;
  found_.assign(static_cast<std::size_t>(shape.cells()), {});
  blocks_.clear();
  const auto cells_of_block = [](int length, int parts) {
    int count = 1;
    while (count < parts && edge(count + 1, length, parts) + 1 <= kLargestLayerRegion)
      ++count;
    return count;
  };
  const int columns = cells_of_block(width_, shape.columns);
  const int rows = cells_of_block(height_, shape.rows);
  for (int row = 0; row < shape.rows; row += rows)
    for (int column = 0; column < shape.columns; column += columns) {
      auto block = std::make_unique<Block>();
      block->column = column;
      block->row = row;
      block->columns = std::min(columns, shape.columns - column);
      block->rows = std::min(rows, shape.rows - row);
      const Rectangle area = area_of(*block);
      block->crop = intersection({area.x - kLayerMargin, area.y - kLayerMargin,
                                  area.width + 2 * kLayerMargin, area.height + 2 * kLayerMargin},
                                 {0, 0, width_, height_});
      if (std::min(area.width, area.height) >= kSmallestRegion / 2 &&
          std::max(area.width, area.height) <= kLargestLayerRegion)
        blocks_.push_back(std::move(block));
    }
  forget();
}

void FieldLayers::forget() {
  for (auto &block : blocks_)
    forget(*block);
  frame_.forget();
}

Rectangle FieldLayers::area_of(int column, int row, int columns, int rows) const {
  const int left = edge(column, width_, shape_.columns);
  const int top = edge(row, height_, shape_.rows);
  return {left, top, edge(column + columns, width_, shape_.columns) - left,
          edge(row + rows, height_, shape_.rows) - top};
}

// A block in which nothing changes for long is not read; the first change after it begins anew. Nor
// is one whose rows show two times.
void FieldLayers::wake(Block &block, const LumaView &now, float seconds,
                       std::span<const CellFinding> cells) {
  bool is_unchanged = true;
  for_cells_of(block, [&](std::size_t i, int, int) {
    is_unchanged = is_unchanged && cells[i].is_unchanged;
  });
  block.unchanged = is_unchanged ? block.unchanged + seconds : 0;
  const bool is_woven =
      all_reductions_ == 0 && is_combed(part_of(now, block.crop), block.noise.variance());
  block.is_awake = block.unchanged < kAsleep && !is_woven;
  if (!block.is_awake)
    forget(block);
}

// The mean translation of the cells that one explains, px of the reduced frame.
std::optional<Displacement> FieldLayers::likely(const Block &block,
                                                std::span<const CellFinding> cells) const {
  Displacement sum;
  float count = 0;
  for_cells_of(block, [&](std::size_t i, int, int) {
    if (const auto &one = cells[i].translation; one && norm2(*one) > 0) {
      sum += *one;
      ++count;
    }
  });
  if (count == 0)
    return {};
  return 1 / (count * static_cast<float>(1 << reductions_)) * sum;
}

// Fits zoom, roll and translation to the cells that tell, by least squares with weights that fall
// with the error (Geman and McClure), so that what moves by itself does not count.
// find_camera_motion() takes 3 ms for a frame, and this some us.
void FieldLayers::find_camera(const FrameMotion &whole, std::span<const CellFinding> cells) {
  constexpr int kRounds = 12;
  constexpr float kWide = 32;         // px, of the first weights
  constexpr float kTolerance = 0.25F; // px
  constexpr float kRelative = 0.03F;  // of the displacement
  constexpr float kFewest = 16;       // cells that say something about a whole frame
  constexpr float kMany = 0.35F;      // of the cells
  constexpr float kClearly = 0.15F;   // of the cells
  constexpr float kLeastBend = 1;     // px at the border of the frame
  camera_ = {};
  const float scale = 1 / static_cast<float>(1 << reductions_);
  const auto for_told = [&](auto &&body) {
    for (int row = 0; row < shape_.rows; ++row)
      for (int column = 0; column < shape_.columns; ++column)
        if (const auto &one = cells[tile_at(row, shape_.columns, column)].translation)
          body((static_cast<float>(column) + 0.5F) / static_cast<float>(shape_.columns) *
                       static_cast<float>(width_) -
                   0.5F * static_cast<float>(width_),
               (static_cast<float>(row) + 0.5F) / static_cast<float>(shape_.rows) *
                       static_cast<float>(height_) -
                   0.5F * static_cast<float>(height_),
               scale * *one);
  };
  const auto share_of = [&](auto &&model) {
    float all = 0;
    float agree = 0;
    for_told([&](float x, float y, Displacement moved) {
      const Displacement expected = model(x, y);
      const float most = kTolerance + kRelative * std::sqrt(norm2(expected));
      ++all;
      agree += norm2(moved - expected) < most * most;
    });
    return all < kFewest ? 1 : agree / all;
  };
  const Displacement translation = whole.certainty > 0 ? whole.displacement : Displacement{};
  const float by_translation = share_of([&](float, float) { return translation; });
  if (by_translation > kMany)
    return;
  Camera found;
  for (int round = 0; round < kRounds; ++round) {
    const float far = std::max(kWide / static_cast<float>(1 << round), kTolerance);
    float weights = 0;
    float places_x = 0;
    float places_y = 0;
    float square = 0;
    float zoom = 0;
    float roll = 0;
    Displacement sum;
    for_told([&](float x, float y, Displacement moved) {
      const float error2 = round == 0 ? 0 : norm2(moved - found.at(x, y));
      const float part = far * far / (far * far + error2);
      const float weight = part * part;
      weights += weight;
      places_x += weight * x;
      places_y += weight * y;
      sum += weight * moved;
      square += weight * (x * x + y * y);
      zoom += weight * (x * moved.x + y * moved.y);
      roll += weight * (x * moved.y - y * moved.x);
    });
    const float x = places_x / weights;
    const float y = places_y / weights;
    const Displacement mean = 1 / weights * sum;
    const float spread = std::max(square - weights * (x * x + y * y), 1e-6F);
    found.zoom = (zoom - weights * (x * mean.x + y * mean.y)) / spread;
    found.roll = (roll - weights * (x * mean.y - y * mean.x)) / spread;
    found.middle = {mean.x - found.zoom * x + found.roll * y,
                    mean.y - found.roll * x - found.zoom * y};
  }
  const float share = share_of([&](float x, float y) { return found.at(x, y); });
  const float at_rest = share_of([](float, float) { return Displacement{}; });
  const float bend = std::hypot(found.zoom, found.roll) * static_cast<float>(width_) / 2;
  if (share < kMany || share < std::max(by_translation, at_rest) + kClearly || bend < kLeastBend)
    return;
  camera_ = found;
  camera_.is_known = true;
}

// What the camera makes of the middle of an area.
Displacement FieldLayers::camera_at(const Rectangle &area) const {
  const auto middle = [](int from, int length, int all) {
    return static_cast<float>(from) + 0.5F * static_cast<float>(length - all);
  };
  return camera_.at(middle(area.x, area.width, width_), middle(area.y, area.height, height_));
}

// The translation of the frame that holds for a block.
FrameMotion FieldLayers::motion_of(const Block &block, const FrameMotion &whole) const {
  if (!camera_.is_known)
    return whole;
  return {camera_at(area_of(block)), 1, whole.is_unchanged};
}

// As that of a region of interest.
float FieldLayers::confidence_of(const Block &block, float seconds) const {
  constexpr int kParts = 4;
  const Rectangle region = in_crop(area_of(block), block);
  Measurement measurement;
  measurement.clear();
  add_tiles(block.layers, region, kParts, measurement);
  const auto x = static_cast<float>(region.x);
  const auto y = static_cast<float>(region.y);
  const auto width = static_cast<float>(region.width);
  const auto height = static_cast<float>(region.height);
  return estimate_velocity({.patches = measurement.view(),
                            .candidates = measurement.candidates,
                            .pointer_x = x + width / 2,
                            .pointer_y = y + height / 2,
                            .interval = seconds,
                            .region_x = x,
                            .region_y = y,
                            .region_width = width,
                            .region_height = height,
                            .is_tiled = true},
                           Average::model, ModelChoice::automatic)
      .confidence;
}

void FieldLayers::add_up(const Block &block, float seconds) {
  const float confidence = confidence_of(block, seconds);
  if (!(confidence > 0))
    return;
  const float counts = std::clamp((block.seen - kWarm) / (kSettled - kWarm), 0.0F, 1.0F);
  for_cells_of(block, [&](std::size_t i, int column, int row) {
    const Rectangle area = area_of(column, row, 1, 1);
    LayerTile tile;
    block.layers.sum(in_crop(area, block), 1, 1, {&tile, 1});
    if (!is_seen(tile))
      return;
    if (camera_.is_known) // the layers know one motion of it for the block
      tile.displacement += tile.background * (camera_at(area) - camera_at(area_of(block)));
    found_[i] = {.displacement = static_cast<float>(1 << reductions_) * tile.displacement,
                 .background = tile.background,
                 .confidence = confidence,
                 .counts = counts,
                 .is_slow = is_slow(tile.displacement, block.noise.variance())};
  });
}

std::span<const LayerFinding> FieldLayers::measure(const LumaView &earlier, const LumaView &later,
                                                   float seconds,
                                                   std::span<const CellFinding> cells) {
  std::ranges::fill(found_, LayerFinding{});
  const LumaView before = earlier_.reduce(earlier, reductions_);
  const LumaView now = later_.reduce(later, reductions_);
  float noise = 0;
  float awake = 0;
  Displacement other;
  float best = 0;
  for (auto &block : blocks_) {
    wake(*block, now, seconds, cells);
    if (!block->is_awake)
      continue;
    block->layers.read(part_of(before, block->crop), part_of(now, block->crop), block->continues,
                       block->noise.variance(), likely(*block, cells));
    noise += block->noise.variance();
    ++awake;
    if (const Displacement one = block->layers.region_motion(); norm2(one) > best) {
      best = norm2(one);
      other = one;
    }
  }
  if (awake == 0)
    return found_;
  const WholeLuma one(before);
  const WholeLuma two(now);
  const FrameMotion motion =
      frame_.follow({one, two, width_, height_}, seconds, noise / awake, other);
  find_camera(motion, cells);
  for (auto &block : blocks_) {
    if (!block->is_awake)
      continue;
    block->layers.measure(motion_of(*block, motion), seconds, block->noise.variance());
    block->continues = true;
    block->seen += std::min(seconds, kLongestStep);
    if (block->layers.is_unrelated()) {
      forget(*block);
      continue;
    }
    block->noise.learn(2 * block->layers.noise());
    if (!block->layers.is_unexplained() && block->seen >= kWarm)
      add_up(*block, seconds);
  }
  return found_;
}

} // namespace haptic
