// SPDX-License-Identifier: LGPL-2.1-or-later
// The motion of a whole frame on a grid of cells, from one reading of its luma.
#pragma once

#include "block-translation.hpp"
#include "frame-change.hpp"
#include "motion-field.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace haptic {

/// Cells of equal size, side by side over the whole frame.
struct FieldShape {
  int columns = 0;
  int rows = 0;

  int cells() const { return columns * rows; }
  bool operator==(const FieldShape &) const = default;
};

/// As many columns as wanted, but none narrower than 8 px, and rows such that the cells are as
/// square on the screen as they can be; no more than kMostFieldCells cells. `pixel_aspect`: width
/// of a pixel over its height.
FieldShape field_shape(int width, int height, double pixel_aspect, int columns);

/// Coarse to fine over the whole frame, then for each cell the ladder of the fast tracker:
/// unchanged, one translation, a grid of patches. Keeps of a frame no more than it needs to
/// compare the next one with it. One instance serves one stream, from one thread at a time.
class FieldTracker {
public:
  /// What the frames that follow are like. Forgets.
  void set_frame(int width, int height, const FieldShape &shape);

  /// Rows that read() takes at a time; at the bottom of the frame there may be fewer.
  int strip_rows() const;

  /// The rows of the frame that comes next, strip by strip from its top.
  void read(const LumaView &strip);

  /// The frame read last becomes the earlier one.
  void keep();

  /// There is no earlier frame, and nothing is known of the scene.
  void forget();

  /// Whether the frame read last is the earlier one once more.
  bool repeats() const;

  /// From the earlier frame to the one read last, `interval` seconds later. Fills all cells of
  /// the shape and returns kStill, kCut or 0.
  std::uint32_t measure(double interval, std::span<FieldCell> cells);

private:
  // Of a cell, px of the reduced frame.
  Area area_of(int row, int column) const;
  LumaView part_of(const ByteImage &frame, const Area &area) const;
  bool find_changes(std::span<FieldCell> cells);
  void build_pyramids();
  void follow_coarsely();
  void follow_cells();
  void find_starts(int row, int column);
  Translation translate(int row, int column);
  bool is_cut() const;
  void climb(int row, int column, double interval, FieldCell &cell);
  void add_grid(int row, int column, const Area &area);
  void learn_noise();
  float noise_floor() const;

  // Displacements that a patch may start from, no two of them nearly alike.
  class Starts {
  public:
    void clear() { count_ = 0; }
    void offer(Displacement start);
    std::span<const Displacement> view() const { return {starts_.data(), count_}; }

  private:
    std::array<Displacement, 12> starts_;
    std::size_t count_ = 0;
  };

  // What is known of a cell, displacements in px of the level named.
  struct Cell {
    Change change = Change::none;
    float energy = 0;    // of the change
    Displacement last;   // of the frame before, finest level
    Displacement coarse; // level 1
    Translation whole;   // finest level
    bool explained = false;
    bool has_texture = false;
  };

  int width_ = 0;  // px, of the frame
  int height_ = 0; // px
  FieldShape shape_;
  int reductions_ = 0; // times that the frame was halved
  int rows_read_ = 0;  // of the reduced frame
  bool have_previous_ = false;
  bool previous_is_built_ = false;
  bool current_is_built_ = false;
  float noise_ = 0;        // variance of a pixel of the reduced frame
  std::size_t levels_ = 0; // that are large enough to be of use; 0: the frame is too small
  std::array<ByteImage, 2> strips_;
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
  Starts starts_;
  Measurement measurement_;
};

} // namespace haptic
