// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion of a whole frame on a grid of cells, from one reading of its luma.
#pragma once

#include "field/field-layers.hpp"
#include "patches/block-translation.hpp"
#include "patches/pixel-votes.hpp"
#include "patches/start-set.hpp"
#include "pixels/frame-change.hpp"
#include "pixels/frame-reduction.hpp"
#include "samples/motion-field.hpp"
#include "tracking/noise-estimate.hpp"
#include "velocity/velocity-estimate.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace haptic {

/// Coarse to fine over the whole frame, then for each cell the steps of the trackers of a region:
/// unchanged, one translation, layers; where those have not seen enough yet, a grid of patches.
/// Stores of a frame only what the comparison with
/// the next one needs. One instance serves one stream, from one thread at a time.
class FieldTracker {
public:
  /// Size of the frames that follow, and of their fields. Forgets all earlier frames.
  void set_frame(int width, int height, const FieldShape &shape);

  /// Height of the strips for read(); the last strip of a frame may be lower.
  int strip_rows() const;

  /// Reads the next frame, strip by strip from its top.
  void read(const LumaView &strip);

  /// Makes the frame read last the earlier one.
  void keep();

  /// Forgets all earlier frames and the noise.
  void forget();

  /// Whether the frame read last is equal to the earlier one.
  bool repeats() const;

  /// Measures from the earlier frame to the one read last, `interval` seconds later. Fills all
  /// cells of the shape and returns kStill, kCut or 0.
  std::uint32_t measure(double interval, std::span<FieldCell> cells);

private:
  // Displacements in px of the level named.
  struct Cell {
    Change change = Change::none;
    float energy = 0;    // of the change
    Displacement last;   // between the two frames before, finest level
    Displacement coarse; // level 1
    Translation whole;   // finest level
    bool explained = false;
    bool has_texture = false;
  };

  Cell &at(int row, int column) { return cells_[cell(row, shape_.columns, column)]; }
  // Of a cell, px of the reduced frame.
  Area area_of(int row, int column) const;
  LumaView part_of(const ByteImage &frame, const Area &area) const;
  bool find_changes(std::span<FieldCell> cells);
  void build_pyramids();
  void mark_coarse_patches();
  void align_coarse_patches();
  void add_coarse_starts(int row, int column, float scale);
  void align_coarse_patch(int row, int column);
  void align_cell_patch(int row, int column);
  Displacement best_start(const Plane &later);
  Translation translate(int row, int column);
  void translate_cells();
  bool is_cut() const;
  static std::optional<Displacement> displacement_of(const Cell &cell);
  bool is_near_border(int row, int column);
  void add_grid(int row, int column, const Area &area);
  void gather_voters(int row, int column, const Area &area);
  std::optional<Displacement> vote(int row, int column, const Area &area);
  VelocityEstimate estimate(const Area &area, double interval);
  void measure_patches(int row, int column, double interval, FieldCell &result);
  std::span<const LayerFinding> divide(double interval);
  void measure_cell(int row, int column, double interval, const LayerFinding &layers,
                    FieldCell &result);
  void learn_noise();
  void forget_displacements();

  int width_ = 0;  // px, of the frame
  int height_ = 0; // px
  FieldShape shape_;
  int reductions_ = 0; // times that the frame was halved
  int rows_read_ = 0;  // of the reduced frame
  bool have_previous_ = false;
  bool previous_is_built_ = false;
  bool current_is_built_ = false;
  NoiseEstimate noise_{kLearningRate}; // of the reduced frame
  std::size_t levels_ = 0;             // large enough for a patch; 0: the frame is too small
  FrameReduction reduction_;
  ByteImage previous_;
  ByteImage current_;
  Pyramid previous_pyramid_;
  Pyramid current_pyramid_;
  std::vector<Cell> cells_;
  FieldShape coarse_shape_;
  std::vector<std::uint8_t> coarse_is_needed_;
  std::vector<Displacement> coarse_; // px of the coarsest level
  Template patch_;
  PatchGrid blocks_;
  PatchGrid grid_;
  StartSet starts_;
  Measurement measurement_;
  Measurement voters_;
  PixelVotes votes_;
  FieldLayers layers_;
  std::vector<CellFinding> simple_;

  static constexpr float kLearningRate = 0.6F;
};

} // namespace haptic
