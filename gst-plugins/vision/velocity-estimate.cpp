// SPDX-License-Identifier: LGPL-2.1-or-later
#include "velocity-estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "velocity-estimate.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "motion-models-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {

// Falls from 1 to 0 as the value goes from `good` to `bad`.
float fade(float value, float good, float bad) {
  return std::clamp((value - bad) / (good - bad), 0.0F, 1.0F);
}

Precision precision_of(const GstHapticPatch &patch) {
  constexpr float kUnknown = 1 / (0.1F * 0.1F); // 1/px², also in place of nonsense
  constexpr float kFinest = 1e8F;
  const float trace = patch.precision_xx + patch.precision_yy;
  if (!(patch.precision_xx >= 0 && patch.precision_yy >= 0 && trace > 0 && trace < kInfinity &&
        2 * std::abs(patch.precision_xy) <= 1.001F * trace))
    return {kUnknown, 0, kUnknown};
  const float scale = std::min(1.0F, kFinest / trace);
  return {scale * patch.precision_xx, scale * patch.precision_xy, scale * patch.precision_yy};
}

// False for a number that is not finite, too.
bool is_usable(const GstHapticPatch &patch) {
  constexpr float kLargest = 1e5F; // px, grey levels
  return std::abs(patch.x) < kLargest && std::abs(patch.y) < kLargest &&
         std::abs(patch.dx) < kLargest && std::abs(patch.dy) < kLargest &&
         std::abs(patch.residual) < kLargest;
}

void gather(std::span<const GstHapticPatch> patches, Points &points) {
  for (const GstHapticPatch &patch : patches) {
    if (!is_usable(patch))
      continue;
    const std::size_t i = points.count++;
    const Precision p = precision_of(patch);
    const float area = std::clamp(patch.width * patch.height, 1.0F, 1e6F);
    points.x[i] = patch.x;
    points.y[i] = patch.y;
    points.dx[i] = patch.dx;
    points.dy[i] = patch.dy;
    points.xx[i] = p.xx;
    points.xy[i] = p.xy;
    points.yy[i] = p.yy;
    points.weight[i] = area * fade(patch.residual, 15, 45);
    points.area += area;
    points.centre_x += patch.x;
    points.centre_y += patch.y;
  }
  if (points.count == 0)
    return;
  const auto count = static_cast<float>(points.count);
  points.step = 2 * std::log(4 * count);
  points.centre_x /= count;
  points.centre_y /= count;
  for (std::size_t i = 0; i < points.count; ++i) {
    points.x[i] -= points.centre_x;
    points.y[i] -= points.centre_y;
  }
  points.pad();
  blur(points, kTrackingFloor);
}

struct Layers {
  Fit first;
  Motion second; // a translation
  float cost = 0;
};

// A second motion among the points that the first does not explain.
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
  // Which point belongs to which motion has to be told too: twice the entropy of the shares.
  const auto count = static_cast<float>(first.explained + second.explained);
  const float share = static_cast<float>(second.explained) / count;
  const float telling = -2 * count * (share * std::log(share) + (1 - share) * std::log(1 - share));
  return Layers{first, second.motion,
                sum(cost) + price(first.model, points) + points.step + telling};
}

struct Box {
  float x = 0, y = 0, width = 0, height = 0;
};

// About the centre of the points.
Box region_of(const PatchSet &set, const Points &points) {
  if (set.region_width > 0 && set.region_height > 0)
    return {set.region_x - points.centre_x, set.region_y - points.centre_y, set.region_width,
            set.region_height};
  const auto end = static_cast<std::ptrdiff_t>(points.count);
  const auto [left, right] = std::minmax_element(points.x.begin(), points.x.begin() + end);
  const auto [top, bottom] = std::minmax_element(points.y.begin(), points.y.begin() + end);
  return {*left, *top, *right - *left, *bottom - *top};
}

