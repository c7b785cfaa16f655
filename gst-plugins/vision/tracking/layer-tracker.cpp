// SPDX-License-Identifier: LGPL-2.1-or-later
// Tiles of a region in which something moves before a background. The mean of the tiles is the mean
// over the region.
#include "layers/region-layers.hpp"
#include "pixels/frame-change.hpp"
#include "pixels/frame-reduction.hpp"
#include "samples/region-size.hpp"
#include "tracking/noise-estimate.hpp"
#include "tracking/patch-tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace haptic {
namespace {

constexpr float kLayerNoiseRate = 0.1F;
constexpr float kUnknownInterval = 1.0F / 30; // s

class LayerTracker final : public PatchTracker {
public:
  LayerTracker() { forget(0); }
  int margin(int region_side) const override { return kLayerMargin << reductions(region_side); }
  bool measures_unchanged() const override { return true; }
  void set_max_points(int max_points) override {
    max_points_ = std::clamp(max_points, 1, kMaxPatches);
  }
  void measure(const CropPair &pair, Measurement &measurement) override;
  void reset() override {
    forget(reductions_);
    frame_.forget();
  }

private:
  static int reductions(int side) {
    int count = 0;
    while ((side >> count) > kLargestLayerRegion)
      ++count;
    return count;
  }

  void forget(int reductions);
  void keep(const LumaView &view);
  FrameMotion frame_motion(const CropPair &pair);
  void add_tiles(const Rectangle &region, Measurement &measurement);

  int max_points_ = kUsualPatches;
  int reductions_ = 0; // of the frames
  Rectangle last_crop_;
  ByteImage last_; // the later crop of the pair before, reduced
  bool has_last_ = false;
  FrameReduction earlier_reduction_;
  FrameReduction later_reduction_;
  NoiseEstimate noise_{kLayerNoiseRate};
  FrameTranslation frame_;
  RegionLayers layers_;
  std::array<LayerTile, kMaxPatches> tiles_;
};

LumaView part(const LumaView &view, const Rectangle &area) {
  return {view.pixels + area.y * view.stride + area.x, area.width, area.height, view.stride};
}

bool same_pixels(const LumaView &one, const LumaView &other) {
  if (one.width != other.width || one.height != other.height)
    return false;
  for (int y = 0; y < one.height; ++y)
    if (std::memcmp(one.pixels + y * one.stride, other.pixels + y * other.stride,
                    static_cast<std::size_t>(one.width)) != 0)
      return false;
  return true;
}

// Whether the mean of the patches is less than noise makes it.
bool is_slow(const Measurement &measurement) {
  constexpr float kSlow = 0.02F; // px
  Displacement sum;
  for (const Patch &patch : measurement.view())
    sum += {patch.dx, patch.dy};
  const float most = kSlow * static_cast<float>(measurement.count);
  return norm2(sum) <= most * most;
}

void LayerTracker::forget(int reductions) {
  reductions_ = reductions;
  has_last_ = false;
  layers_.forget();
  noise_.reset(assumed_variance(reductions), kRoundingVariance);
}

void LayerTracker::keep(const LumaView &view) {
  last_.width = view.width;
  last_.height = view.height;
  last_.pixels.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
  for (int y = 0; y < view.height; ++y)
    std::copy_n(view.pixels + y * view.stride, view.width,
                last_.pixels.data() + std::ptrdiff_t{y} * view.width);
  has_last_ = true;
}

// In px of the reduced crop.
FrameMotion LayerTracker::frame_motion(const CropPair &pair) {
  if (!pair.frames)
    return {};
  const auto scale = static_cast<float>(1 << reductions_);
  FrameMotion motion = frame_.follow(*pair.frames, scale * scale * noise_.variance(),
                                     scale * layers_.region_motion());
  motion.displacement = 1 / scale * motion.displacement;
  return motion;
}

// Flat parts of the background are area that moves as the background does. Without them, the mean
// would be that of the leaf before them.
void LayerTracker::add_tiles(const Rectangle &region, Measurement &measurement) {
  constexpr float kSeen = 4;   // 1/px^2: a deviation of 0.5 px
  constexpr float kUnseen = 1; // 1/px^2, of one tile
  constexpr float kAllBackground = 0.9F;
  int columns = 1;
  while ((columns + 1) * (columns + 1) <= max_points_)
    ++columns;
  const int rows = columns;
  const auto tiles = std::span(tiles_).first(tile_at(rows, columns, 0));
  layers_.sum(region, columns, rows, tiles);
  Tensor all;
  float background = 0;
  for (const LayerTile &tile : tiles) {
    all += tile.precision;
    background += tile.background / static_cast<float>(tiles.size());
  }
  const auto [least, most] = eigenvalues(all);
  // Slopes of one direction show only a part of the drift of a sky.
  if (most < kSeen || (background > kAllBackground && least < kSeen))
    return;
  const float wide = static_cast<float>(region.width) / static_cast<float>(columns);
  const float high = static_cast<float>(region.height) / static_cast<float>(rows);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const LayerTile &tile = tiles[tile_at(row, columns, column)];
      Tensor precision = tile.precision;
      if (precision.xx + precision.yy < kUnseen) {
        if (tile.background < 0.5F)
          continue;
        precision += {kUnseen, 0, kUnseen};
      }
      measurement.add({static_cast<float>(region.x) + (static_cast<float>(column) + 0.5F) * wide,
                       static_cast<float>(region.y) + (static_cast<float>(row) + 0.5F) * high, wide,
                       high, tile.displacement.x, tile.displacement.y, precision.xx, precision.xy,
                       precision.yy, std::sqrt(tile.residual2), 0});
    }
  measurement.candidates = measurement.count;
  measurement.flags = kTiled;
}

