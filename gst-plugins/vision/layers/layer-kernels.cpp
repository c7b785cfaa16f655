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
namespace hn = hwy::HWY_NAMESPACE;

// Rows are read and written in whole vectors, beyond their end, too: a row of a map has room.
using Tag = hn::CappedTag<float, kVectorFloats>;
using Vec = hn::Vec<Tag>;
constexpr Tag kTag;

HWY_INLINE int lanes() {
  return static_cast<int>(hn::Lanes(kTag));
}

HWY_INLINE Vec load(const float *from) {
  return hn::LoadU(kTag, from);
}

HWY_INLINE void store(Vec values, float *to) {
  hn::StoreU(values, kTag, to);
}

HWY_INLINE Vec all(float value) {
  return hn::Set(kTag, value);
}

HWY_INLINE float total(Vec values) {
  return hn::GetLane(hn::SumOfLanes(kTag, values));
}

// Calls body(x) for the vectors of a row.
template <class Body>
HWY_INLINE void for_vectors(int width, Body &&body) {
  for (int x = 0; x < width; x += lanes())
    body(x);
}

constexpr int near_row(int y, int rows) {
  return std::min(std::max(y, 0), rows - 1);
}

// Row y of the map, or the nearest.
template <typename Map>
HWY_INLINE const float *near_row(const Map &map, int y, int rows) {
  return map.row(near_row(y, rows));
}

HWY_INLINE void fill(float *to, float value) {
  for (int i = 0; i < kVectorFloats; i += lanes())
    store(all(value), to + i);
}

// Repeats the ends of a row in the room before and behind it.
HWY_INLINE void repeat_ends(float *row, int width) {
  fill(row - kVectorFloats, row[0]);
  const float last = row[width - 1];
  fill(row + width, last);
  fill(row + (width + kVectorFloats - 1) / kVectorFloats * kVectorFloats, last);
}

// The latest rows of a map, of which a filter needs no more.
template <typename Map, int kCount>
class LatestRows {
public:
  HWY_INLINE float *row(int y) { return values_ + (y % kCount) * Map::kStride + Map::kMargin; }
  HWY_INLINE const float *near(int y, int rows) { return row(near_row(y, rows)); }

private:
  alignas(64) float values_[kCount * Map::kStride];
};

template <int kRadius>
HWY_INLINE Vec blur_across(const float *kernel, const float *at) {
  Vec sum = all(kernel[0]) * load(at);
  for (int i = 1; i <= kRadius; ++i)
    sum += all(kernel[i]) * (load(at - i) + load(at + i));
  return sum;
}

// `rows`: 2 * kRadius + 1.
template <int kRadius>
HWY_INLINE Vec blur_down(const float *kernel, const float *const *rows, int x) {
  Vec sum = all(kernel[0]) * load(rows[kRadius] + x);
  for (int i = 1; i <= kRadius; ++i)
    sum += all(kernel[i]) * (load(rows[kRadius - i] + x) + load(rows[kRadius + i] + x));
  return sum;
}

// The sums of each two values that follow one another.
HWY_INLINE Vec sums_of_pairs(const float *values) {
  Vec first, second;
  hn::LoadInterleaved2(kTag, values, first, second);
  return first + second;
}

// Rows of cells with their ends repeated on both sides.
class PaddedCells {
public:
  PaddedCells(const CellMap &cells, const LayerSize &size) {
    for (int y = 0; y < size.rows(); ++y) {
      const float *from = cells.row(y);
      for_vectors(size.columns(), [&](int x) HWY_ATTR { store(load(from + x), row(y) + x); });
      fill(row(y) - kVectorFloats, from[0]);
      fill(row(y) + size.columns(), from[size.columns() - 1]);
    }
  }
  HWY_INLINE float *row(int y) { return values_[y] + kVectorFloats; }
  HWY_INLINE const float *row(int y) const { return values_[y] + kVectorFloats; }

private:
  alignas(64) float values_[kLayerSide / kCellSide][CellMap::kStride + 2 * kVectorFloats];
};

template <int kRadius>
HWY_INLINE void blur_cells(const float *kernel, const LayerSize &size, const CellMap &from,
                           CellMap &to) {
  alignas(64) float blurred[2][CellMap::kStride + 2 * kVectorFloats];
  for (int y = 0; y <= size.rows(); ++y) {
    if (y < size.rows()) {
      const float *rows[2 * kRadius + 1];
      for (int i = 0; i <= 2 * kRadius; ++i)
        rows[i] = near_row(from, y + i - kRadius, size.rows());
      float *row = blurred[y % 2] + kVectorFloats;
      for_vectors(size.columns(),
                  [&](int x) HWY_ATTR { store(blur_down<kRadius>(kernel, rows, x), row + x); });
      fill(row - kVectorFloats, row[0]);
      fill(row + size.columns(), row[size.columns() - 1]);
    }
    if (y > 0) {
      const float *row = blurred[(y - 1) % 2] + kVectorFloats;
      for_vectors(size.columns(), [&](int x) HWY_ATTR {
        store(blur_across<kRadius>(kernel, row + x), to.row(y - 1) + x);
      });
    }
  }
}

void BlurCells(std::span<const float> kernel, const LayerSize &size, const CellMap &from,
               CellMap &to) {
  switch (kernel.size()) {
  case 2:
    return blur_cells<1>(kernel.data(), size, from, to);
  case 4:
    return blur_cells<3>(kernel.data(), size, from, to);
  case 5:
    return blur_cells<4>(kernel.data(), size, from, to);
  default:
    return blur_cells<5>(kernel.data(), size, from, to);
  }
}

// Means over cells of kSide x kSide values of what is added for the vectors of each row.
template <int kSide>
class CellMeans {
public:
  HWY_INLINE void add(int x, Vec values) { store(load(sums_ + x) + values, sums_ + x); }
  // Call it after each row.
  HWY_INLINE void end_row(int y, const LayerSize &size, CellMap &cells) {
    if (y % kSide == kSide - 1)
      end_cells(y / kSide, size, cells);
  }
  // Call it after each row of cells.
  HWY_INLINE void end_cells(int row, const LayerSize &size, CellMap &cells) {
    for_vectors(size.columns(), [&](int x) HWY_ATTR {
      Vec a, b, c, d;
      if constexpr (kSide == 2) {
        hn::LoadInterleaved2(kTag, sums_ + kSide * x, a, b);
        c = d = hn::Zero(kTag);
      } else {
        hn::LoadInterleaved4(kTag, sums_ + kSide * x, a, b, c, d);
      }
      store(all(1.0F / (kSide * kSide)) * ((a + b) + (c + d)), cells.row(row) + x);
    });
    for_vectors(kSide * size.columns(), [&](int x) HWY_ATTR { store(hn::Zero(kTag), sums_ + x); });
  }

private:
  alignas(64) float sums_[kSide * CellMap::kStride] = {};
};
using PixelMeans = CellMeans<kCellSide>;