// The mean over the region: each place moves like the point nearest to it, and points that belong
// to neither motion say nothing.
Motion mean_by_area(const Points &points, const Box &region, const Layers &layers) {
  // Golden-section lattice: even along both axes, and finer than any raster of as many places.
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
  for (std::size_t place = 0; place < kPlaces; place += kLanes) {
    const Lanes index = hn::Iota(kTag, static_cast<float>(place));
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

struct Answer {
  Motion felt;                  // about the pointer
  Motion first;                 // what the points do
  std::optional<Motion> second; // what the others do, where they do it together
  bool is_mixture = false;
  MotionModel model = MotionModel::translation;
  float scatter = 0; // px² per component that no model explains
  ModelHistory history;
};

// How far the points are from moving as one, px² per component.
float scatter_of(const Points &points) {
  const Motion middle = mean_start(points).motion;
  alignas(64) Points::Row squares;
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    Lanes ex;
    Lanes ey;
    errors_at(points, middle, i, ex, ey);
    hn::Store(hn::MulAdd(ex, ex, ey * ey), kTag, squares.data() + i);
  }
  return median(squares, points.count) / kMedianOfChi2;
}

// What points that contradict the motion add to the mean over the region. Those that contradict it
// alike side by side are another object, however small; those that do it alone are false matches.
Motion left_by_neighbours(const Points &points, const Motion &motion) {
  constexpr float kAlike = 0.5F;         // px
  constexpr float kOfDifference = 0.25F; // the motion's own gradients, unknown here
  alignas(64) Points::Row errors, ex, ey;
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    Lanes error_x;
    Lanes error_y;
    errors_at(points, motion, i, error_x, error_y);
    hn::Store(error_x, kTag, ex.data() + i);
    hn::Store(error_y, kTag, ey.data() + i);
    hn::Store(squared_errors(points, motion, i), kTag, errors.data() + i);
  }
  const auto count = static_cast<float>(points.count);
  const float near2 = 2.5F * points.area / count;
  const auto supports = [&](std::size_t i, std::size_t j) {
    const auto squared = [](float x, float y) { return x * x + y * y; };
    const float alike = kAlike + kOfDifference * std::sqrt(squared(ex[i], ey[i]));
    return i != j && errors[j] > kOutlier &&
           squared(points.x[i] - points.x[j], points.y[i] - points.y[j]) < near2 &&
           squared(ex[i] - ex[j], ey[i] - ey[j]) < alike * alike;
  };
  Motion left;
  for (std::size_t i = 0; i < points.count; ++i) {
    if (errors[i] <= kOutlier)
      continue;
    std::size_t together = 1;
    for (std::size_t j = 0; j < points.count; ++j)
      together += supports(i, j) ? 1 : 0;
    if (together < kSmallestLayer)
      continue;
    left.x0 += ex[i] / count;
    left.y0 += ey[i] / count;
  }
  return left;
}

void explain(const PatchSet &set, Points &points, ModelHistory history, Answer &answer) {
  // To become a mixture, and to cease to be one, takes more than noise does to the costs.
  constexpr float kHold = 10;
  const auto take = [&](const Selection &selection) {
    answer.first = selection.fit.motion;
    answer.model = selection.fit.model;
    answer.history = selection.history;
    const Motion left = left_by_neighbours(points, answer.first);
    answer.is_mixture = left.x0 != 0 || left.y0 != 0;
    answer.felt =
        answer.first.about(set.pointer_x - points.centre_x, set.pointer_y - points.centre_y) + left;
  };
  Selection selection = select_model(points, MotionModel::still, history);
  if (!explains_most(selection.fit, points)) {
    const Fit common = commonest_translation(points);
    if (common.explained >= kSmallestLayer && common.cost < selection.fit.cost)
      selection = {common, {MotionModel::translation, MotionModel::none}};
  }
  take(selection);
  const auto layers = layers_of(points, selection.fit);
  if (layers && layers->cost < selection.fit.cost + (history.mixture ? kHold : 0)) {
    take({layers->first, {layers->first.model, MotionModel::none}});
    answer.second = layers->second;
    answer.is_mixture = true;
    answer.felt = mean_by_area(points, region_of(set, points), *layers);
    answer.history.mixture = true;
    return;
  }
  if (explains_most(selection.fit, points))
    return;

  // No motion model, no layers: leaves, water. They move, so static is out; the others are judged
  // by how much of the scatter they explain.
  answer.scatter = scatter_of(points);
  blur(points, answer.scatter);
  take(select_model(points, MotionModel::translation, history));
}

