// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion models fitted to points: robust weighted least squares, and the choice among them.
#include "motion-points-inl.hpp"

#include "velocity-estimate.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

// Once for each instruction set.
#if defined(HAPTIC_MOTION_MODELS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef HAPTIC_MOTION_MODELS_INL_HPP
#undef HAPTIC_MOTION_MODELS_INL_HPP
#else
#define HAPTIC_MOTION_MODELS_INL_HPP
#endif

HWY_BEFORE_NAMESPACE();
namespace haptic::HWY_NAMESPACE {
namespace {
// Normal equations of weighted least squares: sums over the points of precision times products of
// (1, x, y), and of precision times what is left to explain.
struct Sums {
  float xx[6], xy[6], yy[6]; // times 1, x, y, x², xy, y²
  float gx[3], gy[3];        // times 1, x, y
};

// Weighted by (1 + e² narrowness)^-2 (Geman-McClure), and not at all from `limit` on.
template <bool kGradients>
Sums sums_at(const Points &points, const Motion &motion, float narrowness, float limit) {
  constexpr std::size_t kProducts = kGradients ? 6 : 1;
  constexpr std::size_t kTerms = kGradients ? 3 : 1;
  const Lanes zero = hn::Zero(kTag);
  Lanes xx[6] = {zero, zero, zero, zero, zero, zero};
  Lanes xy[6] = {zero, zero, zero, zero, zero, zero};
  Lanes yy[6] = {zero, zero, zero, zero, zero, zero};
  Lanes gx[3] = {zero, zero, zero};
  Lanes gy[3] = {zero, zero, zero};
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    Lanes ex;
    Lanes ey;
    errors_at(points, motion, i, ex, ey);
    Lanes pxx = load(points.xx, i);
    Lanes pxy = load(points.xy, i);
    Lanes pyy = load(points.yy, i);
    const Lanes e2 = quadratic(pxx, pxy, pyy, ex, ey);
    const Lanes one = hn::Set(kTag, 1);
    const Lanes root = one / hn::MulAdd(e2, hn::Set(kTag, narrowness), one);
    const Lanes w = hn::IfThenElseZero(e2 < hn::Set(kTag, limit), root * root);
    pxx = w * pxx;
    pxy = w * pxy;
    pyy = w * pyy;
    const Lanes ux = hn::MulAdd(pxx, ex, pxy * ey);
    const Lanes uy = hn::MulAdd(pxy, ex, pyy * ey);
    const Lanes x = load(points.x, i);
    const Lanes y = load(points.y, i);
    const Lanes products[6] = {one, x, y, x * x, x * y, y * y};
    for (std::size_t k = 0; k < kProducts; ++k) {
      xx[k] = hn::MulAdd(pxx, products[k], xx[k]);
      xy[k] = hn::MulAdd(pxy, products[k], xy[k]);
      yy[k] = hn::MulAdd(pyy, products[k], yy[k]);
    }
    for (std::size_t k = 0; k < kTerms; ++k) {
      gx[k] = hn::MulAdd(ux, products[k], gx[k]);
      gy[k] = hn::MulAdd(uy, products[k], gy[k]);
    }
  }
  Sums sums{};
  for (std::size_t k = 0; k < kProducts; ++k) {
    sums.xx[k] = sum(xx[k]);
    sums.xy[k] = sum(xy[k]);
    sums.yy[k] = sum(yy[k]);
  }
  for (std::size_t k = 0; k < kTerms; ++k) {
    sums.gx[k] = sum(gx[k]);
    sums.gy[k] = sum(gy[k]);
  }
  return sums;
}

struct Step {
  Motion motion;
  float gain = 0; // by which the sum of squared errors falls
};

// Solves n g = g (upper triangle of n; both are overwritten). False where what the first two
// unknowns leave of a diagonal element is too little.
template <std::size_t kSize>
bool eliminate(float (&n)[kSize][kSize], float (&g)[kSize], float least, float &gain) {
  float inverse[kSize];
#pragma GCC unroll 6
  for (std::size_t j = 0; j < kSize; ++j) {
    if (!(n[j][j] > (j < 2 ? 0 : least)))
      return false;
    inverse[j] = 1 / n[j][j];
    gain += g[j] * g[j] * inverse[j];
#pragma GCC unroll 6
    for (std::size_t i = j + 1; i < kSize; ++i) {
      const float factor = n[j][i] * inverse[j];
      g[i] -= factor * g[j];
#pragma GCC unroll 6
      for (std::size_t k = i; k < kSize; ++k)
        n[i][k] -= factor * n[j][k];
    }
  }
  for (std::size_t j = kSize; j-- > 0;) {
    for (std::size_t i = j + 1; i < kSize; ++i)
      g[j] -= n[j][i] * g[i];
    g[j] *= inverse[j];
  }
  return true;
}

// Nothing if the points do not determine the model.
std::optional<Step> solve(MotionModel model, const Sums &s) {
  // Points closer together than this say nothing about a gradient, px² (of variance).
  constexpr float kSmallestSpread = 1;
  // A direction that nothing was seen along stays where it is.
  constexpr float kRidge = 1e-5F;
  const float information = (s.xx[0] + s.yy[0]) / 2;
  if (!(information > 0))
    return std::nullopt;
  const float xx = s.xx[0] + kRidge * information;
  const float yy = s.yy[0] + kRidge * information;
  const float least = kSmallestSpread * information;
  Step step;
  if (model == MotionModel::translation) {
    float n[2][2] = {{xx, s.xy[0]}, {0, yy}};
    float g[2] = {s.gx[0], s.gy[0]};
    if (!eliminate(n, g, least, step.gain))
      return std::nullopt;
    step.motion = {g[0], g[1]};
  } else if (model == MotionModel::similarity) { // x0, y0, grow, turn
    float n[4][4] = {{xx, s.xy[0], s.xx[1] + s.xy[2], s.xy[1] - s.xx[2]},
                     {0, yy, s.xy[1] + s.yy[2], s.yy[1] - s.xy[2]},
                     {0, 0, s.xx[3] + 2 * s.xy[4] + s.yy[5], s.xy[3] - s.xx[4] + s.yy[4] - s.xy[5]},
                     {0, 0, 0, s.yy[3] - 2 * s.xy[4] + s.xx[5]}};
    float g[4] = {s.gx[0], s.gy[0], s.gx[1] + s.gy[2], s.gy[1] - s.gx[2]};
    if (!eliminate(n, g, least, step.gain))
      return std::nullopt;
    step.motion = {g[0], g[1], g[2], -g[3], g[3], g[2]};
  } else { // x0, y0, xx, xy, yx, yy
    float n[6][6] = {{xx, s.xy[0], s.xx[1], s.xx[2], s.xy[1], s.xy[2]},
                     {0, yy, s.xy[1], s.xy[2], s.yy[1], s.yy[2]},
                     {0, 0, s.xx[3], s.xx[4], s.xy[3], s.xy[4]},
                     {0, 0, 0, s.xx[5], s.xy[4], s.xy[5]},
                     {0, 0, 0, 0, s.yy[3], s.yy[4]},
                     {0, 0, 0, 0, 0, s.yy[5]}};
    float g[6] = {s.gx[0], s.gy[0], s.gx[1], s.gx[2], s.gy[1], s.gy[2]};
    if (!eliminate(n, g, least, step.gain))
      return std::nullopt;
    step.motion = {g[0], g[1], g[2], g[3], g[4], g[5]};
  }
  return step;
}

std::optional<Step> step_from(const Motion &motion, MotionModel model, const Points &points,
                              float narrowness, float limit) {
  return solve(model, model == MotionModel::translation
                          ? sums_at<false>(points, motion, narrowness, limit)
                          : sums_at<true>(points, motion, narrowness, limit));
}

// Where a robust fit begins, and how far off (in standard deviations) that may be.
struct Start {
  Motion motion;
  float sigmas = 1;
};

float median_error(const Points &points, const Motion &motion) {
  alignas(64) Points::Row errors;
  for (std::size_t i = 0; i < points.count; i += kLanes)
    hn::Store(squared_errors(points, motion, i), kTag, errors.data() + i);
  return median(errors, points.count);
}

Start start_at(const Points &points, const Motion &motion) {
  constexpr float kFarthest = 1e4F;
  const float sigmas = std::sqrt(median_error(points, motion) / kMedianOfChi2);
  return {motion, std::clamp(sigmas, 1.0F, kFarthest)};
}

Start mean_start(const Points &points) {
  if (points.count == 1)
    return {{points.dx[0], points.dy[0]}, 1};
  const auto mean = step_from({}, MotionModel::translation, points, 0, kInfinity);
  const Start rough = start_at(points, mean ? mean->motion : Motion{});
  const auto step = step_from(rough.motion, MotionModel::translation, points,
                              1 / (9 * rough.sigmas * rough.sigmas), kInfinity);
  return step ? start_at(points, rough.motion + step->motion) : rough;
}

// Geman-McClure re-weighting, from a scale at which the start can be right down to that of the
// precision, so that a turn does not look like outliers; at last only what agrees counts.
std::optional<Motion> robust_fit(MotionModel model, const Points &points, const Start &start) {
  constexpr float kNarrowing = 5;
  if (points.count == 1)
    return Motion{points.dx[0], points.dy[0]};
  Motion motion = start.motion;
  float sigmas = start.sigmas;
  for (bool last = false; !last; sigmas = std::max(1.0F, sigmas / kNarrowing)) {
    last = sigmas <= 1;
    const auto step = step_from(motion, model, points, 1 / (9 * sigmas * sigmas), kInfinity);
    if (!step)
      return std::nullopt;
    motion = motion + step->motion;
  }
  if (const auto step = step_from(motion, model, points, 0, kOutlier))
    motion = motion + step->motion;
  return motion;
}

std::size_t parameters(MotionModel model) {
  return 2 * (static_cast<std::size_t>(model) - static_cast<std::size_t>(MotionModel::still));
}

// What the parameters of a model cost: 2 ln 4n for two (four: the numbers that a pair of places
// has). That something moves at all costs so much that noise makes it 1 of 200 times at most, for
// few points too: chi square with two degrees of freedom is beyond t with probability exp(-t/2).
float price(MotionModel model, const Points &points) {
  constexpr float kFalseAlarm = 10.6F; // 2 ln 200
  if (model == MotionModel::still)
    return 0;
  return std::max(points.step, kFalseAlarm) +
         points.step * (static_cast<float>(parameters(model)) / 2 - 1);
}

struct Fit {
  Motion motion;
  MotionModel model = MotionModel::none;
  float cost = 0;            // robust information criterion; the smaller the better
  std::size_t explained = 0; // points
};

Fit judged(MotionModel model, const Motion &motion, const Points &points) {
  const Lanes limit = hn::Set(kTag, kOutlier);
  Lanes cost = hn::Zero(kTag);
  std::size_t explained = 0;
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    const Lanes errors = squared_errors(points, motion, i);
    cost = cost + hn::Min(errors, limit);
    explained += hn::CountTrue(kTag, errors < limit);
  }
  return {motion, model, price(model, points) + sum(cost), explained - points.padding()};
}