// Bilinear interpolation between the middles of the cells.
class WideCells {
public:
  WideCells(const CellMap &map, const LayerSize &size) : rows_(size.rows()) {
    PaddedCells cells(map, size);
    for (int y = 0; y < rows_; ++y)
      for_vectors(size.columns(), [&](int x) HWY_ATTR {
        const Vec here = load(cells.row(y) + x);
        const Vec left = load(cells.row(y) + x - 1);
        const Vec right = load(cells.row(y) + x + 1);
        hn::StoreInterleaved4(
            left + all(kPart[0]) * (here - left), left + all(kPart[1]) * (here - left),
            here + all(kPart[2]) * (right - here), here + all(kPart[3]) * (right - here), kTag,
            across_[y] + kCellSide * x);
      });
  }

  struct Row {
    const float *above;
    const float *below;
    float part;
    HWY_INLINE Vec at(int x) const {
      const Vec first = load(above + x);
      return first + all(part) * (load(below + x) - first);
    }
  };
  HWY_INLINE Row row(int y) const {
    const int below = (y + kCellSide / 2) / kCellSide;
    return {across_[near_row(below - 1, rows_)], across_[near_row(below, rows_)],
            kPart[y % kCellSide]};
  }

private:
  // Of the way from the middle of a cell to the next, at the middles of the pixels.
  static constexpr float kPart[kCellSide] = {0.625F, 0.875F, 0.125F, 0.375F};
  int rows_;
  alignas(64) float across_[kLayerSide / kCellSide][kCellSide * CellMap::kStride];
};

void LoadLuma(const LumaView &view, const LayerSize &size, LayerFrame &frame) {
  const hn::Rebind<std::uint8_t, Tag> bytes;
  const hn::Rebind<std::int32_t, Tag> integers;
  PixelMeans means;
  for (int y = 0; y < size.height; ++y) {
    // A vector must not read beyond the last row of a frame.
    std::uint8_t copy[kLayerSide + kVectorFloats];
    std::memcpy(copy, view.pixels + std::min(y, view.height - 1) * view.stride,
                static_cast<std::size_t>(view.width));
    std::memset(copy + view.width, copy[view.width - 1], kVectorFloats);
    float *to = frame.luma.row(y);
    for_vectors(size.width, [&](int x) HWY_ATTR {
      const Vec luma = hn::ConvertTo(kTag, hn::PromoteTo(integers, hn::LoadU(bytes, copy + x)));
      store(luma, to + x);
      means.add(x, luma);
    });
    repeat_ends(to, size.width);
    means.end_row(y, size, frame.mean);
  }
}

// Each filter follows the one before it by the rows that it needs: all of them stay near.
class FrameDescription {
public:
  FrameDescription(const CellMap &slow, const DescriptionKernels &kernels, float flat_limit,
                   const LayerSize &size, LayerFrame &frame)
      : kernels_(kernels), flat_limit_(flat_limit), size_(size), frame_(frame), slow_(slow, size) {}

  void run() {
    constexpr int kSlopeLag = 2;
    constexpr int kFlatLag = kSlopeLag + 2;
    constexpr int kProductLag = kSlopeLag + 2; // of two rows
    constexpr int kAcrossLag = kProductLag + 2;
    constexpr int kDownLag = kAcrossLag + 2 * kWindowRadius;
    const auto has = [&](int y) { return y >= 0 && y < size_.height; };
    const auto has_pair = [&](int y) { return has(y) && y % 2 == 0; };
    for (int y = 0; y < size_.height + kDownLag; ++y) {
      if (has(y))
        smooth(y);
      if (has(y - kSlopeLag))
        find_slope(y - kSlopeLag);
      if (has(y - kFlatLag))
        find_flat(y - kFlatLag);
      if (has_pair(y - kProductLag))
        multiply((y - kProductLag) / 2);
      if (has_pair(y - kAcrossLag))
        window_across((y - kAcrossLag) / 2);
      if (has_pair(y - kDownLag))
        window_down((y - kDownLag) / 2);
    }
    frame_.energy = total(energy_) / static_cast<float>(size_.width * size_.height);
  }

private:
  HWY_INLINE void smooth(int y) {
    const float *up = near_row(frame_.luma, y - 1, size_.height);
    const float *here = frame_.luma.row(y);
    const float *down = near_row(frame_.luma, y + 1, size_.height);
    float *smooth = frame_.smooth.row(y);
    float *detail = frame_.detail.row(y);
    const WideCells::Row slow = slow_.row(y);
    const Vec middle = all(kernels_.smooth[0]);
    const Vec beside = all(kernels_.smooth[1]);
    for_vectors(size_.width, [&](int x) HWY_ATTR {
      const auto column = [&](int i) HWY_ATTR {
        return middle * load(here + i) + beside * (load(up + i) + load(down + i));
      };
      const Vec value = middle * column(x) + beside * (column(x - 1) + column(x + 1));
      const Vec rest = value - slow.at(x);
      store(value, smooth + x);
      store(rest, detail + x);
      energy_ += hn::IfThenElseZero(inside(x), rest * rest);
    });
    repeat_ends(smooth, size_.width);
    repeat_ends(detail, size_.width);
  }

  // Of detail, (1 -8 0 8 -1)/12; and of smooth by central differences, squared.
  HWY_INLINE void find_slope(int y) {
    const float *up2 = near_row(frame_.detail, y - 2, size_.height);
    const float *up = near_row(frame_.detail, y - 1, size_.height);
    const float *here = frame_.detail.row(y);
    const float *down = near_row(frame_.detail, y + 1, size_.height);
    const float *down2 = near_row(frame_.detail, y + 2, size_.height);
    const float *smooth_up = near_row(frame_.smooth, y - 1, size_.height);
    const float *smooth = frame_.smooth.row(y);
    const float *smooth_down = near_row(frame_.smooth, y + 1, size_.height);
    float *gx = frame_.slope.x.row(y);
    float *gy = frame_.slope.y.row(y);
    float *steep = steep_.row(y);
    const Vec near = all(8.0F / 12);
    const Vec far = all(1.0F / 12);
    for_vectors(size_.width, [&](int x) HWY_ATTR {
      store(near * (load(here + x + 1) - load(here + x - 1)) -
                far * (load(here + x + 2) - load(here + x - 2)),
            gx + x);
      store(near * (load(down + x) - load(up + x)) - far * (load(down2 + x) - load(up2 + x)),
            gy + x);
      const Vec rise_x = load(smooth + x + 1) - load(smooth + x - 1);
      const Vec rise_y = load(smooth_down + x) - load(smooth_up + x);
      store(all(0.25F) * (rise_x * rise_x + rise_y * rise_y), steep + x);
    });
    const int last = size_.width - 1;
    gx[0] = gx[1] = gx[2];
    gx[last] = gx[last - 1] = gx[last - 2];
    steep[0] = steep[1];
    steep[last] = steep[last - 1];
    repeat_ends(steep, size_.width);
  }

