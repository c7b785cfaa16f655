// SPDX-License-Identifier: LGPL-2.1-or-later
#include "layers/layer-kernels.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

// Maps are small: an int holds any offset in them.
// NOLINTBEGIN(bugprone-implicit-widening-of-multiplication-result)

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "layers/layer-kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {

using PixelRow = float[kLayerSide];

// Row y of the map, or the nearest.
template <typename Map>
HWY_INLINE const float *near_row(const Map &map, int y, int rows) {
  return map.row(std::min(std::max(y, 0), rows - 1));
}

template <int kRadius, typename Map>
HWY_INLINE void blur_map(const float *kernel, int width, int height, Map &map) {
  constexpr int kPad = 8;
  Map across;
  for (int y = 0; y < height; ++y) {
    alignas(64) float padded[Map::kStride + 2 * kPad];
    const float *HWY_RESTRICT from = map.row(y);
    for (int i = 0; i < kPad; ++i) {
      padded[i] = from[0];
      padded[kPad + width + i] = from[width - 1];
    }
    std::memcpy(padded + kPad, from, sizeof(float) * static_cast<std::size_t>(width));
    float *HWY_RESTRICT to = across.row(y);
    for (int x = 0; x < width; ++x) {
      float sum = kernel[0] * padded[kPad + x];
      for (int i = 1; i <= kRadius; ++i)
        sum += kernel[i] * (padded[kPad + x - i] + padded[kPad + x + i]);
      to[x] = sum;
    }
  }
  for (int y = 0; y < height; ++y) {
    const float *rows[2 * kRadius + 1];
    for (int i = 0; i <= 2 * kRadius; ++i)
      rows[i] = near_row(across, y + i - kRadius, height);
    float *HWY_RESTRICT to = map.row(y);
    for (int x = 0; x < width; ++x) {
      float sum = kernel[0] * rows[kRadius][x];
      for (int i = 1; i <= kRadius; ++i)
        sum += kernel[i] * (rows[kRadius - i][x] + rows[kRadius + i][x]);
      to[x] = sum;
    }
  }
}

template <typename Map>
HWY_INLINE void blur_any(std::span<const float> kernel, int width, int height, Map &map) {
  switch (kernel.size()) {
  case 2:
    return blur_map<1>(kernel.data(), width, height, map);
  case 4:
    return blur_map<3>(kernel.data(), width, height, map);
  case 5:
    return blur_map<4>(kernel.data(), width, height, map);
  default:
    return blur_map<5>(kernel.data(), width, height, map);
  }
}

void BlurPixels(std::span<const float> kernel, const LayerSize &size, PixelMap &map) {
  blur_any(kernel, size.width, size.height, map);
}

void BlurCells(std::span<const float> kernel, const LayerSize &size, CellMap &map) {
  blur_any(kernel, size.columns(), size.rows(), map);
}

void LoadLuma(const LumaView &view, const LayerSize &size, PixelMap &luma) {
  for (int y = 0; y < size.height; ++y) {
    const std::uint8_t *HWY_RESTRICT from =
        view.pixels + std::min(y, view.height - 1) * view.stride;
    float *HWY_RESTRICT to = luma.row(y);
    for (int x = 0; x < view.width; ++x)
      to[x] = from[x];
    for (int x = view.width; x < size.width; ++x)
      to[x] = from[view.width - 1];
  }
}

// A row of cells: the means of the sums of four rows of pixels.
HWY_INLINE void mean_of_columns(const float *HWY_RESTRICT sums, int columns,
                                float *HWY_RESTRICT cells) {
  constexpr float kPart = 1.0F / (kCellSide * kCellSide);
  for (int i = 0; i < columns; ++i)
    cells[i] = kPart * (sums[4 * i] + sums[4 * i + 1] + sums[4 * i + 2] + sums[4 * i + 3]);
}

void Pool(const PixelMap &map, const LayerSize &size, CellMap &cells) {
  for (int row = 0; row < size.rows(); ++row) {
    alignas(64) PixelRow sums;
    const float *HWY_RESTRICT a = map.row(4 * row);
    const float *HWY_RESTRICT b = map.row(4 * row + 1);
    const float *HWY_RESTRICT c = map.row(4 * row + 2);
    const float *HWY_RESTRICT d = map.row(4 * row + 3);
    for (int x = 0; x < size.width; ++x)
      sums[x] = (a[x] + b[x]) + (c[x] + d[x]);
    mean_of_columns(sums, size.columns(), cells.row(row));
  }
}

