// SPDX-License-Identifier: LGPL-2.1-or-later
// Tiles of a region in which something moves before a background. The mean of the tiles is the mean
// over the region.
#include "layers/region-layers.hpp"
#include "pixels/frame-change.hpp"
#include "pixels/frame-reduction.hpp"
#include "samples/region-size.hpp"
#include "tracking/ladder.hpp"
#include "tracking/layer-tiles.hpp"
#include "tracking/noise-estimate.hpp"
#include "tracking/region.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace haptic {
namespace {

constexpr float kUnknownInterval = 1.0F / 30; // s

class LayerTracker final : public PatchTracker {
public:
  LayerTracker() { forget(0); }
  int margin(int region_side) const override {
    return std::max(layer_margin(region_side), ladder_->margin(region_side));
  }
  bool measures_unchanged() const override { return true; }
  void set_max_points(int max_points) override {
    max_points_ = std::clamp(max_points, 1, kMaxPatches);
    ladder_->set_max_points(max_points);
  }
  void measure(const CropPair &pair, Measurement &measurement) override;
  void reset() override {
    forget(reductions_);
    frame_.forget();
    ladder_->reset();
    last_crop_ = {};
  }

private:
  static int reductions(int side) {
    int count = 0;
    while ((side >> count) > kLargestLayerRegion)
      ++count;
    return count;
  }