  HWY_INLINE void multiply(int block) {
    for_vectors(size_.width / 2, [&](int x) HWY_ATTR {
      alignas(64) float sums[3][2 * kVectorFloats];
      for (int i = 0; i < 2 * lanes(); i += lanes()) {
        const Vec gx = load(frame_.slope.x.row(2 * block) + 2 * x + i);
        const Vec gy = load(frame_.slope.y.row(2 * block) + 2 * x + i);
        const Vec next_gx = load(frame_.slope.x.row(2 * block + 1) + 2 * x + i);
        const Vec next_gy = load(frame_.slope.y.row(2 * block + 1) + 2 * x + i);
        store(gx * gx + next_gx * next_gx, sums[0] + i);
        store(gx * gy + next_gx * next_gy, sums[1] + i);
        store(gy * gy + next_gy * next_gy, sums[2] + i);
      }
      for (int i = 0; i < 3; ++i) {
        const Vec mean = all(0.25F) * sums_of_pairs(sums[i]);
        store(mean, products_[i].row(block) + x);
        means_[i].add(x, mean);
      }
    });
    for (auto &rows : products_)
      repeat_ends(rows.row(block), size_.width / 2);
    means_[0].end_row(block, size_, frame_.cell_structure.xx);
    means_[1].end_row(block, size_, frame_.cell_structure.xy);
    means_[2].end_row(block, size_, frame_.cell_structure.yy);
  }

  HWY_INLINE void window_across(int block) {
    for (int i = 0; i < 3; ++i) {
      const float *from = products_[i].row(block);
      float *to = across_[i].row(block);
      for_vectors(size_.width / 2, [&](int x) HWY_ATTR {
        store(blur_across<kWindowRadius>(kernels_.window.data(), from + x), to + x);
      });
    }
  }

  HWY_INLINE void window_down(int block) {
    HalfMap *to[] = {&frame_.structure.xx, &frame_.structure.xy, &frame_.structure.yy};
    for (int i = 0; i < 3; ++i) {
      const float *rows[2 * kWindowRadius + 1];
      for (int k = 0; k <= 2 * kWindowRadius; ++k)
        rows[k] = across_[i].near(block + k - kWindowRadius, size_.height / 2);
      for_vectors(size_.width / 2, [&](int x) HWY_ATTR {
        store(blur_down<kWindowRadius>(kernels_.window.data(), rows, x), to[i]->row(block) + x);
      });
    }
  }

  // Cells whose largest steepness, after a binomial blur, is below the limit.
  HWY_INLINE void find_flat(int y) {
    const float *up = steep_.near(y - 1, size_.height);
    const float *here = steep_.row(y);
    const float *down = steep_.near(y + 1, size_.height);
    const bool is_first = y % kCellSide == 0;
    for_vectors(size_.width, [&](int x) HWY_ATTR {
      const auto column = [&](int i) HWY_ATTR {
        return all(0.5F) * load(here + i) + all(0.25F) * (load(up + i) + load(down + i));
      };
      const Vec value = all(0.5F) * column(x) + all(0.25F) * (column(x - 1) + column(x + 1));
      store(is_first ? value : hn::Max(value, load(most_ + x)), most_ + x);
      steep_means_.add(x, load(here + x));
    });
    steep_means_.end_row(y, size_, frame_.steepness);
    if (y % kCellSide == kCellSide - 1)
      for_vectors(size_.columns(), [&](int x) HWY_ATTR {
        Vec a, b, c, d;
        hn::LoadInterleaved4(kTag, most_ + kCellSide * x, a, b, c, d);
        const Vec most = hn::Max(hn::Max(a, b), hn::Max(c, d));
        store(hn::IfThenElseZero(most < all(flat_limit_), all(1)),
              frame_.flat.row(y / kCellSide) + x);
      });
  }

  HWY_INLINE hn::Mask<Tag> inside(int x) const {
    return hn::FirstN(kTag, static_cast<std::size_t>(size_.width - x));
  }

  const DescriptionKernels &kernels_;
  const float flat_limit_;
  const LayerSize size_;
  LayerFrame &frame_;
  const WideCells slow_;
  Vec energy_ = hn::Zero(kTag);
  LatestRows<PixelMap, 4> steep_;
  LatestRows<HalfMap, 2> products_[3];
  LatestRows<HalfMap, 8> across_[3];
  CellMeans<kCellSide / 2> means_[3];
  PixelMeans steep_means_;
  alignas(64) float most_[kCellSide * CellMap::kStride] = {};
};

void Describe(const CellMap &slow, const DescriptionKernels &kernels, float flat_limit,
              const LayerSize &size, LayerFrame &frame) {
  FrameDescription(slow, kernels, flat_limit, size, frame).run();
}

void Compare(const PixelMap &one, const PixelMap &other, const LayerSize &size, CellMap &energy) {
  PixelMeans means;
  for (int row = 0; row < size.rows(); ++row) {
    for_vectors(size.width, [&](int x) HWY_ATTR {
      Vec squares = hn::Zero(kTag);
      for (int y = kCellSide * row; y < kCellSide * (row + 1); ++y) {
        const Vec difference = load(one.row(y) + x) - load(other.row(y) + x);
        squares += difference * difference;
      }
      means.add(x, squares);
    });
    means.end_cells(row, size, energy);
  }
}

// Reads a map that is displaced by a constant, where it comes from the map or the room beside it.
class DisplacedMap {
public:
  DisplacedMap(const PixelMap &map, Displacement by, const LayerSize &size)
      : map_(map), by_(by), size_(size), left_(static_cast<int>(std::floor(-by.x))),
        up_(static_cast<int>(std::floor(-by.y))), part_x_(-by.x - static_cast<float>(left_)),
        part_y_(-by.y - static_cast<float>(up_)) {}

  // Calls body(x, read) for the vectors of a row of cells; read(next) calls next(y, values) for
  // each row of pixels.
  template <class Body>
  HWY_INLINE void for_cells(int row, Body &&body) const {
    const float *rows[kCellSide + 1];
    for (int i = 0; i <= kCellSide; ++i)
      rows[i] = near_row(map_, kCellSide * row + up_ + i, size_.height) + left_;
    for_vectors(size_.width, [&](int x) HWY_ATTR {
      if (x + left_ < -PixelMap::kMargin || x + left_ + lanes() >= kLayerSide + PixelMap::kMargin)
        return;
      body(x, [&](auto &&next) HWY_ATTR {
        const auto across = [&](int i) HWY_ATTR {
          const Vec first = load(rows[i] + x);
          return first + all(part_x_) * (load(rows[i] + x + 1) - first);
        };
        Vec above = across(0);
        for (int i = 0; i < kCellSide; ++i) {
          const Vec below = across(i + 1);
          next(kCellSide * row + i, above + all(part_y_) * (below - above));
          above = below;
        }
      });
    });
  }

  // Whether all of a cell was inside the crop before.
  HWY_INLINE bool is_row_inside(int row) const {
    const float top = static_cast<float>(kCellSide * row) - by_.y;
    return top >= 0 && top + kCellSide <= static_cast<float>(size_.height);
  }
  HWY_INLINE hn::Mask<Tag> are_inside(int column) const {
    const Vec left = all(kCellSide) * hn::Iota(kTag, static_cast<float>(column)) - all(by_.x);
    return hn::And(left >= all(0), left <= all(static_cast<float>(size_.width - kCellSide)));
  }

private:
  const PixelMap &map_;
  const Displacement by_;
  const LayerSize size_;
  int left_;
  int up_;
  float part_x_;
  float part_y_;
};

