// SPDX-License-Identifier: LGPL-2.1-or-later
// Differences of the grey levels of two planes, one of them displaced.
#include "pixels/image-kernels.hpp"

#include <algorithm>
#include <cmath>

// Once for each instruction set.
#if defined(HAPTIC_PIXEL_DIFFERENCES_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef HAPTIC_PIXEL_DIFFERENCES_INL_HPP
#undef HAPTIC_PIXEL_DIFFERENCES_INL_HPP
#else
#define HAPTIC_PIXEL_DIFFERENCES_INL_HPP
#endif

#include "pixels/lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {
constexpr int kMostDifferences = 74;               // px along each axis
constexpr int kCopyStride = kMostDifferences + 14; // vectors run over the end of a row

struct Source {
  const float *first;
  std::ptrdiff_t stride;

  const float *row(int y) const { return first + y * stride; }
};

// So many pixels from (x, y) on: in the plane, or a copy in which those outside the plane are the
// ones of its border.
Source pixels_of(const Plane &plane, int x, int y, int width, int height, float *copy) {
  if (x >= 0 && x + width <= plane.width() && y >= 0 && y + height <= plane.height())
    return {plane.row(y) + x, plane.stride()};
  for (int row = 0; row < height; ++row) {
    const float *from = plane.row(std::clamp(y + row, 0, plane.height() - 1));
    for (int i = 0; i < width; ++i)
      copy[row * kCopyStride + i] = from[std::clamp(x + i, 0, plane.width() - 1)];
  }
  return {copy, kCopyStride};
}

// Calls body(x, y, difference) for the differences of the grey levels, bilinear in the later frame,
// down one column of vectors after another.
template <class Body>
HWY_INLINE void for_differences(const Plane &earlier, const Plane &later, int left, int top,
                                int width, int height, Displacement d, Body &&body) {
  HWY_ALIGN float copies[2][kMostDifferences * kCopyStride + 16];
  const auto whole_x = static_cast<int>(std::floor(d.x));
  const auto whole_y = static_cast<int>(std::floor(d.y));
  const Source before = pixels_of(earlier, left, top, width, height, copies[0]);
  const Source after =
      pixels_of(later, left + whole_x, top + whole_y, width + 1, height + 1, copies[1]);
  const Lanes u = hn::Set(kTag, d.x - static_cast<float>(whole_x));
  const Lanes v = hn::Set(kTag, d.y - static_cast<float>(whole_y));
  for (int x = 0; x < width; x += lanes()) {
    const auto across = [&](int y) HWY_ATTR {
      const Lanes first = hn::LoadU(kTag, after.row(y) + x);
      return hn::MulAdd(u, hn::Sub(hn::LoadU(kTag, after.row(y) + x + 1), first), first);
    };
    Lanes upper = across(0);
    for (int y = 0; y < height; ++y) {
      const Lanes lower = across(y + 1);
      const Lanes sampled = hn::MulAdd(v, hn::Sub(lower, upper), upper);
      body(x, y, hn::Sub(sampled, hn::LoadU(kTag, before.row(y) + x)));
      upper = lower;
    }
  }
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