void Widen(const CellMap &cells, const LayerSize &size, PixelMap &map) {
  // Of the way from the middle of a cell to the next, at the middles of the pixels.
  constexpr float kPart[kCellSide] = {0.625F, 0.875F, 0.125F, 0.375F};
  const int columns = size.columns();
  const int rows = size.rows();
  alignas(64) float across[CellMap::kStride][kLayerSide];
  for (int row = 0; row < rows; ++row) {
    const float *HWY_RESTRICT from = cells.row(row);
    float *HWY_RESTRICT to = across[row];
    for (int i = 0; i < columns; ++i) {
      const float left = from[std::max(i - 1, 0)];
      const float here = from[i];
      const float right = from[std::min(i + 1, columns - 1)];
      to[4 * i] = left + kPart[0] * (here - left);
      to[4 * i + 1] = left + kPart[1] * (here - left);
      to[4 * i + 2] = here + kPart[2] * (right - here);
      to[4 * i + 3] = here + kPart[3] * (right - here);
    }
  }
  for (int y = 0; y < size.height; ++y) {
    const int row = y / kCellSide;
    const int rest = y % kCellSide;
    const float *HWY_RESTRICT above = across[rest < 2 ? std::max(row - 1, 0) : row];
    const float *HWY_RESTRICT below = across[rest < 2 ? row : std::min(row + 1, rows - 1)];
    float *HWY_RESTRICT to = map.row(y);
    for (int x = 0; x < size.width; ++x)
      to[x] = above[x] + kPart[rest] * (below[x] - above[x]);
  }
}

void FindSlope(const PixelMap &slow, const LayerSize &size, LayerFrame &frame) {
  alignas(64) PixelRow squares = {};
  for (int y = 0; y < size.height; ++y) {
    const float *HWY_RESTRICT smooth = frame.smooth.row(y);
    const float *HWY_RESTRICT low = slow.row(y);
    float *HWY_RESTRICT to = frame.detail.row(y);
    for (int x = 0; x < size.width; ++x)
      to[x] = smooth[x] - low[x];
    for (int x = 0; x < size.width; ++x)
      squares[x] += to[x] * to[x];
  }
  frame.energy = 0;
  for (int x = 0; x < size.width; ++x)
    frame.energy += squares[x];
  frame.energy /= static_cast<float>(size.width * size.height);
  constexpr float kPart = 1.0F / 12;
  const int width = size.width;
  for (int y = 0; y < size.height; ++y) {
    const float *up2 = near_row(frame.detail, y - 2, size.height);
    const float *up = near_row(frame.detail, y - 1, size.height);
    const float *here = frame.detail.row(y);
    const float *down = near_row(frame.detail, y + 1, size.height);
    const float *down2 = near_row(frame.detail, y + 2, size.height);
    float *HWY_RESTRICT gx = frame.slope.x.row(y);
    float *HWY_RESTRICT gy = frame.slope.y.row(y);
    for (int x = 0; x < width; ++x)
      gy[x] = kPart * (8 * (down[x] - up[x]) - (down2[x] - up2[x]));
    for (int x = 2; x < width - 2; ++x)
      gx[x] = kPart * (8 * (here[x + 1] - here[x - 1]) - (here[x + 2] - here[x - 2]));
    gx[0] = gx[1] = gx[2];
    gx[width - 1] = gx[width - 2] = gx[width - 3];
  }
}