void CompareDisplaced(const PixelMap &earlier, const PixelMap &later, Displacement by,
                      const LayerSize &size, CellMap &energy) {
  const DisplacedMap displaced(earlier, by, size);
  PixelMeans means;
  for (int row = 0; row < size.rows(); ++row) {
    displaced.for_cells(row, [&](int x, auto &&read) HWY_ATTR {
      Vec squares = hn::Zero(kTag);
      read([&](int y, Vec there) HWY_ATTR {
        const Vec difference = there - load(later.row(y) + x);
        squares += difference * difference;
      });
      means.add(x, squares);
    });
    means.end_cells(row, size, energy);
  }
}

TranslationFit FitTranslation(const LayerFrame &earlier, const LayerFrame &later, Displacement by,
                              float noise, const LayerSize &size, CellMap &energy) {
  constexpr float kHalf = 30; // trace that counts by half
  const DisplacedMap displaced(earlier.detail, by, size);
  PixelMeans squares, means_x, means_y;
  CellMap moment_x, moment_y;
  Vec sums[7];
  for (Vec &sum : sums)
    sum = hn::Zero(kTag);
  for (int row = 0; row < size.rows(); ++row) {
    displaced.for_cells(row, [&](int x, auto &&read) HWY_ATTR {
      Vec square = hn::Zero(kTag);
      Vec sum_x = hn::Zero(kTag);
      Vec sum_y = hn::Zero(kTag);
      read([&](int y, Vec there) HWY_ATTR {
        const Vec difference = there - load(later.detail.row(y) + x);
        square += difference * difference;
        sum_x += load(later.slope.x.row(y) + x) * difference;
        sum_y += load(later.slope.y.row(y) + x) * difference;
      });
      squares.add(x, square);
      means_x.add(x, sum_x);
      means_y.add(x, sum_y);
    });
    squares.end_cells(row, size, energy);
    means_x.end_cells(row, size, moment_x);
    means_y.end_cells(row, size, moment_y);
    for_vectors(displaced.is_row_inside(row) ? size.columns() : 0, [&](int x) HWY_ATTR {
      const Vec xx = load(later.cell_structure.xx.row(row) + x);
      const Vec xy = load(later.cell_structure.xy.row(row) + x);
      const Vec yy = load(later.cell_structure.yy.row(row) + x);
      const Vec left = load(energy.row(row) + x);
      const Vec trace = xx + yy;
      // What noise, and half a tenth of a pixel on texture, leave.
      const Vec usual = all(3 + 1.2F * noise) + all(0.08F) * trace;
      const Vec fits = usual / (usual + left);
      const Vec weight = fits * fits / (all(1) + all(0.02F) * trace);
      const Vec seen = trace / (trace + all(kHalf));
      const Vec values[] = {weight * xx,
                            weight * xy,
                            weight * yy,
                            weight * load(moment_x.row(row) + x),
                            weight * load(moment_y.row(row) + x),
                            hn::IfThenElseZero(left <= usual, seen),
                            seen};
      const auto counts = hn::And(displaced.are_inside(x),
                                  hn::FirstN(kTag, static_cast<std::size_t>(size.columns() - x)));
      for (int i = 0; i < 7; ++i)
        sums[i] += hn::IfThenElseZero(counts, values[i]);
    });
  }
  return {{total(sums[0]), total(sums[1]), total(sums[2])},
          {total(sums[3]), total(sums[4])},
          total(sums[5]),
          total(sums[6])};
}

Displacement SearchCells(const CellMap &before, const CellMap &after, int reach,
                         const LayerSize &size) {
  float least = 1e9F;
  Displacement best;
  const int columns = size.columns();
  // Rows with room on both sides, so that a shift by cells reads within them.
  const PaddedCells shifted(before, size);
  for (int dy = -reach; dy <= reach; ++dy)
    for (int dx = -reach; dx <= reach; ++dx) {
      const int top = std::max(0, dy);
      const int bottom = std::min(size.rows(), size.rows() + dy);
      if (top >= bottom || std::abs(dx) >= columns)
        continue;
      const Vec first = all(static_cast<float>(std::max(0, dx)));
      const Vec end = all(static_cast<float>(std::min(columns, columns + dx)));
      Vec sum = hn::Zero(kTag);
      for_vectors(columns, [&](int x) HWY_ATTR {
        const Vec column = hn::Iota(kTag, static_cast<float>(x));
        const auto is_inside = hn::And(column >= first, column < end);
        for (int y = top; y < bottom; ++y) {
          const Vec difference = load(shifted.row(y - dy) + x - dx) - load(after.row(y) + x);
          sum += hn::IfThenElseZero(is_inside, hn::Abs(difference));
        }
      });
      const auto count = static_cast<float>((bottom - top) * (columns - std::abs(dx)));
      if (const float mean = total(sum) / count; mean < least) {
        least = mean;
        best = {static_cast<float>(dx * kCellSide), static_cast<float>(dy * kCellSide)};
      }
    }
  return best;
}

void SumBackground(const LayerFrame &earlier, const LayerFrame &later, const CellMap &luma,
                   Displacement by, const BackgroundLimits &limits, const LayerSize &size,
                   BackgroundCells &means) {
  const WideCells wide(luma, size);
  PixelMeans pixels[5];
  CellMap *cells[] = {&means.structure.xx, &means.structure.xy, &means.structure.yy,
                      &means.moment.x, &means.moment.y};
  const Vec last = all(static_cast<float>(size.width) - 1.5F);
  for (int row = 0; row < size.rows(); ++row) {
    // The outermost pixels have no gradient across.
    const int first_y = std::max(kCellSide * row, 1);
    const int end_y = std::min(kCellSide * (row + 1), size.height - 1);
    for_vectors(size.width, [&](int x) HWY_ATTR {
      Vec sums[5];
      for (Vec &sum : sums)
        sum = hn::Zero(kTag);
      const Vec column = hn::Iota(kTag, static_cast<float>(x));
      const auto is_inside = hn::And(column > all(0.5F), column < last);
      for (int y = first_y; y < end_y; ++y) {
        const float *a = earlier.smooth.row(y) + x;
        const float *b = later.smooth.row(y) + x;
        const auto rise = [&](int to) HWY_ATTR {
          return all(0.25F) * ((load(a + to) - load(a - to)) + (load(b + to) - load(b - to)));
        };
        const Vec now = load(b);
        const Vec change = load(a) - now;
        const Vec gx = rise(1);
        const Vec gy = rise(PixelMap::kStride);
        const Vec left =
            hn::Min(hn::Abs(change), hn::Abs(change - gx * all(by.x) - gy * all(by.y)));
        const Vec most = hn::Max(left, hn::Abs(now - wide.row(y).at(x)));
        const auto counts =
            hn::And(hn::And(gx * gx + gy * gy <= all(limits.steepness), most <= all(limits.change)),
                    is_inside);
        const Vec used_x = hn::IfThenElseZero(counts, gx);
        const Vec used_y = hn::IfThenElseZero(counts, gy);
        sums[0] += used_x * gx;
        sums[1] += used_x * gy;
        sums[2] += used_y * gy;
        sums[3] += used_x * change;
        sums[4] += used_y * change;
      }
      for (int i = 0; i < 5; ++i)
        pixels[i].add(x, sums[i]);
    });
    for (int i = 0; i < 5; ++i)
      pixels[i].end_cells(row, size, *cells[i]);
  }
}