void LayerTracker::measure(const CropPair &pair, Measurement &measurement) {
  measurement.clear();
  const int count = reductions(std::max(pair.region.width, pair.region.height));
  if (count != reductions_)
    forget(count);
  const Rectangle region{(pair.region.x - pair.crop.x) >> count,
                         (pair.region.y - pair.crop.y) >> count, pair.region.width >> count,
                         pair.region.height >> count};
  // A strip along a border of the frame may have become too narrow, and a crop may have the margin
  // of another tracker.
  if (std::min(region.width, region.height) < kSmallestRegion / 2 ||
      std::max(pair.crop.width, pair.crop.height) >> count > kLayerSide) {
    has_last_ = false;
    return;
  }
  const LumaView later = later_reduction_.reduce(pair.current, count);
  const bool is_same_place = has_last_ && pair.crop == last_crop_;
  LumaView earlier = last_.view();
  bool continues = is_same_place && pair.continues;
  if (!continues) {
    earlier = earlier_reduction_.reduce(pair.previous, count);
    // After frames that repeated the last one.
    continues = is_same_place && pair.repeats > 0 && same_pixels(earlier, last_.view());
  }
  last_crop_ = pair.crop;
  const ChangeFinding change =
      find_change(part(earlier, region), part(later, region), noise_.variance());
  layers_.read(earlier, later, continues, noise_.variance());
  const FrameMotion frame = frame_motion(pair);
  layers_.measure(frame, pair.seconds > 0 ? pair.seconds : kUnknownInterval, noise_.variance());
  keep(later);
  if (layers_.is_unrelated()) {
    measurement.flags = kCut;
    reset();
    return;
  }
  const bool is_at_rest = change.change == Change::none;
  noise_.learn(is_at_rest ? change.energy : 2 * layers_.noise());
  add_tiles(region, measurement);
  if (is_at_rest && (frame.is_unchanged || is_slow(measurement))) {
    measurement.clear();
    measurement.flags = kStill;
    return;
  }
  measurement.scale(static_cast<float>(1 << count));
  measurement.shift(static_cast<float>(pair.crop.x), static_cast<float>(pair.crop.y));
}

} // namespace

std::unique_ptr<PatchTracker> make_layer_tracker() {
  return std::make_unique<LayerTracker>();
}

} // namespace haptic
