// SPDX-License-Identifier: LGPL-2.1-or-later
// Two motions among the points of one region.
#include "velocity/velocity-estimate.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

// Once for each instruction set.
#if defined(HAPTIC_TWO_LAYERS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef HAPTIC_TWO_LAYERS_INL_HPP
#undef HAPTIC_TWO_LAYERS_INL_HPP
#else
#define HAPTIC_TWO_LAYERS_INL_HPP
#endif

#include "velocity/motion-models-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {

struct Layers {
  Fit first;
  Motion second; // a translation
  float cost = 0;
};

// Finds a second motion among the points that the first does not explain. Its cost is the GRIC of
// both: sum of min(e1' P e1, e2' P e2, kOutlier), the price of the first model and of a
// translation, and 2 n H(share) for the labels that assign n points to two motions, H the entropy
// in nats.
std::optional<Layers> layers_of(const Points &points, const Fit &first) {
  if (first.explained < kSmallestLayer || points.count - first.explained < kSmallestLayer)
    return std::nullopt;
  Points others;
  alignas(64) Points::Row errors;
  for (std::size_t i = 0; i < points.count; i += kLanes)
    hn::Store(squared_errors(points, first.motion, i), kTag, errors.data() + i);
  for (std::size_t i = 0; i < points.count; ++i)
    if (errors[i] >= kOutlier)
      others.copy(points, i);
  others.pad();
  const Fit second = commonest_translation(others);
  if (second.explained < kSmallestLayer || !explains_most(second, others))
    return std::nullopt;

  Lanes cost = hn::Zero(kTag);
  for (std::size_t i = 0; i < points.count; i += kLanes)
    cost = cost + hn::Min(hn::Min(load(errors, i), hn::Set(kTag, kOutlier)),
                          squared_errors(points, second.motion, i));
  const auto count = static_cast<float>(first.explained + second.explained);
  const float share = static_cast<float>(second.explained) / count;
  const float labels = -2 * count * (share * std::log(share) + (1 - share) * std::log(1 - share));
  return Layers{first, second.motion,
                sum(cost) + price(first.model, points) + points.step + labels};
}

struct Box {
  float x = 0, y = 0, width = 0, height = 0;
};

// The region with coordinates about the centre of the points.
Box region_of(const PatchSet &set, const Points &points) {
  if (set.region_width > 0 && set.region_height > 0)
    return {set.region_x - points.centre_x, set.region_y - points.centre_y, set.region_width,
            set.region_height};
  const auto end = static_cast<std::ptrdiff_t>(points.count);
  const auto [left, right] = std::minmax_element(points.x.begin(), points.x.begin() + end);
  const auto [top, bottom] = std::minmax_element(points.y.begin(), points.y.begin() + end);
  return {*left, *top, *right - *left, *bottom - *top};
}

// The mean motion over the region, (1/A) integral of m(x) dx. Each place has the motion of the
// point nearest to it; points of neither motion are left out. The integral is a sum over a rank-1
// lattice (frac(i phi), (i + 1/2) / N), phi the golden section (Niederreiter, Random Number
// Generation and Quasi-Monte Carlo Methods, 1992). As the motions are linear, the mean of the first
// is its value at the centroid of its places.
Motion mean_by_area(const Points &points, const Box &region, const Layers &layers) {
  constexpr std::size_t kPlaces = 240;
  constexpr float kGoldenStep = 0.6180340F;
  static_assert(kPlaces % kWidest == 0);
  alignas(64) Points::Row first_errors;
  alignas(64) Points::Row second_errors;
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    hn::Store(squared_errors(points, layers.first.motion, i), kTag, first_errors.data() + i);
    hn::Store(squared_errors(points, layers.second, i), kTag, second_errors.data() + i);
  }
  Lanes firsts = hn::Zero(kTag);
  Lanes first_x = hn::Zero(kTag);
  Lanes first_y = hn::Zero(kTag);
  const Lanes count = hn::Iota(kTag, 0); // in the loop, it would go through memory each time
  for (std::size_t place = 0; place < kPlaces; place += kLanes) {
    const Lanes index = count + hn::Set(kTag, static_cast<float>(place));
    const Lanes along = index * hn::Set(kTag, kGoldenStep);
    const Lanes x =
        hn::MulAdd(hn::Set(kTag, region.width), along - hn::Floor(along), hn::Set(kTag, region.x));
    const Lanes y = hn::MulAdd(hn::Set(kTag, region.height / kPlaces), index + hn::Set(kTag, 0.5F),
                               hn::Set(kTag, region.y));
    Lanes least_first = hn::Set(kTag, kInfinity);
    Lanes least_second = least_first;
    for (std::size_t i = 0; i < points.count; ++i) {
      if (std::min(first_errors[i], second_errors[i]) >= kOutlier)
        continue;
      const Lanes away_x = hn::Set(kTag, points.x[i]) - x;
      const Lanes away_y = hn::Set(kTag, points.y[i]) - y;
      const Lanes distance = hn::MulAdd(away_x, away_x, away_y * away_y);
      Lanes &least = first_errors[i] <= second_errors[i] ? least_first : least_second;
      least = hn::Min(least, distance);
    }
    const auto is_first = least_first <= least_second;
    firsts = firsts + hn::IfThenElseZero(is_first, hn::Set(kTag, 1));
    first_x = first_x + hn::IfThenElseZero(is_first, x);
    first_y = first_y + hn::IfThenElseZero(is_first, y);
  }
  const float number = std::max(1.0F, sum(firsts));
  const float share = sum(firsts) / kPlaces;
  const Motion first = layers.first.motion.about(sum(first_x) / number, sum(first_y) / number);
  const auto mean = [&](float a, float b) { return share * a + (1 - share) * b; };
  return {mean(first.x0, layers.second.x0),
          mean(first.y0, layers.second.y0),
          share * first.xx,
          share * first.xy,
          share * first.yx,
          share * first.yy};
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