void FindFlatCells(float limit, const LayerSize &size, LayerFrame &frame) {
  const int width = size.width;
  for (int y = 0; y < size.height; ++y) {
    const float *up = near_row(frame.smooth, y - 1, size.height);
    const float *here = frame.smooth.row(y);
    const float *down = near_row(frame.smooth, y + 1, size.height);
    float *HWY_RESTRICT to = frame.steepness.row(y);
    for (int x = 1; x < width - 1; ++x) {
      const float gx = 0.5F * (here[x + 1] - here[x - 1]);
      const float gy = 0.5F * (down[x] - up[x]);
      to[x] = gx * gx + gy * gy;
    }
    to[0] = to[1];
    to[width - 1] = to[width - 2];
  }
  PixelMap blurred = frame.steepness;
  blur_map<1>(kBinomial.data(), width, size.height, blurred);
  for (int row = 0; row < size.rows(); ++row) {
    alignas(64) PixelRow most;
    const float *HWY_RESTRICT a = blurred.row(4 * row);
    const float *HWY_RESTRICT b = blurred.row(4 * row + 1);
    const float *HWY_RESTRICT c = blurred.row(4 * row + 2);
    const float *HWY_RESTRICT d = blurred.row(4 * row + 3);
    for (int x = 0; x < width; ++x)
      most[x] = std::max(std::max(a[x], b[x]), std::max(c[x], d[x]));
    for (int i = 0; i < size.columns(); ++i) {
      const float *cell = most + 4 * i;
      frame.flat.at(i, row) =
          std::max(std::max(cell[0], cell[1]), std::max(cell[2], cell[3])) < limit ? 1.0F : 0.0F;
    }
  }
}

// The squares of four rows, summed over each cell.
class CellSums {
public:
  explicit CellSums(int width) : width_(width) { clear(); }
  void clear() { std::memset(sums_, 0, sizeof sums_); }
  HWY_INLINE float *row() { return sums_; }
  void store(int columns, float *cells) {
    mean_of_columns(sums_, columns, cells);
    clear();
  }
  int width() const { return width_; }

private:
  alignas(64) PixelRow sums_;
  int width_;
};

// Energies of the differences between the rows that `row_of(y)` gives and those of a map.
template <class RowOf>
HWY_INLINE void sum_squares(const PixelMap &map, const LayerSize &size, CellMap &energy,
                            RowOf row_of) {
  CellSums sums(size.width);
  for (int y = 0; y < size.height; ++y) {
    const float *HWY_RESTRICT a = row_of(y);
    const float *HWY_RESTRICT b = map.row(y);
    float *HWY_RESTRICT to = sums.row();
    for (int x = 0; x < size.width; ++x) {
      const float difference = a[x] - b[x];
      to[x] += difference * difference;
    }
    if (y % kCellSide == kCellSide - 1)
      sums.store(size.columns(), energy.row(y / kCellSide));
  }
}

void Compare(const PixelMap &one, const PixelMap &other, const LayerSize &size, CellMap &energy) {
  sum_squares(other, size, energy, [&](int y) HWY_ATTR { return one.row(y); });
}

// Reads rows of a map that is displaced by a constant.
class DisplacedRows {
public:
  DisplacedRows(const PixelMap &map, Displacement by, const LayerSize &size)
      : map_(map), size_(size), left_(static_cast<int>(std::floor(-by.x))),
        up_(static_cast<int>(std::floor(-by.y))), part_x_(-by.x - static_cast<float>(left_)),
        part_y_(-by.y - static_cast<float>(up_)) {}

  HWY_INLINE void read(int y, float *HWY_RESTRICT to) {
    const int width = size_.width;
    const float *above = near_row(map_, y + up_, size_.height);
    const float *below = near_row(map_, y + up_ + 1, size_.height);
    float *HWY_RESTRICT row = padded_ + kLayerSide;
    for (int x = 0; x < width; ++x)
      row[x] = above[x] + part_y_ * (below[x] - above[x]);
    const int shift = std::min(std::max(left_, -kLayerSide), kLayerSide);
    for (int x = shift; x < 0; ++x)
      row[x] = row[0];
    for (int x = width; x <= width + shift; ++x)
      row[x] = row[width - 1];
    const float *from = row + shift;
    for (int x = 0; x < width; ++x)
      to[x] = from[x] + part_x_ * (from[x + 1] - from[x]);
  }

private:
  const PixelMap &map_;
  const LayerSize size_;
  int left_;
  int up_;
  float part_x_;
  float part_y_;
  alignas(64) float padded_[3 * kLayerSide + 8];
};

void CompareDisplaced(const PixelMap &earlier, const PixelMap &later, Displacement by,
                      const LayerSize &size, CellMap &energy) {
  DisplacedRows rows(earlier, by, size);
  alignas(64) PixelRow row;
  sum_squares(later, size, energy, [&](int y) HWY_ATTR {
    rows.read(y, row);
    return static_cast<const float *>(row);
  });
}