bool explains_most(const Fit &fit, const Points &points) {
  return 10 * fit.explained >= 6 * points.count;
}

// Half the parameters, and two to contradict; fewer are a translation at most.
bool suffices(MotionModel model, std::size_t count) {
  return model <= MotionModel::translation || count >= parameters(model) / 2 + 2;
}

// Whether what the fit leaves of the points that it explains is worth no larger model's parameters.
bool is_enough(const Fit &fit, const Points &points) {
  // Those it does not explain another model may, for all that this tells.
  if (10 * fit.explained < 8 * points.count)
    return false;
  const auto costs = [&](MotionModel model) {
    return price(model, points) - price(fit.model, points);
  };
  if (!suffices(MotionModel::similarity, points.count)) {
    const auto shift = step_from(fit.motion, MotionModel::translation, points, 0, kOutlier);
    return shift && shift->gain < costs(MotionModel::translation);
  }
  const Sums sums = sums_at<true>(points, fit.motion, 0, kOutlier);
  const auto shift = solve(MotionModel::translation, sums);
  const auto most = solve(MotionModel::affine, sums);
  return shift && most && most->gain < costs(MotionModel::similarity) &&
         (fit.model == MotionModel::translation || shift->gain < costs(MotionModel::translation));
}

struct Selection {
  Fit fit;
  ModelHistory history;
};

