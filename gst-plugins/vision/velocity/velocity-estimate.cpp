// SPDX-License-Identifier: LGPL-2.1-or-later
#include "velocity/velocity-estimate.hpp"

#include "pixels/luma-view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "velocity/velocity-estimate.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "velocity/motion-models-inl.hpp"
#include "velocity/two-layers-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {

// Falls from 1 to 0 as the value goes from `good` to `bad`.
float fade(float value, float good, float bad) {
  return std::clamp((value - bad) / (good - bad), 0.0F, 1.0F);
}

Precision precision_of(const GstHapticPatch &patch) {
  constexpr float kUnknown = 1 / (0.1F * 0.1F); // 1/px², also for an impossible precision
  constexpr float kFinest = 1e8F;
  constexpr float kRounded = 1.001F; // of an edge, whose determinant is 0
  const float trace = patch.precision_xx + patch.precision_yy;
  const float largest_xy = std::sqrt(patch.precision_xx) * std::sqrt(patch.precision_yy);
  if (!(patch.precision_xx >= 0 && patch.precision_yy >= 0 && trace > 0 && trace < kInfinity &&
        std::abs(patch.precision_xy) <= kRounded * largest_xy))
    return {kUnknown, 0, kUnknown};
  const float scale = std::min(1.0F, kFinest / trace);
  return {scale * patch.precision_xx,
          scale * std::clamp(patch.precision_xy, -largest_xy, largest_xy),
          scale * patch.precision_yy};
}

// False for a number that is not finite, too.
bool is_usable(const GstHapticPatch &patch) {
  constexpr float kLargest = 1e5F; // px, grey levels
  return std::abs(patch.x) < kLargest && std::abs(patch.y) < kLargest &&
         std::abs(patch.dx) < kLargest && std::abs(patch.dy) < kLargest &&
         std::abs(patch.residual) < kLargest && std::abs(patch.share) < kLargest;
}

// Puts the usable patches into rows, with places about their centre.
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
    points.share[i] = std::max(0.0F, patch.share);
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

Motion at_pointer(const PatchSet &set, const Points &points, const Motion &motion) {
  return motion.about(set.pointer_x - points.centre_x, set.pointer_y - points.centre_y);
}

struct Answer {
  Motion felt;                  // about the pointer
  Motion first;                 // of the points
  std::optional<Motion> second; // of the points that the first does not explain
  bool is_mixture = false;
  MotionModel model = MotionModel::translation;
  float scatter = 0;      // px² per component that no model explains
  float disagreement = 0; // px between the motion of the model and that of the pixels
  ModelHistory history;
};

// The variance of the displacements about their mean in px² per component, from the median of the
// squared distances: median / (2 ln 2).
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