void CompareDetails(const LayerFrame &earlier, const LayerFrame &later, Displacement by,
                    const LayerSize &size, CellMap &energy, VectorMap<CellMap> &moment) {
  DisplacedRows rows(earlier.detail, by, size);
  CellSums squares(size.width), sums_x(size.width), sums_y(size.width);
  for (int y = 0; y < size.height; ++y) {
    alignas(64) PixelRow a;
    rows.read(y, a);
    const float *HWY_RESTRICT b = later.detail.row(y);
    const float *HWY_RESTRICT gx = later.slope.x.row(y);
    const float *HWY_RESTRICT gy = later.slope.y.row(y);
    float *HWY_RESTRICT e2 = squares.row();
    float *HWY_RESTRICT ex = sums_x.row();
    float *HWY_RESTRICT ey = sums_y.row();
    for (int x = 0; x < size.width; ++x) {
      const float difference = a[x] - b[x];
      e2[x] += difference * difference;
      ex[x] += gx[x] * difference;
      ey[x] += gy[x] * difference;
    }
    if (y % kCellSide == kCellSide - 1) {
      const int row = y / kCellSide;
      squares.store(size.columns(), energy.row(row));
      sums_x.store(size.columns(), moment.x.row(row));
      sums_y.store(size.columns(), moment.y.row(row));
    }
  }
}

void SumBackground(const LayerFrame &earlier, const LayerFrame &later,
                   const PixelMap &background_luma, Displacement by, const BackgroundLimits &limits,
                   const LayerSize &size, TensorMap<CellMap> &structure,
                   VectorMap<CellMap> &moment) {
  CellSums xx(size.width), xy(size.width), yy(size.width), bx(size.width), by_(size.width);
  for (int y = 0; y < size.height; ++y) {
    const float *a = earlier.smooth.row(y);
    const float *b = later.smooth.row(y);
    const float *a_up = near_row(earlier.smooth, y - 1, size.height);
    const float *b_up = near_row(later.smooth, y - 1, size.height);
    const float *a_down = near_row(earlier.smooth, y + 1, size.height);
    const float *b_down = near_row(later.smooth, y + 1, size.height);
    const float *HWY_RESTRICT luma = background_luma.row(y);
    float *HWY_RESTRICT to_xx = xx.row();
    float *HWY_RESTRICT to_xy = xy.row();
    float *HWY_RESTRICT to_yy = yy.row();
    float *HWY_RESTRICT to_x = bx.row();
    float *HWY_RESTRICT to_y = by_.row();
    // The outermost rows have no gradient across.
    const bool is_inside = y > 0 && y < size.height - 1;
    for (int x = 1; is_inside && x < size.width - 1; ++x) {
      const float gx = 0.25F * ((a[x + 1] - a[x - 1]) + (b[x + 1] - b[x - 1]));
      const float gy = 0.25F * ((a_down[x] - a_up[x]) + (b_down[x] - b_up[x]));
      const float change = a[x] - b[x];
      const float left = std::min(std::abs(change), std::abs(change - gx * by.x - gy * by.y));
      const float away = std::abs(b[x] - luma[x]);
      const float counts = (gx * gx + gy * gy <= limits.steepness) & (left <= limits.change) &
                                   (away <= limits.change)
                               ? 1.0F
                               : 0.0F;
      to_xx[x] += counts * gx * gx;
      to_xy[x] += counts * gx * gy;
      to_yy[x] += counts * gy * gy;
      to_x[x] += counts * gx * change;
      to_y[x] += counts * gy * change;
    }
    if (y % kCellSide == kCellSide - 1) {
      const int row = y / kCellSide;
      const int columns = size.columns();
      xx.store(columns, structure.xx.row(row));
      xy.store(columns, structure.xy.row(row));
      yy.store(columns, structure.yy.row(row));
      bx.store(columns, moment.x.row(row));
      by_.store(columns, moment.y.row(row));
    }
  }
}

