// SPDX-License-Identifier: LGPL-2.1-or-later
// Whole images: conversion to luma, reduction, smoothing and the sums of a difference. One source
// for every instruction set (Google Highway, dispatched at run time).
#pragma once

#include "pixels/luma-view.hpp"
#include "pixels/tensor.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace haptic {

/// 8-bit luma without padding. Keeps its memory unless it has to grow.
struct ByteImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> pixels;

  LumaView view() const { return {pixels.data(), width, height, width}; }
};

/// Grey levels as floats. Rows are padded so that vectors may run over their end.
class Plane {
public:
  /// Keeps its memory unless it has to grow.
  void resize(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  int stride() const { return stride_; }
  float *row(int y) { return values_.data() + static_cast<std::ptrdiff_t>(y) * stride_; }
  const float *row(int y) const {
    return values_.data() + static_cast<std::ptrdiff_t>(y) * stride_;
  }

private:
  int width_ = 0;
  int height_ = 0;
  int stride_ = 0;
  std::vector<float> values_;
};

/// Rows of pixels whose components stand side by side, 8 bits each, somewhere in memory; not owned.
/// No byte outside these pixels is read.
struct PackedView {
  const std::uint8_t *pixels = nullptr;
  int pixel_size = 0;        ///< bytes
  int width = 0;             ///< px
  int height = 0;            ///< px
  std::ptrdiff_t stride = 0; ///< bytes from row to row
};

/// Copies byte `at` of each pixel to rows that are `stride` bytes apart. A pixel has two bytes, or
/// four, of which only the second can be had.
void pick_bytes(const PackedView &from, int at, std::uint8_t *to, std::ptrdiff_t stride);

/// Copies the upper eight of the ten lower bits of each pixel, which has two bytes, the lower one
/// first.
void cut_ten_bits(const PackedView &from, std::uint8_t *to, std::ptrdiff_t stride);

/// Copies the upper eight bits of the luma of v210 from pixel `x` of each row on. v210 has six
/// pixels in four little-endian words of 32 bits, each with three samples of ten bits from its
/// lowest bit on: Cb Y Cr, Y Cb Y, Cr Y Cb, Y Cr Y. `from` begins where the rows do; its pixel
/// size says nothing.
void unpack_v210(const PackedView &from, int x, std::uint8_t *to, std::ptrdiff_t stride);

/// Places of the colours in a pixel, bytes.
struct ColourOrder {
  int red = 0;
  int green = 1;
  int blue = 2;
};

/// The luma of pixels of three or four bytes, to rows that are `stride` bytes apart.
void weigh_colours(const PackedView &from, const ColourOrder &order, std::uint8_t *to,
                   std::ptrdiff_t stride);

/// Sums from which frame-change decides whether anything moved.
struct ChangeSums {
  float sum = 0;       ///< of the differences later - earlier
  float squares = 0;   ///< of the squared differences
  Displacement moment; ///< of gradient * difference
  Tensor structure;    ///< of the gradients of the earlier frame
};

/// Both views have the same size, at least 3x3. The outermost pixels only serve the gradients.
ChangeSums measure_change(const LumaView &previous, const LumaView &current);

/// Mean squared differences of rows, grey levels squared.
struct RowDifferences {
  float next = 0;   ///< from a row to the next one
  float second = 0; ///< from a row to the one after the next
};

/// The view is at least 8x3, and at most 16 000 px high.
RowDifferences compare_rows(const LumaView &view);

/// Averages 2x2 pixels; an odd last row or column is left out.
void average_pairs(const LumaView &fine, ByteImage &coarse);

/// Smooths with the 3x3 binomial kernel. The plane lacks the outermost pixels of the view, which
/// is at least 10x10.
void smooth(const LumaView &view, Plane &plane);

/// Averages 2x2 pixels; an odd last row or column is left out.
void halve(const Plane &fine, Plane &coarse);

} // namespace haptic