// Returns the sum of the errors of contradicting points over the number of all points: their share
// of the mean over the region. Neighbours that contradict the motion alike are another object,
// however small; a point that does so alone is a false match and left out.
Motion left_by_neighbours(const Points &points, const Motion &motion) {
  constexpr float kAlike = 0.5F;         // px
  constexpr float kOfDifference = 0.25F; // for the gradients of the other motion
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

// Finds the smallest model that explains the points, or two motions, or neither.
void explain(const PatchSet &set, Points &points, ModelHistory history, Answer &answer) {
  // Larger than the noise of the costs, so that a mixture does not come and go.
  constexpr float kHold = 10;
  const auto adopt = [&](const Selection &selection) {
    answer.first = selection.fit.motion;
    answer.model = selection.fit.model;
    answer.history = selection.history;
  };
  const auto add_neighbours = [&] {
    const Motion left = set.parts.neighbours ? left_by_neighbours(points, answer.first) : Motion{};
    answer.is_mixture = left.x0 != 0 || left.y0 != 0;
    answer.felt = at_pointer(set, points, answer.first) + left;
  };
  Selection selection = select_model(points, MotionModel::still, history);
  if (!explains_most(selection.fit, points)) {
    const Fit common = commonest_translation(points);
    if (common.explained >= kSmallestLayer && common.cost < selection.fit.cost)
      selection = {common, {MotionModel::translation, MotionModel::none}};
  }
  const auto layers =
      set.parts.second_motion ? layers_of(points, selection.fit) : std::optional<Layers>();
  if (layers && layers->cost < selection.fit.cost + (history.mixture ? kHold : 0)) {
    adopt({layers->first, {layers->first.model, MotionModel::none}});
    answer.second = layers->second;
    answer.is_mixture = true;
    answer.felt = mean_by_area(points, region_of(set, points), *layers);
    answer.history.mixture = true;
    return;
  }
  if (explains_most(selection.fit, points)) {
    adopt(selection);
    add_neighbours();
    return;
  }

  // Neither one model nor two, as for leaves and water. They move, so the static model is out. The
  // others are judged with the scatter as noise.
  answer.scatter = scatter_of(points);
  blur(points, answer.scatter);
  adopt(select_model(points, MotionModel::translation, history));
  add_neighbours();
}

// The share of the region that moves within a pixel of a point, and 0 if no other point does. A
// small one belongs to a false match.
float share_alike(const Points &points, std::size_t i) {
  constexpr float kAlike = 1; // px
  const Lanes x = hn::Set(kTag, points.dx[i]);
  const Lanes y = hn::Set(kTag, points.dy[i]);
  Lanes share = hn::Zero(kTag);
  std::size_t alike = 0;
  for (std::size_t j = 0; j < points.count; j += kLanes) {
    const Lanes ex = load(points.dx, j) - x;
    const Lanes ey = load(points.dy, j) - y;
    const auto is_point =
        hn::Iota(kTag, static_cast<float>(j)) < hn::Set(kTag, static_cast<float>(points.count));
    const auto is_near = hn::MulAdd(ex, ex, ey * ey) < hn::Set(kTag, kAlike * kAlike);
    const auto is_alike = hn::And(is_point, is_near);
    alike += hn::CountTrue(kTag, is_alike);
    share = share + hn::IfThenElseZero(is_alike, load(points.share, j));
  }
  return alike > 1 ? sum(share) : 0;
}

// Where the tracker counted the pixels that move with each point, the points that contradict the
// first motion m add their errors by these shares: m(pointer) + sum of share (d - m(x)). Where
// neither one model nor two explain the points, all do.
void count_shares(const PatchSet &set, const Points &points, Answer &answer) {
  constexpr float kCounted = 0.5F;
  constexpr float kLeast = 1.0F / 16; // of the region
  // A point that contradicts alone by less is a false match where a model bends.
  constexpr float kApart = 2; // px
  // What bends is scattered by less.
  constexpr float kScattered = 0.1F; // px²
  const bool is_scattered = answer.scatter > kScattered;
  // Most frames have no shares.
  const auto end = points.share.begin() + static_cast<std::ptrdiff_t>(points.count);
  if (std::accumulate(points.share.begin(), end, 0.0F) < kCounted)
    return;
  Points::Row shares;
  float all = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    shares[i] = share_alike(points, i) < kLeast ? 0 : points.share[i];
    all += shares[i];
  }
  if (all < kCounted)
    return;
  alignas(64) Points::Row of_first, of_second;
  of_second.fill(kInfinity);
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    hn::Store(squared_errors(points, answer.first, i), kTag, of_first.data() + i);
    if (answer.second)
      hn::Store(squared_errors(points, *answer.second, i), kTag, of_second.data() + i);
  }
  Motion felt = at_pointer(set, points, answer.first);
  bool contradicted = false;
  for (std::size_t i = 0; i < points.count; ++i) {
    if (shares[i] <= 0 || (of_first[i] <= kOutlier && !is_scattered))
      continue;
    const Motion here = answer.first.about(points.x[i], points.y[i]);
    const bool follows_second = of_second[i] <= kOutlier;
    const float x = (follows_second ? answer.second->x0 : points.dx[i]) - here.x0;
    const float y = (follows_second ? answer.second->y0 : points.dy[i]) - here.y0;
    if (!answer.is_mixture && !is_scattered && x * x + y * y < kApart * kApart)
      continue;
    contradicted = true;
    felt.x0 += shares[i] / all * x;
    felt.y0 += shares[i] / all * y;
  }
  answer.disagreement = std::hypot(felt.x0 - answer.felt.x0, felt.y0 - answer.felt.y0);
  answer.felt = felt;
  answer.is_mixture = answer.is_mixture || contradicted;
}