void ShareBackground(const PixelMap &luma, const PixelMap &background_luma, const PixelMap &known,
                     float least_known, float least, const LayerSize &size, PixelMap &share) {
  // Of the largest difference within 2 px: the border between two grey levels lies at the middle.
  constexpr float kOfLargest = 0.55F;
  const int width = size.width;
  PixelMap away;
  PixelMap across;
  for (int y = 0; y < size.height; ++y) {
    const float *HWY_RESTRICT a = luma.row(y);
    const float *HWY_RESTRICT b = background_luma.row(y);
    float *HWY_RESTRICT difference = away.row(y);
    for (int x = 0; x < width; ++x)
      difference[x] = std::abs(a[x] - b[x]);
    float *HWY_RESTRICT to = across.row(y);
    for (int x = 2; x < width - 2; ++x)
      to[x] = std::max(std::max(std::max(difference[x - 2], difference[x - 1]),
                                std::max(difference[x], difference[x + 1])),
                       difference[x + 2]);
    to[0] = to[1] = to[2];
    to[width - 1] = to[width - 2] = to[width - 3];
  }
  for (int y = 0; y < size.height; ++y) {
    const float *rows[5];
    for (int i = 0; i < 5; ++i)
      rows[i] = near_row(across, y + i - 2, size.height);
    const float *HWY_RESTRICT difference = away.row(y);
    const float *HWY_RESTRICT is_known = known.row(y);
    float *HWY_RESTRICT to = share.row(y);
    for (int x = 0; x < width; ++x) {
      const float largest = std::max(
          std::max(std::max(rows[0][x], rows[1][x]), std::max(rows[2][x], rows[3][x])), rows[4][x]);
      const float border = std::max(least, kOfLargest * largest);
      const float part = (1.25F * border - difference[x]) / (0.5F * border);
      const float clamped = std::min(std::max(part, 0.0F), 1.0F);
      to[x] = is_known[x] > least_known ? clamped : 0.0F;
    }
  }
}

void MultiplySlope(const LayerFrame &frame, const LayerSize &size, TensorMap<PixelMap> &structure) {
  for (int y = 0; y < size.height; ++y) {
    const float *HWY_RESTRICT gx = frame.slope.x.row(y);
    const float *HWY_RESTRICT gy = frame.slope.y.row(y);
    float *HWY_RESTRICT xx = structure.xx.row(y);
    float *HWY_RESTRICT xy = structure.xy.row(y);
    float *HWY_RESTRICT yy = structure.yy.row(y);
    for (int x = 0; x < size.width; ++x) {
      xx[x] = gx[x] * gx[x];
      xy[x] = gx[x] * gy[x];
      yy[x] = gy[x] * gy[x];
    }
  }
}

void Damp(const TensorMap<PixelMap> &structure, Displacement prior, Displacement more,
          float damping, const LayerSize &size, VectorMap<PixelMap> &flow) {
  for (int y = 0; y < size.height; ++y) {
    const float *HWY_RESTRICT xx = structure.xx.row(y);
    const float *HWY_RESTRICT yy = structure.yy.row(y);
    float *HWY_RESTRICT ux = flow.x.row(y);
    float *HWY_RESTRICT uy = flow.y.row(y);
    for (int x = 0; x < size.width; ++x) {
      const float trace = xx[x] + yy[x];
      const float kept = trace / (trace + damping);
      ux[x] = prior.x + (ux[x] + more.x - prior.x) * kept;
      uy[x] = prior.y + (uy[x] + more.y - prior.y) * kept;
    }
  }
}