// One frame is not enough to change a model that explains nearly as much as the best.
Selection settled(const Fit &best, const std::optional<Fit> &current, ModelHistory history) {
  constexpr float kClear = 2;
  if (!current || current->model == best.model || current->cost - best.cost > kClear ||
      history.challenger == best.model)
    return {best, {best.model, MotionModel::none}};
  return {*current, {current->model, best.model}};
}

// The smallest model from `smallest` on that explains the points.
Selection select_model(const Points &points, MotionModel smallest, ModelHistory history) {
  std::optional<Fit> best;
  std::optional<Fit> current;
  const auto consider = [&](MotionModel model, const Motion &motion) {
    const Fit fit = judged(model, motion, points);
    if (model == history.current)
      current = fit;
    if (!best || fit.cost < best->cost)
      best = fit;
    return history.current <= model && best->model == model && is_enough(fit, points);
  };

  if (smallest == MotionModel::still && consider(MotionModel::still, {}))
    return settled(*best, current, history);
  const Start start = mean_start(points);
  for (const MotionModel model :
       {MotionModel::translation, MotionModel::similarity, MotionModel::affine}) {
    // Its parameters alone cost more than the best model with all its errors.
    if (best && best->cost <= price(model, points) && model > history.current)
      break;
    if (!suffices(model, points.count))
      break;
    if (const auto motion = robust_fit(model, points, start)) {
      if (consider(model, *motion))
        break;
    }
  }
  return settled(*best, current, history);
}

// The displacement that most others share, for when the mean is far from all of them.
Fit commonest_translation(const Points &points) {
  Start start;
  std::size_t most = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    const Motion motion{points.dx[i], points.dy[i]};
    std::size_t near = 0;
    for (std::size_t j = 0; j < points.count; j += kLanes)
      near += hn::CountTrue(kTag, squared_errors(points, motion, j) < hn::Set(kTag, 2 * kOutlier));
    if (near > most) {
      most = near;
      start.motion = motion;
    }
  }
  return judged(MotionModel::translation,
                robust_fit(MotionModel::translation, points, start).value_or(start.motion), points);
}

} // namespace
} // namespace haptic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