void Remember(const LayerFrame &earlier, const LayerFrame &later, const BackgroundCells &instant,
              const CellMap &background, const CellMap &follows, const MemoryStep &step,
              const LayerSize &size, BackgroundCells &memory, Tensor &structure,
              Displacement &moment) {
  constexpr float kRise = 1.0F / (2 * 2 * kCellSide); // over two cells, in the sum of two frames
  CellMap flats;
  CellMap sums;
  alignas(64) float scales[CellMap::kStride];
  for (int y = 0; y < size.rows(); ++y)
    for_vectors(size.columns(), [&](int x) HWY_ATTR {
      store(load(earlier.flat.row(y) + x) * load(later.flat.row(y) + x), flats.row(y) + x);
      store(load(earlier.mean.row(y) + x) + load(later.mean.row(y) + x), sums.row(y) + x);
    });
  PaddedCells flat(flats, size);
  PaddedCells sum(sums, size);
  // At the border, the next cell on one side is the cell itself.
  std::fill_n(scales, CellMap::kStride, kRise);
  scales[0] = scales[size.columns() - 1] = 2 * kRise;
  Vec totals[5] = {hn::Zero(kTag), hn::Zero(kTag), hn::Zero(kTag), hn::Zero(kTag), hn::Zero(kTag)};
  for (int y = 0; y < size.rows(); ++y) {
    const int up = std::max(y - 1, 0);
    const int down = std::min(y + 1, size.rows() - 1);
    const Vec scale_y = all(down - up == 2 ? kRise : 2 * kRise);
    for_vectors(size.columns(), [&](int x) HWY_ATTR {
      const auto slope = [&](const float *rise, const float *fall, const float *is_rise_flat,
                             const float *is_fall_flat) HWY_ATTR {
        return load(is_rise_flat) * load(is_fall_flat) * (load(rise) - load(fall));
      };
      const Vec gx = load(scales + x) * slope(sum.row(y) + x + 1, sum.row(y) + x - 1,
                                              flat.row(y) + x + 1, flat.row(y) + x - 1);
      const Vec gy =
          scale_y * slope(sum.row(down) + x, sum.row(up) + x, flat.row(down) + x, flat.row(up) + x);
      const Vec change = load(earlier.mean.row(y) + x) - load(later.mean.row(y) + x);
      const Vec trace =
          load(instant.structure.xx.row(y) + x) + load(instant.structure.yy.row(y) + x);
      const Vec enough = hn::Min(trace * all(1 / step.enough), all(1));
      const Vec stays = all(1) - all(step.following) * load(follows.row(y) + x);
      const auto is_flat = load(flat.row(y) + x) > all(0);
      const Vec old =
          hn::IfThenElse(is_flat, stays * all(step.kept) * (all(1) - enough), all(step.forgotten));
      const Vec now = hn::IfThenElseZero(is_flat, stays);
      const auto inside = hn::FirstN(kTag, static_cast<std::size_t>(size.columns() - x));
      const Vec is_background = load(background.row(y) + x);
      CellMap *maps[] = {&memory.structure.xx, &memory.structure.xy, &memory.structure.yy,
                         &memory.moment.x, &memory.moment.y};
      const Vec values[] = {gx * gx, gx * gy, gy * gy, gx * change, gy * change};
      for (int i = 0; i < 5; ++i) {
        float *to = maps[i]->row(y) + x;
        const Vec value = old * load(to) + now * values[i];
        store(value, to);
        totals[i] += hn::IfThenElseZero(inside, is_background * value);
      }
    });
  }
  structure = {total(totals[0]), total(totals[1]), total(totals[2])};
  moment = {total(totals[3]), total(totals[4])};
}

void SolveBackground(const BackgroundCells &instant, const CellMap &follows,
                     const BackgroundPrior &prior, const LayerSize &size, BackgroundCells &sums,
                     VectorMap<CellMap> &motion) {
  for (int y = 0; y < size.rows(); ++y)
    for_vectors(size.columns(), [&](int x) HWY_ATTR {
      const auto add = [&](CellMap &map, const CellMap &more) HWY_ATTR {
        const Vec sum = load(map.row(y) + x) + load(more.row(y) + x);
        store(sum, map.row(y) + x);
        return sum;
      };
      const Vec ridge = all(prior.ridge);
      const Vec a = add(sums.structure.xx, instant.structure.xx) + ridge;
      const Vec b = add(sums.structure.xy, instant.structure.xy);
      const Vec c = add(sums.structure.yy, instant.structure.yy) + ridge;
      const Vec right_x = add(sums.moment.x, instant.moment.x) + ridge * all(prior.drift.x);
      const Vec right_y = add(sums.moment.y, instant.moment.y) + ridge * all(prior.drift.y);
      const Vec inverse = all(1) / (a * c - b * b);
      const Vec own_x = (c * right_x - b * right_y) * inverse;
      const Vec own_y = (a * right_y - b * right_x) * inverse;
      const Vec with_frame = all(prior.frame_counts) * load(follows.row(y) + x);
      store(own_x + with_frame * (all(prior.frame.x) - own_x), motion.x.row(y) + x);
      store(own_y + with_frame * (all(prior.frame.y) - own_y), motion.y.row(y) + x);
    });
}