void Linearise(const LayerFrame &earlier, const LayerFrame &later, const VectorMap<PixelMap> &flow,
               const LayerSize &size, PixelMap &term, VectorMap<PixelMap> &moment,
               CellMap &energy) {
  // Less than a whole pixel from the last one, so that its neighbour exists.
  const float most_x = static_cast<float>(size.width) - 1.001F;
  const float most_y = static_cast<float>(size.height) - 1.001F;
  const float *HWY_RESTRICT from = earlier.detail.row(0);
  CellSums squares(size.width);
  for (int y = 0; y < size.height; ++y) {
    const float *HWY_RESTRICT ux = flow.x.row(y);
    const float *HWY_RESTRICT uy = flow.y.row(y);
    const float *HWY_RESTRICT here = later.detail.row(y);
    const float *HWY_RESTRICT gx = later.slope.x.row(y);
    const float *HWY_RESTRICT gy = later.slope.y.row(y);
    float *HWY_RESTRICT to = term.row(y);
    float *HWY_RESTRICT bx = moment.x.row(y);
    float *HWY_RESTRICT by = moment.y.row(y);
    float *HWY_RESTRICT e2 = squares.row();
    const auto fy = static_cast<float>(y);
    // In three passes, of which the one that gathers is short: compilers vectorise each.
    alignas(64) int at[kLayerSide];
    alignas(64) PixelRow part_x, part_y, above, above_next, below, below_next;
    for (int x = 0; x < size.width; ++x) {
      const float at_x = std::min(std::max(static_cast<float>(x) - ux[x], 0.0F), most_x);
      const float at_y = std::min(std::max(fy - uy[x], 0.0F), most_y);
      const int left = static_cast<int>(at_x);
      const int top = static_cast<int>(at_y);
      part_x[x] = at_x - static_cast<float>(left);
      part_y[x] = at_y - static_cast<float>(top);
      at[x] = top * PixelMap::kStride + left;
    }
    for (int x = 0; x < size.width; ++x) {
      const float *HWY_RESTRICT pixel = from + at[x];
      above[x] = pixel[0];
      above_next[x] = pixel[1];
      below[x] = pixel[PixelMap::kStride];
      below_next[x] = pixel[PixelMap::kStride + 1];
    }
    for (int x = 0; x < size.width; ++x) {
      const float upper = above[x] + part_x[x] * (above_next[x] - above[x]);
      const float lower = below[x] + part_x[x] * (below_next[x] - below[x]);
      const float difference = upper + part_y[x] * (lower - upper) - here[x];
      const float sum = difference + gx[x] * ux[x] + gy[x] * uy[x];
      e2[x] += difference * difference;
      to[x] = sum;
      bx[x] = gx[x] * sum;
      by[x] = gy[x] * sum;
    }
    if (y % kCellSide == kCellSide - 1)
      squares.store(size.columns(), energy.row(y / kCellSide));
  }
}

float SolveFlow(const TensorMap<PixelMap> &structure, const VectorMap<PixelMap> &moment,
                Displacement prior, float ridge, const LayerSize &size, VectorMap<PixelMap> &flow) {
  constexpr float kTexture = 30; // trace of the structure that counts by half
  alignas(64) PixelRow moved = {};
  alignas(64) PixelRow weights = {};
  for (int y = 0; y < size.height; ++y) {
    const float *HWY_RESTRICT xx = structure.xx.row(y);
    const float *HWY_RESTRICT xy = structure.xy.row(y);
    const float *HWY_RESTRICT yy = structure.yy.row(y);
    const float *HWY_RESTRICT bx = moment.x.row(y);
    const float *HWY_RESTRICT by = moment.y.row(y);
    float *HWY_RESTRICT ux = flow.x.row(y);
    float *HWY_RESTRICT uy = flow.y.row(y);
    for (int x = 0; x < size.width; ++x) {
      const float trace = xx[x] + yy[x];
      const float a = xx[x] + ridge;
      const float c = yy[x] + ridge;
      const float inverse = 1 / (a * c - xy[x] * xy[x]);
      const float right_x = bx[x] + ridge * prior.x;
      const float right_y = by[x] + ridge * prior.y;
      const float new_x = (c * right_x - xy[x] * right_y) * inverse;
      const float new_y = (a * right_y - xy[x] * right_x) * inverse;
      const float weight = trace / (trace + kTexture);
      weights[x] += weight;
      moved[x] += weight * (std::abs(new_x - ux[x]) + std::abs(new_y - uy[x]));
      ux[x] = new_x;
      uy[x] = new_y;
    }
  }
  float sum = 0;
  float all = 1;
  for (int x = 0; x < size.width; ++x) {
    sum += moved[x];
    all += weights[x];
  }
  return sum / all;
}

void Leftover(const PixelMap &term, const LayerFrame &later, const VectorMap<PixelMap> &flow,
              const LayerSize &size, CellMap &energy) {
  CellSums squares(size.width);
  for (int y = 0; y < size.height; ++y) {
    const float *HWY_RESTRICT sum = term.row(y);
    const float *HWY_RESTRICT gx = later.slope.x.row(y);
    const float *HWY_RESTRICT gy = later.slope.y.row(y);
    const float *HWY_RESTRICT ux = flow.x.row(y);
    const float *HWY_RESTRICT uy = flow.y.row(y);
    float *HWY_RESTRICT e2 = squares.row();
    for (int x = 0; x < size.width; ++x) {
      const float rest = sum[x] - gx[x] * ux[x] - gy[x] * uy[x];
      e2[x] += rest * rest;
    }
    if (y % kCellSide == kCellSide - 1)
      squares.store(size.columns(), energy.row(y / kCellSide));
  }
}