  static int layer_margin(int side) { return kLayerMargin << reductions(side); }
  Rectangle choose_crop(const CropPair &pair, int reductions) const;
  bool knows(const Rectangle &crop) const;
  bool divide(const CropPair &pair, const Rectangle &before,
              const std::optional<Displacement> &whole);
  void blend(Displacement whole, float part);
  void take_over(float part, const Measurement &ladder);
  float counts_for_region(Displacement whole);
  void forget(int reductions);
  void keep(const LumaView &view);
  FrameMotion frame_motion(const CropPair &pair, float seconds);
  int tiles_along() const;

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
  Measurement tiled_;
  float background_ = 0; // its share of the region
  float seconds_ = 0;    // that the layers have seen of the place
  int side_ = 0;         // px, of the region
  std::unique_ptr<Ladder> ladder_ = make_ladder();
  int translations_ = 0; // pairs in a row that one translation explains
};

// Each patch by its share of the pixels, if they were counted.
Displacement mean_of(std::span<const Patch> patches) {
  Displacement sum;
  float shares = 0;
  for (const Patch &patch : patches) {
    const float share = patch.share > 0 ? patch.share : 1;
    sum += share * Displacement{patch.dx, patch.dy};
    shares += share;
  }
  return shares > 0 ? 1 / shares * sum : Displacement{};
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
FrameMotion LayerTracker::frame_motion(const CropPair &pair, float seconds) {
  if (!pair.frames)
    return {};
  const auto scale = static_cast<float>(1 << reductions_);
  FrameMotion motion = frame_.follow(*pair.frames, seconds, scale * scale * noise_.variance(),
                                     scale * layers_.region_motion());
  motion.displacement = 1 / scale * motion.displacement;
  return motion;
}

int LayerTracker::tiles_along() const {
  int side = 1;
  while ((side + 1) * (side + 1) <= max_points_)
    ++side;
  return side;
}

// The part of the pair that the layers read. It stays while the region moves within it by half of
// the margin, as the region of a hand that trembles, and goes on by whole cells: what the layers
// know belongs to places of the frame. At a border of the frame it may lack less than a cell of the
// region.
Rectangle LayerTracker::choose_crop(const CropPair &pair, int reductions) const {
  const int margin = kLayerMargin << reductions;
  const auto around_region = [&](int distance) {
    const Rectangle wide = crop_around(pair.region, distance, pair.crop.x + pair.crop.width,
                                       pair.crop.y + pair.crop.height);
    const int left = std::max(wide.x, pair.crop.x);
    const int top = std::max(wide.y, pair.crop.y);
    return Rectangle{left, top, wide.x + wide.width - left, wide.y + wide.height - top};
  };
  const auto contains = [](const Rectangle &outer, const Rectangle &inner) {
    return inner.x >= outer.x && inner.y >= outer.y &&
           inner.x + inner.width <= outer.x + outer.width &&
           inner.y + inner.height <= outer.y + outer.height;
  };
  Rectangle crop = around_region(margin);
  if (last_crop_.width == crop.width && last_crop_.height == crop.height &&
      contains(pair.crop, last_crop_) && contains(last_crop_, around_region(margin / 2)))
    return last_crop_;
  if (reductions != reductions_ || !knows(crop))
    return crop;
  const int cell = kCellSide << reductions;
  const auto go_on = [cell](int last, int wanted, int least) {
    const int cells =
        static_cast<int>(std::lround(static_cast<float>(wanted - last) / static_cast<float>(cell)));
    const int nearest = last + cells * cell;
    return nearest < least ? nearest + cell : nearest;
  };
  crop.x = go_on(last_crop_.x, crop.x, pair.crop.x);
  crop.y = go_on(last_crop_.y, crop.y, pair.crop.y);
  crop.width = std::min(crop.width, pair.crop.x + pair.crop.width - crop.x);
  crop.height = std::min(crop.height, pair.crop.y + pair.crop.height - crop.y);
  return crop;
}

// Whether the layers have seen enough of it. A leap that leaves a fifth of the crop makes no larger
// steps than a hand that goes on slowly; layers that begin anew do.
bool LayerTracker::knows(const Rectangle &crop) const {
  constexpr float kEnough = 0.1F;
  const auto shared = [](int one, int length, int other, int other_length) {
    return std::max(0, std::min(one + length, other + other_length) - std::max(one, other));
  };
  return static_cast<float>(shared(crop.x, crop.width, last_crop_.x, last_crop_.width) *
                            shared(crop.y, crop.height, last_crop_.y, last_crop_.height)) >=
         kEnough * static_cast<float>(crop.width * crop.height);
}

CropPair part(const CropPair &pair, const Rectangle &crop) {
  const Rectangle inside{crop.x - pair.crop.x, crop.y - pair.crop.y, crop.width, crop.height};
  CropPair close = pair;
  close.crop = crop;
  close.previous = part_of(pair.previous, inside);
  close.current = part_of(pair.current, inside);
  return close;
}

// Leaves tiles. `whole`: the best translation of the region, px. False: the layers do not explain
// the pixels.
bool LayerTracker::divide(const CropPair &pair, const Rectangle &before,
                          const std::optional<Displacement> &whole) {
  tiled_.clear();
  const int count = reductions_;
  const Rectangle inside = intersection(pair.region, pair.crop);
  const Rectangle region{(inside.x - pair.crop.x) >> count, (inside.y - pair.crop.y) >> count,
                         inside.width >> count, inside.height >> count};
  const LumaView later = later_reduction_.reduce(pair.current, count);
  LumaView earlier = last_.view();
  const bool moves = pair.crop != before;
  const bool continues = has_last_ && pair.continues;
  if (!continues || moves)
    earlier = earlier_reduction_.reduce(pair.previous, count);
  if (continues && moves)
    layers_.carry((pair.crop.x - before.x) / (kCellSide << count),
                  (pair.crop.y - before.y) / (kCellSide << count), earlier, noise_.variance());
  const ChangeFinding change =
      find_change(part_of(earlier, region), part_of(later, region), noise_.variance());
  std::optional<Displacement> likely;
  if (whole)
    likely = 1 / static_cast<float>(1 << count) * *whole;
  layers_.read(earlier, later, continues, noise_.variance(), likely);
  const float seconds = pair.seconds > 0 ? pair.seconds : kUnknownInterval;
  const FrameMotion frame = frame_motion(pair, seconds);
  seconds_ = (continues ? seconds_ : 0) + std::min(seconds, kLongestStep);
  layers_.measure(frame, seconds, noise_.variance());
  keep(later);
  if (layers_.is_unrelated()) {
    forget(count);
    frame_.forget();
    return false;
  }
  const bool is_at_rest = change.change == Change::none;
  noise_.learn(is_at_rest ? change.energy : 2 * layers_.noise());
  background_ = add_tiles(layers_, region, tiles_along(), tiled_);
  if (is_at_rest && (frame.is_unchanged || is_slow(mean_of(tiled_.view()), noise_.variance()))) {
    tiled_.clear();
    tiled_.flags = kStill;
    return true;
  }
  tiled_.scale(static_cast<float>(1 << count));
  tiled_.shift(static_cast<float>(pair.crop.x), static_cast<float>(pair.crop.y));
  return !layers_.is_unexplained();
}

// The whole region moves by what explains its texture.
void LayerTracker::blend(Displacement whole, float part) {
  for (Patch &tile : tiled_.view()) {
    tile.dx += part * (whole.x - tile.dx);
    tile.dy += part * (whole.y - tile.dy);
  }
}

// From the mean over the ladder's patches to that over the tiles, without a step.
void LayerTracker::take_over(float part, const Measurement &ladder) {
  if (ladder.count == 0)
    return;
  const Displacement by =
      (1 - part) * (mean_of(ladder.view()) - mean_of(std::as_const(tiled_).view()));
  for (Patch &tile : tiled_.view()) {
    tile.dx += by.x;
    tile.dy += by.y;
  }
}

// How far one translation of the texture is one of the region. A leaf before a sky leaves no
// texture that contradicts its translation: the flat parts must have moved, too. A coder moves them
// in jumps, between frames in which they stand.
float LayerTracker::counts_for_region(Displacement whole) {
  constexpr float kLittle = 0.3F; // of the region: borders of what fills it
  constexpr float kMuch = 0.5F;
  constexpr int kSteady = 2; // pairs
  if (translations_ >= kSteady &&
      layers_.flat_parts_follow(1 / static_cast<float>(1 << reductions_) * whole,
                                noise_.variance()))
    return 1;
  return std::clamp((kMuch - background_) / (kMuch - kLittle), 0.0F, 1.0F);
}

void LayerTracker::measure(const CropPair &pair, Measurement &measurement) {
  const int side = std::max(pair.region.width, pair.region.height);
  const int count = reductions(side);
  const CropPair close = part(pair, choose_crop(pair, count));
  const Explanation simple = ladder_->measure_simply(pair, measurement);
  std::optional<Displacement> whole;
  if (simple == Explanation::translation || simple == Explanation::none)
    whole = ladder_->best_translation();
  const Rectangle seen = intersection(pair.region, close.crop);
  const bool is_wide = std::min(seen.width, seen.height) >> count >= kSmallestRegion / 2;
  const bool stays = count == reductions_ && knows(close.crop) && is_wide &&
                     simple != Explanation::fields && simple != Explanation::narrow;
  const Rectangle before = std::exchange(last_crop_, close.crop);
  translations_ = stays && simple == Explanation::translation ? translations_ + 1 : 0;
  if (!stays)
    forget(count);
  // What is hardly known is not known at another size.
  if (std::exchange(side_, side) != side && seconds_ < kSettled)
    seconds_ = 0;
  const bool divided = stays && divide(close, before, whole);
  const bool is_one = stays && simple != Explanation::none && simple != Explanation::unseen &&
                      simple != Explanation::sudden;
  const float counts = is_one ? counts_for_region(whole.value_or(Displacement{})) : 0;
  if (counts == 1)
    return;
  if (!divided || seconds_ < kWarm) {
    if (simple == Explanation::none)
      ladder_->measure_rest(measurement);
    return;
  }
  if (seconds_ < kSettled && simple == Explanation::none) {
    ladder_->measure_rest(measurement);
    if (tiled_.count == 0 && (tiled_.flags & kStill) == 0)
      return;
    take_over((seconds_ - kWarm) / (kSettled - kWarm), measurement);
  }
  if (simple != Explanation::periodic)
    blend(whole.value_or(Displacement{}), counts);
  // The ladder's mark of rest stays.
  if (simple == Explanation::rest &&
      is_slow(mean_of(tiled_.view()), static_cast<float>(1 << 2 * count) * noise_.variance()))
    return;
  measurement = tiled_;
}

} // namespace

std::unique_ptr<PatchTracker> make_layer_tracker() {
  return std::make_unique<LayerTracker>();
}

} // namespace haptic