// The model that was asked for, or the largest below it that the points determine.
void fit_model(MotionModel largest, Points &points, Answer &answer) {
  constexpr std::array kModels = {MotionModel::affine, MotionModel::similarity,
                                  MotionModel::translation};
  const auto determined = [&](MotionModel model) {
    return model == MotionModel::translation || points.count >= parameters(model) / 2 + 1;
  };
  for (int attempt = 0; attempt < 2; ++attempt) {
    const Start start = mean_start(points);
    answer.first = start.motion;
    for (const MotionModel model : kModels)
      if (model <= largest && determined(model))
        if (const auto motion = robust_fit(model, points, start)) {
          answer.first = *motion;
          answer.model = model;
          break;
        }
    if (attempt > 0 || explains_most(judged(answer.model, answer.first, points), points))
      break;
    answer.scatter = scatter_of(points);
    blur(points, answer.scatter);
  }
}

// The upper of the middle two, or between them.
float middle_of(Points::Row values, std::size_t count) {
  const auto begin = values.begin();
  const auto half = begin + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(begin, half, begin + static_cast<std::ptrdiff_t>(count));
  return count % 2 ? *half : (*half + *std::max_element(begin, half)) / 2;
}

Motion component_medians(const Points &points) {
  return {middle_of(points.dx, points.count), middle_of(points.dy, points.count)};
}

Motion mean(const Points &points) {
  Motion sum;
  for (std::size_t i = 0; i < points.count; ++i) {
    sum.x0 += points.dx[i];
    sum.y0 += points.dy[i];
  }
  const auto count = static_cast<float>(points.count);
  return {sum.x0 / count, sum.y0 / count};
}

Answer answer_of(const PatchSet &set, Points &points, Average average, ModelChoice choice,
                 ModelHistory history) {
  Answer answer;
  if (average == Average::model && choice == ModelChoice::automatic) {
    explain(set, points, history, answer);
    return answer;
  }
  if (average == Average::median)
    answer.first = component_medians(points);
  else if (average == Average::mean)
    answer.first = mean(points);
  else
    fit_model(choice == ModelChoice::affine       ? MotionModel::affine
              : choice == ModelChoice::similarity ? MotionModel::similarity
                                                  : MotionModel::translation,
              points, answer);
  answer.felt =
      answer.first.about(set.pointer_x - points.centre_x, set.pointer_y - points.centre_y);
  return answer;
}

// How sure the points that agree with the answer make it.
struct Support {
  int points = 0;
  float share = 0;     // of the area
  Precision precision; // 1/px²
  float misfit = 0;    // rms error over that predicted, per component
};

Support support_of(const Points &points, const Answer &answer) {
  // Leaves of one branch do not move as one; what differs by more is another object.
  constexpr float kAlways = 1; // px
  constexpr float kOfDisplacement = 0.25F;
  constexpr float kFar = 25; // variances
  const float leeway = kAlways + kOfDisplacement * std::sqrt(answer.first.x0 * answer.first.x0 +
                                                             answer.first.y0 * answer.first.y0);
  const Lanes zero = hn::Zero(kTag);
  Lanes weight = zero, misfit = zero, xx = zero, xy = zero, yy = zero;
  std::size_t agreeing = 0;
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    const Lanes p_xx = load(points.xx, i);
    const Lanes p_xy = load(points.xy, i);
    const Lanes p_yy = load(points.yy, i);
    Lanes wide_xx = p_xx;
    Lanes wide_xy = p_xy;
    Lanes wide_yy = p_yy;
    blur(leeway * leeway / kOutlier, wide_xx, wide_xy, wide_yy);
    Lanes ex;
    Lanes ey;
    errors_at(points, answer.first, i, ex, ey);
    Lanes wide = quadratic(wide_xx, wide_xy, wide_yy, ex, ey);
    Lanes tight = quadratic(p_xx, p_xy, p_yy, ex, ey);
    if (answer.second) {
      errors_at(points, *answer.second, i, ex, ey);
      wide = hn::Min(wide, quadratic(wide_xx, wide_xy, wide_yy, ex, ey));
      tight = hn::Min(tight, quadratic(p_xx, p_xy, p_yy, ex, ey));
    }
    const auto agrees = wide < hn::Set(kTag, kOutlier);
    const auto add = [&](Lanes &sum, Lanes value)
                         HWY_ATTR { sum = sum + hn::IfThenElseZero(agrees, value); };
    agreeing += hn::CountTrue(kTag, agrees);
    add(weight, load(points.weight, i));
    add(misfit, hn::Min(tight, hn::Set(kTag, kFar)));
    add(xx, p_xx);
    add(xy, p_xy);
    add(yy, p_yy);
  }
  agreeing -= points.padding();
  return {static_cast<int>(agreeing),
          sum(weight) / points.area,
          {sum(xx), sum(xy), sum(yy)},
          std::sqrt(sum(misfit) / (2 * std::max(1.0F, static_cast<float>(agreeing))))};
}