enum TileQuantity { kMotionX, kMotionY, kXx, kXy, kYy, kShare, kLeftover, kQuantities };
using TileRows = float[kQuantities][kLayerSide];

HWY_INLINE void read_row(const LayerSum &layers, int y, int left, int width,
                         TileRows &HWY_RESTRICT rows) {
  const float *HWY_RESTRICT gx = layers.frame.slope.x.row(y) + left;
  const float *HWY_RESTRICT gy = layers.frame.slope.y.row(y) + left;
  const float *HWY_RESTRICT ux = layers.flow.x.row(y) + left;
  const float *HWY_RESTRICT uy = layers.flow.y.row(y) + left;
  const float *HWY_RESTRICT vx = layers.background.x.row(y) + left;
  const float *HWY_RESTRICT vy = layers.background.y.row(y) + left;
  const float *HWY_RESTRICT share = layers.share.row(y) + left;
  const float *HWY_RESTRICT term = layers.term.row(y) + left;
  for (int x = 0; x < width; ++x) {
    const float moving = 1 - share[x];
    const float rest = term[x] - gx[x] * ux[x] - gy[x] * uy[x];
    rows[kMotionX][x] = ux[x] + share[x] * (vx[x] - ux[x]);
    rows[kMotionY][x] = uy[x] + share[x] * (vy[x] - uy[x]);
    rows[kXx][x] = moving * gx[x] * gx[x];
    rows[kXy][x] = moving * gx[x] * gy[x];
    rows[kYy][x] = moving * gy[x] * gy[x];
    rows[kShare][x] = share[x];
    rows[kLeftover][x] = moving * rest * rest;
  }
}

// The part of pixel i that lies in [begin, end).
HWY_INLINE float part_in(int i, float begin, float end) {
  const auto first = static_cast<float>(i);
  return std::max(0.0F, std::min(first + 1, end) - std::max(first, begin));
}

