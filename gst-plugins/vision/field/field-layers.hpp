// SPDX-License-Identifier: LGPL-2.1-or-later
// The layers of a whole frame: blocks of cells, each of which is a region of its own.
#pragma once

#include "layers/frame-translation.hpp"
#include "layers/region-layers.hpp"
#include "pixels/frame-reduction.hpp"
#include "samples/motion-field.hpp"
#include "tracking/layer-tiles.hpp"
#include "tracking/noise-estimate.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace haptic {

/// What is known of a cell without the layers. px of the frames that measure() gets.
struct CellFinding {
  bool is_unchanged = false; ///< no more than noise changed
  /// One translation explains it: 0 if it would have shown a motion.
  std::optional<Displacement> translation;
};

/// What the layers say of a cell.
struct LayerFinding {
  Displacement displacement; ///< px of the frames that measure() gets
  float background = 0;      ///< its share of the cell, 0..1
  float confidence = 0;      ///< 0..1; 0: they say nothing, and all else is 0
  float counts = 0;          ///< 0..1: less than 1 until they have seen enough of the place
  bool is_slow = false;      ///< no more than what noise makes of rest
};

/// One instance serves one stream, from one thread at a time.
class FieldLayers {
public:
  /// Size of the frames that follow, and of their cells. `region`: side of a region of interest,
  /// px. `reductions`: times that the frames were halved already. Forgets all earlier frames.
  void set_frame(int width, int height, const FieldShape &shape, float region, int reductions);

  /// The next pair has nothing to do with those before.
  void forget();

  /// Compares two frames. If there was a call since forget(), the earlier frame is the later one of
  /// that call, or shows the same but for noise. The results are valid until the next call, one for
  /// each cell.
  std::span<const LayerFinding> measure(const LumaView &earlier, const LumaView &later,
                                        float seconds, std::span<const CellFinding> cells);

private:
  /// A block of cells.
  struct Block {
    int column = 0, row = 0;   // of its first cell
    int columns = 0, rows = 0; // cells
    Rectangle crop;            // px of the reduced frame
    RegionLayers layers;
    NoiseEstimate noise{kLayerNoiseRate};
    float seen = 0;         // s
    float unchanged = 0;    // s
    bool is_awake = false;  // it reads this pair
    bool continues = false; // it read the pair before
  };
  /// What most cells move by, if it is no translation.
  struct Camera {
    bool is_known = false;
    Displacement middle; // px of the reduced frame, at its centre
    float zoom = 0;      // px per px from the centre
    float roll = 0;
    Displacement at(float x, float y) const {
      return {middle.x + zoom * x - roll * y, middle.y + roll * x + zoom * y};
    }
  };

  void forget(Block &block) const;
  /// Calls body(index) for each cell of the block.
  template <typename Body>
  void for_cells_of(const Block &block, Body &&body) const {
    for (int row = block.row; row < block.row + block.rows; ++row)
      for (int column = block.column; column < block.column + block.columns; ++column)
        body(tile_at(row, shape_.columns, column), column, row);
  }

  /// Of cells, px of the reduced frame.
  Rectangle area_of(int column, int row, int columns, int rows) const;
  Rectangle area_of(const Block &block) const {
    return area_of(block.column, block.row, block.columns, block.rows);
  }
  static Rectangle in_crop(const Rectangle &area, const Block &block) {
    return {area.x - block.crop.x, area.y - block.crop.y, area.width, area.height};
  }
  Displacement camera_at(const Rectangle &area) const;
  FrameMotion motion_of(const Block &block, const FrameMotion &whole) const;
  void find_camera(const FrameMotion &whole, std::span<const CellFinding> cells);
  void wake(Block &block, const LumaView &now, float seconds, std::span<const CellFinding> cells);
  std::optional<Displacement> likely(const Block &block, std::span<const CellFinding> cells) const;
  void add_up(const Block &block, float seconds);
  float confidence_of(const Block &block, float seconds) const;

  int width_ = 0; // px, of the reduced frame
  int height_ = 0;
  int reductions_ = 0;     // times that measure() halves the frames
  int all_reductions_ = 0; // with those before
  FieldShape shape_;
  std::vector<std::unique_ptr<Block>> blocks_;
  FrameTranslation frame_;
  FrameReduction earlier_;
  FrameReduction later_;
  std::vector<LayerFinding> found_;
  Camera camera_; // of this pair
};

} // namespace haptic