constexpr float kGoodDeviation = 0.1F; // px, of the velocity
constexpr float kBadDeviation = 0.5F;

// All that is known is the motion along one direction, across the edges: only that is left of the
// velocity, and counts for its precision. Returns the standard deviation in px.
float known_part(const Precision &p, VelocityEstimate &estimate) {
  constexpr float kUnknown = (kGoodDeviation + kBadDeviation) / 2;
  constexpr float kRatio = 5; // of standard deviations
  const float half = (p.xx - p.yy) / 2;
  const float radius = std::sqrt(half * half + p.xy * p.xy);
  const float most = (p.xx + p.yy) / 2 + radius;
  if (!(most > 0))
    return kInfinity;
  const float least = std::max(0.0F, (p.xx * p.yy - p.xy * p.xy) / most);
  if (least * kUnknown * kUnknown >= 1 || least * kRatio * kRatio > most)
    return 1 / std::sqrt(least);
  // (P - least I) / (most - least) projects on the direction of the larger eigenvalue.
  const float vx = estimate.velocity_x;
  const float vy = estimate.velocity_y;
  const float scale = 1 / (2 * radius);
  estimate.velocity_x = ((radius + half) * vx + p.xy * vy) * scale;
  estimate.velocity_y = (p.xy * vx + (radius - half) * vy) * scale;
  estimate.aperture = true;
  return 1 / std::sqrt(most);
}

// Time stamps a hair apart make any displacement a speed that no frame shows. False for a number
// that is not finite.
bool is_plausible(const VelocityEstimate &e) {
  constexpr float kFastest = 1e6F; // px/s
  return std::hypot(e.velocity_x, e.velocity_y) < kFastest && std::isfinite(e.spin) &&
         std::isfinite(e.divergence) && e.confidence > 0;
}

VelocityEstimate Estimate(const PatchSet &set, Average average, ModelChoice choice,
                          ModelHistory history) {
  Points points;
  gather(set.patches, points);
  if (points.count == 0)
    return {};
  const Answer answer = answer_of(set, points, average, choice, history);

  const Motion &motion = answer.felt;
  const auto per_second = static_cast<float>(1 / set.interval);
  VelocityEstimate estimate{{.velocity_x = motion.x0 * per_second,
                             .velocity_y = motion.y0 * per_second,
                             .spin = (motion.yx - motion.xy) / 2 * per_second,
                             .divergence = (motion.xx + motion.yy) / 2 * per_second}};
  estimate.model = answer.model;
  estimate.mixture = answer.is_mixture;
  estimate.history = answer.history;
  // Three doubts multiplied: is the velocity precise, do the errors fit their precision, and do the
  // patches agree?
  const Support support = support_of(points, answer);
  const float tracked =
      static_cast<float>(points.count) /
      std::max(static_cast<float>(set.candidates), static_cast<float>(points.count));
  estimate.points = support.points;
  estimate.confidence =
      fade(known_part(support.precision, estimate), kGoodDeviation, kBadDeviation) *
      (average == Average::model ? fade(support.misfit, 1.5F, 3.5F) : 1) *
      fade(support.share * tracked, 0.7F, 0.3F);
  return is_plausible(estimate) ? estimate : VelocityEstimate{};
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {
namespace {
HWY_EXPORT(Estimate);
} // namespace

VelocityEstimate estimate_velocity(const PatchSet &set, Average average, ModelChoice choice,
                                   ModelHistory history) {
  if (set.patches.empty() || set.patches.size() > GST_HAPTIC_MOTION_META_MAX_PATCHES ||
      !(set.interval > 0))
    return {};
  if (average == Average::model && choice == ModelChoice::still)
    return {{}, 1, static_cast<int>(set.patches.size()), MotionModel::still};
  return HWY_DYNAMIC_DISPATCH(Estimate)(set, average, choice, history);
}

} // namespace haptic
#endif