void ShareBackground(const PixelMap &luma, const CellMap &background_luma, const CellMap &known,
                     float least_known, float least, const LayerSize &size, PixelMap &share) {
  // Of the largest difference within 2 px: the border between two grey levels lies at the middle.
  constexpr float kOfLargest = 0.55F;
  const WideCells background(background_luma, size);
  const WideCells is_known(known, size);
  LatestRows<PixelMap, 8> differences;
  LatestRows<PixelMap, 8> largest_across;
  const auto compare = [&](int y) HWY_ATTR {
    const WideCells::Row usual = background.row(y);
    const float *from = luma.row(y);
    float *to = differences.row(y);
    for_vectors(size.width,
                [&](int x) HWY_ATTR { store(hn::Abs(load(from + x) - usual.at(x)), to + x); });
  };
  const auto find_largest = [&](int y) HWY_ATTR {
    const float *from = differences.row(y);
    float *to = largest_across.row(y);
    for_vectors(size.width, [&](int x) HWY_ATTR {
      const Vec two = hn::Max(hn::Max(load(from + x - 2), load(from + x - 1)),
                              hn::Max(load(from + x + 1), load(from + x + 2)));
      store(hn::Max(two, load(from + x)), to + x);
    });
    const int last = size.width - 1;
    to[0] = to[1] = to[2];
    to[last] = to[last - 1] = to[last - 2];
  };
  const auto divide = [&](int y) HWY_ATTR {
    const float *rows[5];
    for (int i = 0; i < 5; ++i)
      rows[i] = largest_across.near(y + i - 2, size.height);
    const float *difference = differences.row(y);
    const WideCells::Row seen = is_known.row(y);
    float *to = share.row(y);
    for_vectors(size.width, [&](int x) HWY_ATTR {
      const Vec largest = hn::Max(hn::Max(hn::Max(load(rows[0] + x), load(rows[1] + x)),
                                          hn::Max(load(rows[2] + x), load(rows[3] + x))),
                                  load(rows[4] + x));
      const Vec border = hn::Max(all(least), all(kOfLargest) * largest);
      const Vec part = all(2.5F) - (load(difference + x) + load(difference + x)) / border;
      const Vec clamped = hn::Min(hn::Max(part, all(0)), all(1));
      store(hn::IfThenElseZero(seen.at(x) > all(least_known), clamped), to + x);
    });
  };
  for (int y = 0; y < size.height + 3; ++y) {
    if (y < size.height)
      compare(y);
    if (y >= 1 && y - 1 < size.height)
      find_largest(y - 1);
    if (y >= 3)
      divide(y - 3);
  }
}

void Damp(const TensorMap<HalfMap> &structure, Displacement prior, Displacement more, float damping,
          const LayerSize &size, VectorMap<HalfMap> &flow) {
  const Displacement from = more - prior;
  const Vec ridge = all(damping / 2);
  for (int y = 0; y < size.height / 2; ++y) {
    const float *xx = structure.xx.row(y);
    const float *xy = structure.xy.row(y);
    const float *yy = structure.yy.row(y);
    float *ux = flow.x.row(y);
    float *uy = flow.y.row(y);
    for_vectors(size.width / 2, [&](int x) HWY_ATTR {
      const Vec a = load(xx + x) + ridge;
      const Vec b = load(xy + x);
      const Vec c = load(yy + x) + ridge;
      const Vec dx = load(ux + x) + all(from.x);
      const Vec dy = load(uy + x) + all(from.y);
      const Vec lost = ridge / (a * c - b * b);
      store(all(prior.x) + dx - lost * (c * dx - b * dy), ux + x);
      store(all(prior.y) + dy - lost * (a * dy - b * dx), uy + x);
    });
    repeat_ends(ux, size.width / 2);
    repeat_ends(uy, size.width / 2);
  }
}

// Bilinear interpolation between the middles of blocks of 2x2 pixels, for a row of pixels.
HWY_INLINE void widen_row(const HalfMap &map, int y, const LayerSize &size, float *to) {
  const Vec most = all(0.75F);
  const Vec least = all(0.25F);
  const float *near = map.row(y / 2);
  const float *far = near_row(map, y % 2 == 0 ? y / 2 - 1 : y / 2 + 1, size.height / 2);
  for_vectors(size.width / 2, [&](int x) HWY_ATTR {
    const auto column = [&](int i)
                            HWY_ATTR { return most * load(near + i) + least * load(far + i); };
    const Vec here = column(x);
    hn::StoreInterleaved2(most * here + least * column(x - 1), most * here + least * column(x + 1),
                          kTag, to + 2 * x);
  });
}

// The flow of a row of pixels.
struct FlowRow {
  HWY_INLINE void widen(const VectorMap<HalfMap> &flow, int row, const LayerSize &size) {
    widen_row(flow.x, row, size, x);
    widen_row(flow.y, row, size, y);
  }
  alignas(64) float x[kLayerSide + 2 * kVectorFloats];
  alignas(64) float y[kLayerSide + 2 * kVectorFloats];
};

// Samples a map where a row of the flow comes from, clamped into the crop.
class WarpedRow {
public:
  WarpedRow(const PixelMap &map, const LayerSize &size)
      : map_(map), size_(size), most_x_(static_cast<float>(size.width) - 1.001F),
        most_y_(static_cast<float>(size.height) - 1.001F) {}

  HWY_INLINE void begin(const VectorMap<HalfMap> &flow, int y) {
    y_ = y;
    flow_.widen(flow, y, size_);
  }
  HWY_INLINE Vec ux(int x) const { return load(flow_.x + x); }
  HWY_INLINE Vec uy(int x) const { return load(flow_.y + x); }

  // The pixels of a vector come from nearly the same displacement. Where all of them come from
  // within a pixel of the one in the middle, the sum over nine neighbours, each weighted by its
  // nearness, needs no look-up of single pixels.
  HWY_INLINE Vec at(int x) const {
    const auto last = static_cast<float>(size_.width - 1);
    const Vec column = hn::Min(hn::Iota(kTag, static_cast<float>(x)), all(last));
    const Vec at_x = clamped(column - ux(x), most_x_);
    const Vec at_y = clamped(all(static_cast<float>(y_)) - uy(x), most_y_);
    const int middle = std::min(x + lanes() / 2, size_.width - 1);
    const auto nearest = [](int from, float by, float most) HWY_ATTR {
      constexpr float kHalf = 0.5F;
      const float place = std::min(std::max(static_cast<float>(from) - by, 0.0F), most);
      return static_cast<int>(place + kHalf) - from;
    };
    const int base_x = nearest(middle, flow_.x[middle], most_x_);
    const int base_y = nearest(y_, flow_.y[middle], most_y_);
    const Vec beside = at_x - column - all(static_cast<float>(base_x));
    const Vec below = at_y - all(static_cast<float>(y_ + base_y));
    if (HWY_UNLIKELY(!hn::AllTrue(kTag, hn::Max(hn::Abs(beside), hn::Abs(below)) <= all(1))))
      return look_up(at_x, at_y);
    const Vec left = hn::Max(all(0) - beside, all(0));
    const Vec right = hn::Max(beside, all(0));
    const Vec here = all(1) - hn::Abs(beside);
    const auto row = [&](int i) HWY_ATTR {
      const float *from = near_row(map_, y_ + base_y + i, size_.height) + x + base_x;
      return left * load(from - 1) + here * load(from) + right * load(from + 1);
    };
    return hn::Max(all(0) - below, all(0)) * row(-1) + (all(1) - hn::Abs(below)) * row(0) +
           hn::Max(below, all(0)) * row(1);
  }

private:
  static HWY_INLINE Vec clamped(Vec at, float most) {
    return hn::Min(hn::Max(at, all(0)), all(most));
  }

  Vec look_up(Vec at_x, Vec at_y) const {
    alignas(64) float xs[kVectorFloats];
    alignas(64) float ys[kVectorFloats];
    store(at_x, xs);
    store(at_y, ys);
    for (int i = 0; i < lanes(); ++i) {
      const int left = static_cast<int>(xs[i]);
      const int top = static_cast<int>(ys[i]);
      const float *above = map_.row(top) + left;
      const float *below = above + PixelMap::kStride;
      const float part = xs[i] - static_cast<float>(left);
      const float upper = above[0] + part * (above[1] - above[0]);
      const float lower = below[0] + part * (below[1] - below[0]);
      xs[i] = upper + (ys[i] - static_cast<float>(top)) * (lower - upper);
    }
    return load(xs);
  }