void SumTiles(const LayerSum &layers, const Rectangle &region, int columns, int rows,
              std::span<TileSums> tiles) {
  const float wide = static_cast<float>(region.width) / static_cast<float>(columns);
  const float high = static_cast<float>(region.height) / static_cast<float>(rows);
  for (int row = 0; row < rows; ++row) {
    const float top = high * static_cast<float>(row);
    const float bottom = top + high;
    alignas(64) TileRows sums = {};
    const int last = std::min(static_cast<int>(std::ceil(bottom)), region.height);
    for (int y = static_cast<int>(top); y < last; ++y) {
      alignas(64) TileRows values;
      read_row(layers, region.y + y, region.x, region.width, values);
      const float part = part_in(y, top, bottom);
      for (int quantity = 0; quantity < kQuantities; ++quantity)
        for (int x = 0; x < region.width; ++x)
          sums[quantity][x] += part * values[quantity][x];
    }
    for (int column = 0; column < columns; ++column) {
      const float left = wide * static_cast<float>(column);
      const float right = left + wide;
      float of[kQuantities] = {};
      const int end = std::min(static_cast<int>(std::ceil(right)), region.width);
      for (int x = static_cast<int>(left); x < end; ++x) {
        const float part = part_in(x, left, right);
        for (int quantity = 0; quantity < kQuantities; ++quantity)
          of[quantity] += part * sums[quantity][x];
      }
      tiles[tile_at(row, columns, column)] = {wide * high,
                                              {of[kMotionX], of[kMotionY]},
                                              {of[kXx], of[kXy], of[kYy]},
                                              of[kShare],
                                              of[kLeftover]};
    }
  }
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {
namespace {
HWY_EXPORT(LoadLuma);
HWY_EXPORT(BlurPixels);
HWY_EXPORT(BlurCells);
HWY_EXPORT(Pool);
HWY_EXPORT(Widen);
HWY_EXPORT(FindSlope);
HWY_EXPORT(FindFlatCells);
HWY_EXPORT(Compare);
HWY_EXPORT(CompareDisplaced);
HWY_EXPORT(CompareDetails);
HWY_EXPORT(SumBackground);
HWY_EXPORT(ShareBackground);
HWY_EXPORT(MultiplySlope);
HWY_EXPORT(Damp);
HWY_EXPORT(Linearise);
HWY_EXPORT(SolveFlow);
HWY_EXPORT(Leftover);
HWY_EXPORT(SumTiles);
} // namespace

void load_luma(const LumaView &view, const LayerSize &size, PixelMap &luma) {
  HWY_DYNAMIC_DISPATCH(LoadLuma)(view, size, luma);
}

void blur(std::span<const float> half_kernel, const LayerSize &size, PixelMap &map) {
  HWY_DYNAMIC_DISPATCH(BlurPixels)(half_kernel, size, map);
}

void blur(std::span<const float> half_kernel, const LayerSize &size, CellMap &map) {
  HWY_DYNAMIC_DISPATCH(BlurCells)(half_kernel, size, map);
}

void pool(const PixelMap &map, const LayerSize &size, CellMap &cells) {
  HWY_DYNAMIC_DISPATCH(Pool)(map, size, cells);
}

void widen(const CellMap &cells, const LayerSize &size, PixelMap &map) {
  HWY_DYNAMIC_DISPATCH(Widen)(cells, size, map);
}

void find_slope(const PixelMap &slow, const LayerSize &size, LayerFrame &frame) {
  HWY_DYNAMIC_DISPATCH(FindSlope)(slow, size, frame);
}

void find_flat_cells(float limit, const LayerSize &size, LayerFrame &frame) {
  HWY_DYNAMIC_DISPATCH(FindFlatCells)(limit, size, frame);
}

void compare(const PixelMap &one, const PixelMap &other, const LayerSize &size, CellMap &energy) {
  HWY_DYNAMIC_DISPATCH(Compare)(one, other, size, energy);
}

void compare_displaced(const PixelMap &earlier, const PixelMap &later, Displacement by,
                       const LayerSize &size, CellMap &energy) {
  HWY_DYNAMIC_DISPATCH(CompareDisplaced)(earlier, later, by, size, energy);
}

void compare_details(const LayerFrame &earlier, const LayerFrame &later, Displacement by,
                     const LayerSize &size, CellMap &energy, VectorMap<CellMap> &moment) {
  HWY_DYNAMIC_DISPATCH(CompareDetails)(earlier, later, by, size, energy, moment);
}

void sum_background(const LayerFrame &earlier, const LayerFrame &later,
                    const PixelMap &background_luma, Displacement by,
                    const BackgroundLimits &limits, const LayerSize &size,
                    TensorMap<CellMap> &structure, VectorMap<CellMap> &moment) {
  HWY_DYNAMIC_DISPATCH(SumBackground)
  (earlier, later, background_luma, by, limits, size, structure, moment);
}

void share_background(const PixelMap &luma, const PixelMap &background_luma, const PixelMap &known,
                      float least_known, float least, const LayerSize &size, PixelMap &share) {
  HWY_DYNAMIC_DISPATCH(ShareBackground)
  (luma, background_luma, known, least_known, least, size, share);
}

void multiply_slope(const LayerFrame &frame, const LayerSize &size,
                    TensorMap<PixelMap> &structure) {
  HWY_DYNAMIC_DISPATCH(MultiplySlope)(frame, size, structure);
}

void damp(const TensorMap<PixelMap> &structure, Displacement prior, Displacement more,
          float damping, const LayerSize &size, VectorMap<PixelMap> &flow) {
  HWY_DYNAMIC_DISPATCH(Damp)(structure, prior, more, damping, size, flow);
}

void linearise(const LayerFrame &earlier, const LayerFrame &later, const VectorMap<PixelMap> &flow,
               const LayerSize &size, PixelMap &term, VectorMap<PixelMap> &moment,
               CellMap &energy) {
  HWY_DYNAMIC_DISPATCH(Linearise)(earlier, later, flow, size, term, moment, energy);
}

float solve_flow(const TensorMap<PixelMap> &structure, const VectorMap<PixelMap> &moment,
                 Displacement prior, float ridge, const LayerSize &size,
                 VectorMap<PixelMap> &flow) {
  return HWY_DYNAMIC_DISPATCH(SolveFlow)(structure, moment, prior, ridge, size, flow);
}

void leftover(const PixelMap &term, const LayerFrame &later, const VectorMap<PixelMap> &flow,
              const LayerSize &size, CellMap &energy) {
  HWY_DYNAMIC_DISPATCH(Leftover)(term, later, flow, size, energy);
}

void sum_tiles(const LayerSum &layers, const Rectangle &region, int columns, int rows,
               std::span<TileSums> tiles) {
  HWY_DYNAMIC_DISPATCH(SumTiles)(layers, region, columns, rows, tiles);
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