// Fits the model that was asked for, or the largest below it that the points determine.
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

// Returns the median, the mean of the middle two of an even number.
float middle_of(Points::Row values, std::size_t count) {
  const auto begin = values.begin();
  const auto half = begin + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(begin, half, begin + static_cast<std::ptrdiff_t>(count));
  return count % 2 ? *half : (*half + *std::max_element(begin, half)) / 2;
}

Motion component_medians(const Points &points) {
  return {middle_of(points.dx, points.count), middle_of(points.dy, points.count)};
}

// Equation 3 of the paper: the mean of the displacements.
Motion mean(const Points &points) {
  Motion sum;
  for (std::size_t i = 0; i < points.count; ++i) {
    sum.x0 += points.dx[i];
    sum.y0 += points.dy[i];
  }
  const auto count = static_cast<float>(points.count);
  return {sum.x0 / count, sum.y0 / count};
}

// Each counts by its share.
Motion mean_by_share(const Points &points) {
  Motion sum;
  float shares = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    sum.x0 += points.share[i] * points.dx[i];
    sum.y0 += points.share[i] * points.dy[i];
    shares += points.share[i];
  }
  return shares > 0 ? Motion{sum.x0 / shares, sum.y0 / shares} : mean(points);
}

// Of tiles the model says only how they turn and spread.
void take_mean(const Points &points, Answer &answer) {
  answer.felt = answer.first;
  answer.first = mean_by_share(points);
  answer.felt.x0 = answer.first.x0;
  answer.felt.y0 = answer.first.y0;
  answer.second.reset();
}

// Where the tracker gave each point one of two displacements and counted the pixels of each, there
// is nothing left to find. Returns false elsewhere.
bool follow_two(const Points &points, Answer &answer) {
  constexpr float kCounted = 0.5F;
  constexpr float kLeast = 1.0F / 16; // of the region
  const auto is_at = [&](std::size_t i, std::size_t of) {
    return points.dx[i] == points.dx[of] && points.dy[i] == points.dy[of];
  };
  std::size_t other = 0;
  std::size_t others = 0;
  float share = 0;
  float all = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    all += points.share[i];
    if (is_at(i, 0))
      continue;
    other = others == 0 ? i : other;
    if (!is_at(i, other))
      return false;
    ++others;
    share += points.share[i];
  }
  if (all < kCounted || std::min(share, all - share) < kLeast * all)
    return false;
  share /= all;
  const Motion first{points.dx[0], points.dy[0]};
  const Motion second{points.dx[other], points.dy[other]};
  const float apart_x = second.x0 - first.x0;
  const float apart_y = second.y0 - first.y0;
  answer.felt = {first.x0 + share * apart_x, first.y0 + share * apart_y};
  answer.first = share > 0.5F ? second : first;
  answer.second = share > 0.5F ? first : second;
  answer.is_mixture = true;
  // The points are spread evenly.
  const float of_points = static_cast<float>(others) / static_cast<float>(points.count);
  answer.disagreement = std::abs(share - of_points) * std::hypot(apart_x, apart_y);
  answer.history = {MotionModel::translation, MotionModel::none, true};
  return true;
}