  const PixelMap &map_;
  const LayerSize size_;
  const float most_x_; // less than a whole pixel from the last one, so that its neighbour exists
  const float most_y_;
  int y_ = 0;
  FlowRow flow_;
};

void CompareFlow(const LayerFrame &earlier, const LayerFrame &later, const VectorMap<HalfMap> &flow,
                 const LayerSize &size, CellMap &energy) {
  WarpedRow warped(earlier.detail, size);
  PixelMeans means;
  for (int y = 0; y < size.height; ++y) {
    const float *here = later.detail.row(y);
    warped.begin(flow, y);
    for_vectors(size.width, [&](int x) HWY_ATTR {
      const Vec difference = warped.at(x) - load(here + x);
      means.add(x, difference * difference);
    });
    means.end_row(y, size, energy);
  }
}

float StepFlow(const LayerFrame &earlier, const LayerFrame &later, std::span<const float> window,
               Displacement prior, float ridge, const LayerSize &size, VectorMap<HalfMap> &flow,
               PixelMap &term, CellMap &energy) {
  constexpr float kTexture = 30; // trace of the structure that counts by half
  WarpedRow warped(earlier.detail, size);
  alignas(64) float sums_x[kLayerSide + kVectorFloats];
  alignas(64) float sums_y[kLayerSide + kVectorFloats];
  LatestRows<HalfMap, 2> moments_x, moments_y;
  LatestRows<HalfMap, 8> across_x, across_y;
  PixelMeans squares;
  Vec moved = hn::Zero(kTag);
  Vec weights = hn::Zero(kTag);
  const auto linearise = [&](int y) HWY_ATTR {
    const float *slope_x = later.slope.x.row(y);
    const float *slope_y = later.slope.y.row(y);
    const float *here = later.detail.row(y);
    float *to = term.row(y);
    const bool is_second = y % 2 == 1;
    warped.begin(flow, y);
    for_vectors(size.width, [&](int x) HWY_ATTR {
      const Vec difference = warped.at(x) - load(here + x);
      const Vec gx = load(slope_x + x);
      const Vec gy = load(slope_y + x);
      const Vec sum = difference + gx * warped.ux(x) + gy * warped.uy(x);
      squares.add(x, difference * difference);
      store(sum, to + x);
      store(is_second ? load(sums_x + x) + gx * sum : gx * sum, sums_x + x);
      store(is_second ? load(sums_y + x) + gy * sum : gy * sum, sums_y + x);
    });
    squares.end_row(y, size, energy);
  };
  const auto halve = [&](int block) HWY_ATTR {
    float *to_x = moments_x.row(block);
    float *to_y = moments_y.row(block);
    for_vectors(size.width / 2, [&](int x) HWY_ATTR {
      store(all(0.25F) * sums_of_pairs(sums_x + 2 * x), to_x + x);
      store(all(0.25F) * sums_of_pairs(sums_y + 2 * x), to_y + x);
    });
    repeat_ends(to_x, size.width / 2);
    repeat_ends(to_y, size.width / 2);
  };
  const auto window_across = [&](int block) HWY_ATTR {
    const float *from_x = moments_x.row(block);
    const float *from_y = moments_y.row(block);
    float *to_x = across_x.row(block);
    float *to_y = across_y.row(block);
    for_vectors(size.width / 2, [&](int x) HWY_ATTR {
      store(blur_across<kWindowRadius>(window.data(), from_x + x), to_x + x);
      store(blur_across<kWindowRadius>(window.data(), from_y + x), to_y + x);
    });
  };
  const auto solve_row = [&](int block) HWY_ATTR {
    const float *rows_x[2 * kWindowRadius + 1];
    const float *rows_y[2 * kWindowRadius + 1];
    for (int i = 0; i <= 2 * kWindowRadius; ++i) {
      rows_x[i] = across_x.near(block + i - kWindowRadius, size.height / 2);
      rows_y[i] = across_y.near(block + i - kWindowRadius, size.height / 2);
    }
    float *ux = flow.x.row(block);
    float *uy = flow.y.row(block);
    for_vectors(size.width / 2, [&](int x) HWY_ATTR {
      const Vec a = load(later.structure.xx.row(block) + x) + all(ridge);
      const Vec b = load(later.structure.xy.row(block) + x);
      const Vec c = load(later.structure.yy.row(block) + x) + all(ridge);
      const Vec right_x = blur_down<kWindowRadius>(window.data(), rows_x, x) + all(ridge * prior.x);
      const Vec right_y = blur_down<kWindowRadius>(window.data(), rows_y, x) + all(ridge * prior.y);
      const Vec inverse = all(1) / (a * c - b * b);
      const Vec new_x = (c * right_x - b * right_y) * inverse;
      const Vec new_y = (a * right_y - b * right_x) * inverse;
      const Vec trace = a + c - all(2 * ridge);
      const Vec weight =
          hn::IfThenElseZero(hn::FirstN(kTag, static_cast<std::size_t>(size.width / 2 - x)),
                             trace / (trace + all(kTexture)));
      weights += weight;
      moved += weight * (hn::Abs(new_x - load(ux + x)) + hn::Abs(new_y - load(uy + x)));
      store(new_x, ux + x);
      store(new_y, uy + x);
    });
    repeat_ends(ux, size.width / 2);
    repeat_ends(uy, size.width / 2);
  };
  const int blocks = size.height / 2;
  constexpr int kLag = 1 + kWindowRadius;
  for (int block = 0; block < blocks + kLag; ++block) {
    if (block < blocks) {
      linearise(2 * block);
      linearise(2 * block + 1);
      halve(block);
    }
    if (block >= 1 && block - 1 < blocks)
      window_across(block - 1);
    if (block >= kLag)
      solve_row(block - kLag);
  }
  return total(moved) / (1.0F / 4 + total(weights));
}

void Leftover(const LayerFrame &later, const VectorMap<HalfMap> &flow, const PixelMap &term,
              const LayerSize &size, CellMap &energy) {
  PixelMeans squares;
  FlowRow u;
  for (int y = 0; y < size.height; ++y) {
    u.widen(flow, y, size);
    for_vectors(size.width, [&](int x) HWY_ATTR {
      const Vec rest = load(term.row(y) + x) - load(later.slope.x.row(y) + x) * load(u.x + x) -
                       load(later.slope.y.row(y) + x) * load(u.y + x);
      squares.add(x, rest * rest);
    });
    squares.end_row(y, size, energy);
  }
}

// The part of pixel i that lies in [begin, end).
HWY_INLINE float part_in(int i, float begin, float end) {
  const auto first = static_cast<float>(i);
  return std::max(0.0F, std::min(first + 1, end) - std::max(first, begin));
}

enum TileQuantity { kMotionX, kMotionY, kXx, kXy, kYy, kShare, kLeftover, kQuantities };

