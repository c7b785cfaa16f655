// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion of a region as two layers: a background that is flat or calm, and what moves before
// it. The mean over the region is that of (1 - share) flow + share * background.
#pragma once

#include "layers/background-motion.hpp"
#include "layers/calm-cells.hpp"
#include "layers/flat-things.hpp"
#include "layers/foreground-flow.hpp"
#include "layers/frame-translation.hpp"
#include "layers/layer-kernels.hpp"
#include "layers/layer-maps.hpp"
#include "layers/light-change.hpp"
#include "layers/region-translation.hpp"
#include "layers/segmentation.hpp"

#include <array>
#include <optional>
#include <span>

namespace haptic {

/// A part of the region.
struct LayerTile {
  Displacement displacement; ///< px, mean over the tile
  Tensor precision;          ///< of it, 1/px^2
  float residual2 = 0;       ///< mean square, grey levels squared
  float background = 0;      ///< share of it in the tile, 0..1
};

/// One instance serves one place of one stream.
class RegionLayers {
public:
  /// The next pair has nothing to do with those before.
  void forget();

  /// The crop of the call before went on by so many cells. `earlier`: the later frame of that call,
  /// as the crop shows it now. What is known of the places that both show stays.
  void carry(int right, int down, const LumaView &earlier, float noise);

  /// Reads a pair of crops of one size, whose sides are at most kLayerSide. `continues`: the
  /// earlier one is the later one of the call before. `noise`: variance of a pixel, grey levels
  /// squared.
  /// `likely`: a translation of the region, px; nothing: it is not known.
  void read(const LumaView &earlier, const LumaView &later, bool continues, float noise,
            const std::optional<Displacement> &likely = {});

  /// The translation of the crop, as a second start for that of the frame. Call it after read().
  Displacement region_motion() const { return region_.displacement; }

  /// Measures the pair after read(). `frame` in px of the crop.
  void measure(const FrameMotion &frame, float seconds, float noise);

  /// Nothing of the earlier crop is found in the later one.
  bool is_unrelated() const { return is_unrelated_; }

  /// The motions do not explain most of the texture of the later crop.
  bool is_unexplained() const { return is_unexplained_; }

  /// Whether the flat parts moved by so many px, and did not rest.
  bool flat_parts_follow(Displacement by, float noise);

  /// Tiles of equal size that cover the region, which lies in the crop; row by row.
  void sum(const Rectangle &region, int columns, int rows, std::span<LayerTile> tiles) const;

  /// Variance of the noise of a pixel, from what the motion does not explain.
  float noise() const { return noise_; }

private:
  LayerFrame &earlier() { return frames_[now_ ^ 1U]; }
  LayerFrame &later() { return frames_[now_]; }
  void follow_flat_parts(float seconds, float frame_moves);
  void judge(float noise);

  LayerSize size_;
  std::array<LayerFrame, 2> frames_;
  unsigned now_ = 0;
  bool is_cold_ = true;
  bool is_lost_ = true;   // the pair before was hardly explained
  float frame_moves_ = 0; // of the pair before
  Displacement frame_displacement_;
  float flat_parts_move_ = 0; // how surely flat parts belong to the texture that moves, 0..1
  float flat_parts_seen_ = 0; // s
  bool is_unexplained_ = false;
  bool is_unrelated_ = false;
  float noise_ = 0;      // of this pair
  float noise_used_ = 0; // as it was known before
  float blend_ = 0;      // how far the region is one translation, with the frame
  ExplainedTranslation region_;
  ExplainedTranslation region_before_;
  LightChange light_;
  RegionTranslation translation_;
  CalmCells calm_;
  FlatThings things_;
  Segmentation segmentation_;
  BackgroundMotion background_;
  ForegroundFlow foreground_;
  CellMap background_cells_;
  CellMap rest_energy_;
  CellMap moved_energy_;
  VectorMap<CellMap> background_motion_;
  std::array<float, static_cast<std::size_t>(kLayerSide / kCellSide) * (kLayerSide / kCellSide)>
      sorted_;
};

} // namespace haptic
