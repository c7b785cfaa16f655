// SPDX-License-Identifier: LGPL-2.1-or-later
// The patches of one frame as points, in vectors of the machine's width: this runs for every frame,
// and most of it is sums over points.
#include "haptic-patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

// Once for each instruction set.
#if defined(HAPTIC_MOTION_POINTS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef HAPTIC_MOTION_POINTS_INL_HPP
#undef HAPTIC_MOTION_POINTS_INL_HPP
#else
#define HAPTIC_MOTION_POINTS_INL_HPP
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kWidest = 16; // lanes
using Tag = hn::CappedTag<float, kWidest>;
using Lanes = hn::Vec<Tag>;
constexpr Tag kTag;
constexpr std::size_t kLanes = hn::MaxLanes(kTag);

constexpr std::size_t kCapacity = GST_HAPTIC_MOTION_META_MAX_PATCHES;
static_assert(kCapacity % kWidest == 0);

constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Limit of a squared error, in variances: the 99 % quantile of chi square with two degrees of
// freedom, -2 ln 0.01. A point beyond it belongs to another object, at whatever distance.
constexpr float kOutlier = 9.21F;
// Median of chi square with two degrees of freedom, 2 ln 2.
constexpr float kMedianOfChi2 = 1.386F;
// Points that a motion of its own needs: fewer false matches can agree by chance.
constexpr std::size_t kSmallestLayer = 3;
// Variance of tracking on texture without noise, from interpolation, px² per component.
constexpr float kTrackingFloor = 0.02F * 0.02F;

// Displacement (px) about the centre of the points: dx = x0 + xx*x + xy*y, dy = y0 + yx*x + yy*y.
struct Motion {
  float x0 = 0, y0 = 0;
  float xx = 0, xy = 0, yx = 0, yy = 0;

  friend Motion operator+(const Motion &a, const Motion &b) {
    return {a.x0 + b.x0, a.y0 + b.y0, a.xx + b.xx, a.xy + b.xy, a.yx + b.yx, a.yy + b.yy};
  }
  Motion about(float x, float y) const {
    return {x0 + xx * x + xy * y, y0 + yx * x + yy * y, xx, xy, yx, yy};
  }
};

// Symmetric 2x2 matrix.
struct Precision {
  float xx = 0, xy = 0, yy = 0;
};

// The patches as rows of one field each. Entries from `count` up to a whole vector are zero: their
// precision is 0, so they add nothing to a sum.
struct Points {
  using Row = std::array<float, kCapacity>;
  std::size_t count = 0;
  float centre_x = 0, centre_y = 0; // px in the frame
  float step = 0;                   // 2 ln 4n, the price of two parameters more
  float area = 0;                   // px²
  alignas(64) Row x, y;             // px from the centre
  alignas(64) Row dx, dy;           // px
  alignas(64) Row xx, xy, yy;       // precision of (dx, dy), 1/px²
  alignas(64) Row weight;           // px², the less the larger the residual
  alignas(64) Row share;            // of the region, 0..1

  static constexpr std::array kRows = {&Points::x,  &Points::y,      &Points::dx,
                                       &Points::dy, &Points::xx,     &Points::xy,
                                       &Points::yy, &Points::weight, &Points::share};

  void pad() {
    const std::size_t end = (count + kWidest - 1) / kWidest * kWidest;
    for (const auto row : kRows)
      for (std::size_t i = count; i < end; ++i)
        (this->*row)[i] = 0;
  }
  void copy(const Points &from, std::size_t i) {
    for (const auto row : kRows)
      (this->*row)[count] = (from.*row)[i];
    ++count;
  }
  std::size_t padding() const { return (kLanes - count % kLanes) % kLanes; }
};

HWY_INLINE float sum(Lanes lanes) {
  return hn::GetLane(hn::SumOfLanes(kTag, lanes));
}

HWY_INLINE Lanes load(const Points::Row &row, std::size_t i) {
  return hn::Load(kTag, row.data() + i);
}

// The errors e = d - (m0 + M x) of the points from i on, px.
HWY_INLINE void errors_at(const Points &points, const Motion &motion, std::size_t i, Lanes &ex,
                          Lanes &ey) {
  const Lanes x = load(points.x, i);
  const Lanes y = load(points.y, i);
  const auto at = [&](float m0, float mx, float my) HWY_ATTR {
    return hn::MulAdd(hn::Set(kTag, my), y, hn::MulAdd(hn::Set(kTag, mx), x, hn::Set(kTag, m0)));
  };
  ex = load(points.dx, i) - at(motion.x0, motion.xx, motion.xy);
  ey = load(points.dy, i) - at(motion.y0, motion.yx, motion.yy);
}

// e' P e, not negative.
HWY_INLINE Lanes quadratic(Lanes xx, Lanes xy, Lanes yy, Lanes ex, Lanes ey) {
  const Lanes px = hn::MulAdd(xx, ex, xy * ey);
  const Lanes py = hn::MulAdd(xy, ex, yy * ey);
  return hn::Max(hn::Zero(kTag), hn::MulAdd(ex, px, ey * py));
}

// e' P e with the precision P of each point: the squared Mahalanobis distance, in variances.
HWY_INLINE Lanes squared_errors(const Points &points, const Motion &motion, std::size_t i) {
  Lanes ex;
  Lanes ey;
  errors_at(points, motion, i, ex, ey);
  return quadratic(load(points.xx, i), load(points.xy, i), load(points.yy, i), ex, ey);
}

// The precision after noise of variance v is added:
// (P^-1 + v I)^-1 = (P + v |P| I) / (1 + v tr P + v^2 |P|), which exists for a P of rank 1 too.
HWY_INLINE void blur(float variance, Lanes &xx, Lanes &xy, Lanes &yy) {
  const Lanes v = hn::Set(kTag, variance);
  const Lanes one = hn::Set(kTag, 1);
  const Lanes more = v * hn::Max(hn::Zero(kTag), (xx * yy) - (xy * xy));
  const Lanes scale = one / hn::MulAdd(v, (xx + yy) + more, one);
  xx = scale * (xx + more);
  xy = scale * xy;
  yy = scale * (yy + more);
}

void blur(Points &points, float variance) {
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    Lanes xx = load(points.xx, i);
    Lanes xy = load(points.xy, i);
    Lanes yy = load(points.yy, i);
    blur(variance, xx, xy, yy);
    hn::Store(xx, kTag, points.xx.data() + i);
    hn::Store(xy, kTag, points.xy.data() + i);
    hn::Store(yy, kTag, points.yy.data() + i);
  }
}

// Returns the median, the upper one of an even number: the largest value that at most count/2
// values are smaller than. Comparing each with all is faster than sorting so few. The values are
// not negative, so the zeros beyond the end change nothing.
float median(const Points::Row &values, std::size_t count) {
  const std::size_t half = count / 2;
  const Lanes rank = hn::Set(kTag, static_cast<float>(half));
  const Lanes one = hn::Set(kTag, 1);
  Lanes middle = hn::Zero(kTag);
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Lanes candidates = load(values, i);
    Lanes below = hn::Zero(kTag);
    for (std::size_t j = 0; j < count; ++j)
      below = below + hn::IfThenElseZero(hn::Set(kTag, values[j]) < candidates, one);
    middle = hn::Max(middle, hn::IfThenElseZero(below <= rank, candidates));
  }
  return hn::GetLane(hn::MaxOfLanes(kTag, middle));
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