Answer answer_of(const PatchSet &set, Points &points, Average average, ModelChoice choice,
                 ModelHistory history) {
  Answer answer;
  if (average == Average::model && choice == ModelChoice::automatic) {
    if (!set.is_tiled && set.parts.second_motion && follow_two(points, answer))
      return answer;
    explain(set, points, history, answer);
    if (set.is_tiled)
      take_mean(points, answer);
    else
      count_shares(set, points, answer);
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
  answer.felt = at_pointer(set, points, answer.first);
  return answer;
}

// Factor of the confidence where the points agree with themselves, but not with the pixels: two
// motions that disagree with their shares, and rest although much of the region changed.
float pixel_confidence(const PatchSet &set, const Answer &answer) {
  constexpr float kDoubtful = 0.7F;
  constexpr float kDisagreement = 0.7F; // px
  if (set.is_tiled)
    return 1;
  if (answer.is_mixture)
    return kDoubtful * std::exp(-answer.disagreement / kDisagreement);
  if (answer.model != MotionModel::still)
    return 1;
  const auto unexplained = std::ranges::count_if(set.patches, [](const GstHapticPatch &patch) {
    return patch.residual * patch.residual > kCompressionResidual2;
  });
  return 5 * unexplained > std::ssize(set.patches) ? kDoubtful : 1;
}

// The points that agree with the answer, and how precise and consistent they are.
struct Support {
  int points = 0;
  float share = 0;     // of the area
  Precision precision; // 1/px²
  float misfit = 0;    // rms error over that predicted, per component
};

// Sums over the points whose error is within the leeway and their own noise. All agree where
// their mean is the answer: what moves in one tile need not move in another.
Support support_of(const Points &points, const Answer &answer, bool all_agree) {
  // Parts of one thing may differ by as much; a larger difference is another object.
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
    const auto agrees = (all_agree ? zero : wide) < hn::Set(kTag, kOutlier);
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

// The aperture problem: edges of one direction determine the velocity only across them. Then the
// velocity becomes its projection on the eigenvector of the larger eigenvalue of the precision P.
// With l1 >= l2 the eigenvalues tr P / 2 +- sqrt(((Pxx - Pyy) / 2)^2 + Pxy^2), the projection is
// (P - l2 I) / (l1 - l2). Returns the standard deviation in px: 1/sqrt(l1) after a projection,
// otherwise 1/sqrt(l2).
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
  const float vx = estimate.velocity_x;
  const float vy = estimate.velocity_y;
  const float scale = 1 / (2 * radius);
  estimate.velocity_x = ((radius + half) * vx + p.xy * vy) * scale;
  estimate.velocity_y = (p.xy * vx + (radius - half) * vy) * scale;
  estimate.aperture = true;
  return 1 / std::sqrt(most);
}

// Time stamps that nearly coincide make an impossible speed of any displacement. False for a number
// that is not finite.
bool is_plausible(const VelocityEstimate &e) {
  return std::hypot(e.velocity_x, e.velocity_y) < kFastestMotion && std::isfinite(e.spin) &&
         std::isfinite(e.divergence) && e.confidence > 0;
}

// Velocity v = d / interval (paper, equation 2), with the antisymmetric and the isotropic part of
// its gradient: spin = (dvy/dx - dvx/dy) / 2, divergence = (dvx/dx + dvy/dy) / 2.
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
  // The confidence is a product: precision of the velocity, errors in relation to their precision,
  // share of the patches that agree, agreement with the pixels.
  const Support support =
      support_of(points, answer,
                 set.is_tiled && average == Average::model && choice == ModelChoice::automatic);
  const float tracked =
      static_cast<float>(points.count) /
      std::max(static_cast<float>(set.candidates), static_cast<float>(points.count));
  estimate.points = support.points;
  estimate.confidence =
      fade(known_part(support.precision, estimate), kGoodDeviation, kBadDeviation) *
      (average == Average::model && !set.is_tiled ? fade(support.misfit, 1.5F, 3.5F) : 1) *
      fade(support.share * tracked, 0.7F, 0.3F) *
      (set.parts.pixel_confidence ? pixel_confidence(set, answer) : 1);
  return is_plausible(estimate) ? estimate : VelocityEstimate{};
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haptic {
namespace {
HWY_EXPORT(Estimate);

using PatchRoom = std::array<GstHapticPatch, GST_HAPTIC_MOTION_META_MAX_PATCHES>;

// The patches about the pointer alone, and the part of the region about it. Without one, all stay.
PatchSet about_pointer(const PatchSet &set, PatchRoom &room) {
  // Of both sides of the region. With 0.3, 0.5, 0.6, 0.7 and 0.8 of them, a hand told the motion of
  // the pointed thing from the truth in 84, 70, 69, 70 and 79 % of the time (method=fast, alpha
  // 0.04 s/px).
  constexpr float kPart = 0.6F;
  const float half_width = kPart * set.region_width / 2;
  const float half_height = kPart * set.region_height / 2;
  const auto end = std::ranges::copy_if(set.patches, room.begin(), [&](const GstHapticPatch &p) {
                     return std::abs(p.x - set.pointer_x) <= half_width &&
                            std::abs(p.y - set.pointer_y) <= half_height;
                   }).out;
  PatchSet near = set;
  near.patches = {room.begin(), end};
  near.region_x = set.pointer_x - half_width;
  near.region_y = set.pointer_y - half_height;
  near.region_width = 2 * half_width;
  near.region_height = 2 * half_height;
  return near;
}

// The tiles that move with what is under the pointer: within a distance and a share of its
// displacement, as the truth of wind-film has it.
PatchSet like_pointed(const PatchSet &set, PatchRoom &room) {
  constexpr float kAlike = 0.15F; // px
  constexpr float kOfDisplacement = 0.25F;
  // Tiles about the pointer that say how it moves, standard deviation. With the nearest one alone,
  // and with 0.5 and 0.7, a hand told the cut-outs from the truth in 44, 44 and 44 % of the time at
  // alpha 0.04 s/px, but in 32, 28 and 28 % at 0.01 (felt.sh --set tuning).
  constexpr float kSpread = 0.5F;
  float x = 0;
  float y = 0;
  float weights = 0;
  for (const GstHapticPatch &tile : set.patches) {
    const float across = (tile.x - set.pointer_x) / (kSpread * tile.width);
    const float down = (tile.y - set.pointer_y) / (kSpread * tile.height);
    const float weight = std::exp(-(across * across + down * down) / 2);
    x += weight * tile.dx;
    y += weight * tile.dy;
    weights += weight;
  }
  x /= weights;
  y /= weights;
  const float most = kAlike + kOfDisplacement * std::hypot(x, y);
  // A tile comes and goes without a step: it counts wholly up to half of the distance, and by half
  // at it.
  std::size_t count = 0;
  for (const GstHapticPatch &tile : set.patches) {
    const float far = std::hypot(tile.dx - x, tile.dy - y) / most;
    if (!(far < 1.5F))
      continue;
    room[count] = tile;
    room[count++].share = std::min(1.5F - far, 1.0F);
  }
  PatchSet alike = set;
  alike.patches = std::span(room).first(count);
  return alike;
}

// What a hand at the pointer points at. Where no patch shows it, all stay.
PatchSet of_pointed(const PatchSet &set, PatchRoom &room) {
  PatchSet of = set.is_tiled ? like_pointed(set, room) : about_pointer(set, room);
  if (of.patches.empty())
    return set;
  of.candidates =
      set.candidates * static_cast<int>(of.patches.size()) / static_cast<int>(set.patches.size());
  return of;
}
} // namespace

VelocityEstimate estimate_velocity(const PatchSet &set, Average average, ModelChoice choice,
                                   ModelHistory history) {
  if (set.patches.empty() || set.patches.size() > GST_HAPTIC_MOTION_META_MAX_PATCHES ||
      !(set.interval > 0))
    return {};
  if (average == Average::pointed) {
    PatchRoom room;
    return estimate_velocity(of_pointed(set, room), Average::model, choice, history);
  }
  if (average == Average::model && choice == ModelChoice::still)
    return {{}, 1, static_cast<int>(set.patches.size()), MotionModel::still};
  return HWY_DYNAMIC_DISPATCH(Estimate)(set, average, choice, history);
}

} // namespace haptic
#endif