void SumTiles(const LayerSum &layers, const LayerSize &size, const Rectangle &region, int columns,
              int rows, std::span<TileSums> tiles) {
  const WideCells background_x(layers.background.x, size);
  const WideCells background_y(layers.background.y, size);
  const float wide = static_cast<float>(region.width) / static_cast<float>(columns);
  const float high = static_cast<float>(region.height) / static_cast<float>(rows);
  FlowRow u;
  for (int row = 0; row < rows; ++row) {
    const float top = high * static_cast<float>(row);
    const float bottom = top + high;
    const int first = static_cast<int>(top);
    const int last = std::min(static_cast<int>(std::ceil(bottom)), region.height);
    alignas(64) float sums[kQuantities][kLayerSide + kVectorFloats] = {};
    for (int i = first; i < last; ++i) {
      const int y = region.y + i;
      const Vec part = all(part_in(i, top, bottom));
      u.widen(layers.flow, y, size);
      for_vectors(region.width, [&](int x) HWY_ATTR {
        const int at = region.x + x;
        const Vec gx = load(layers.frame.slope.x.row(y) + at);
        const Vec gy = load(layers.frame.slope.y.row(y) + at);
        const Vec ux = load(u.x + at);
        const Vec uy = load(u.y + at);
        const Vec rest = load(layers.term.row(y) + at) - gx * ux - gy * uy;
        const Vec share = part * load(layers.share.row(y) + at);
        const Vec moving = part - share;
        const auto add = [&](TileQuantity quantity, Vec value) HWY_ATTR {
          store(load(sums[quantity] + x) + value, sums[quantity] + x);
        };
        add(kMotionX, moving * ux + share * background_x.row(y).at(at));
        add(kMotionY, moving * uy + share * background_y.row(y).at(at));
        add(kXx, moving * gx * gx);
        add(kXy, moving * gx * gy);
        add(kYy, moving * gy * gy);
        add(kShare, share);
        add(kLeftover, moving * rest * rest);
      });
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
HWY_EXPORT(Describe);
HWY_EXPORT(BlurCells);
HWY_EXPORT(Compare);
HWY_EXPORT(CompareDisplaced);
HWY_EXPORT(FitTranslation);
HWY_EXPORT(SearchCells);
HWY_EXPORT(SumBackground);
HWY_EXPORT(Remember);
HWY_EXPORT(SolveBackground);
HWY_EXPORT(ShareBackground);
HWY_EXPORT(Damp);
HWY_EXPORT(CompareFlow);
HWY_EXPORT(StepFlow);
HWY_EXPORT(Leftover);
HWY_EXPORT(SumTiles);
} // namespace

void load_luma(const LumaView &view, const LayerSize &size, LayerFrame &frame) {
  HWY_DYNAMIC_DISPATCH(LoadLuma)(view, size, frame);
}

void describe(const CellMap &slow, const DescriptionKernels &kernels, float flat_limit,
              const LayerSize &size, LayerFrame &frame) {
  HWY_DYNAMIC_DISPATCH(Describe)(slow, kernels, flat_limit, size, frame);
}

void blur(std::span<const float> half_kernel, const LayerSize &size, const CellMap &from,
          CellMap &to) {
  HWY_DYNAMIC_DISPATCH(BlurCells)(half_kernel, size, from, to);
}

void compare(const PixelMap &one, const PixelMap &other, const LayerSize &size, CellMap &energy) {
  HWY_DYNAMIC_DISPATCH(Compare)(one, other, size, energy);
}

void compare_displaced(const PixelMap &earlier, const PixelMap &later, Displacement by,
                       const LayerSize &size, CellMap &energy) {
  HWY_DYNAMIC_DISPATCH(CompareDisplaced)(earlier, later, by, size, energy);
}

TranslationFit fit_translation(const LayerFrame &earlier, const LayerFrame &later, Displacement by,
                               float noise, const LayerSize &size, CellMap &energy) {
  return HWY_DYNAMIC_DISPATCH(FitTranslation)(earlier, later, by, noise, size, energy);
}

Displacement search_cells(const CellMap &before, const CellMap &after, int reach,
                          const LayerSize &size) {
  return HWY_DYNAMIC_DISPATCH(SearchCells)(before, after, reach, size);
}

void sum_background(const LayerFrame &earlier, const LayerFrame &later, const CellMap &luma,
                    Displacement by, const BackgroundLimits &limits, const LayerSize &size,
                    BackgroundCells &means) {
  HWY_DYNAMIC_DISPATCH(SumBackground)(earlier, later, luma, by, limits, size, means);
}

void remember(const LayerFrame &earlier, const LayerFrame &later, const BackgroundCells &instant,
              const CellMap &background, const CellMap &follows, const MemoryStep &step,
              const LayerSize &size, BackgroundCells &memory, Tensor &structure,
              Displacement &moment) {
  HWY_DYNAMIC_DISPATCH(Remember)
  (earlier, later, instant, background, follows, step, size, memory, structure, moment);
}

void solve_background(const BackgroundCells &instant, const CellMap &follows,
                      const BackgroundPrior &prior, const LayerSize &size, BackgroundCells &sums,
                      VectorMap<CellMap> &motion) {
  HWY_DYNAMIC_DISPATCH(SolveBackground)(instant, follows, prior, size, sums, motion);
}

void share_background(const PixelMap &luma, const CellMap &background_luma, const CellMap &known,
                      float least_known, float least, const LayerSize &size, PixelMap &share) {
  HWY_DYNAMIC_DISPATCH(ShareBackground)
  (luma, background_luma, known, least_known, least, size, share);
}

void damp(const TensorMap<HalfMap> &structure, Displacement prior, Displacement more, float damping,
          const LayerSize &size, VectorMap<HalfMap> &flow) {
  HWY_DYNAMIC_DISPATCH(Damp)(structure, prior, more, damping, size, flow);
}

void compare_flow(const LayerFrame &earlier, const LayerFrame &later,
                  const VectorMap<HalfMap> &flow, const LayerSize &size, CellMap &energy) {
  HWY_DYNAMIC_DISPATCH(CompareFlow)(earlier, later, flow, size, energy);
}

float step_flow(const LayerFrame &earlier, const LayerFrame &later, std::span<const float> window,
                Displacement prior, float ridge, const LayerSize &size, VectorMap<HalfMap> &flow,
                PixelMap &term, CellMap &energy) {
  return HWY_DYNAMIC_DISPATCH(StepFlow)(earlier, later, window, prior, ridge, size, flow, term,
                                        energy);
}

void leftover(const LayerFrame &later, const VectorMap<HalfMap> &flow, const PixelMap &term,
              const LayerSize &size, CellMap &energy) {
  HWY_DYNAMIC_DISPATCH(Leftover)(later, flow, term, size, energy);
}

void sum_tiles(const LayerSum &layers, const LayerSize &size, const Rectangle &region, int columns,
               int rows, std::span<TileSums> tiles) {
  HWY_DYNAMIC_DISPATCH(SumTiles)(layers, size, region, columns, rows, tiles);
}

} // namespace haptic
#endif

// NOLINTEND(bugprone-implicit-widening-of-multiplication-result)
