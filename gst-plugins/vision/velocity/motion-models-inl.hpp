// SPDX-License-Identifier: LGPL-2.1-or-later
// Motion models fitted to points by robust weighted least squares, and the choice among them.
#include "velocity/motion-points-inl.hpp"

#include "velocity/velocity-estimate.hpp"

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
// Sums over the points for the normal equations of weighted least squares. A motion is linear in
// its parameters t, d = A(x, y) t, so that the step s from t that minimises sum w e' P e solves
// (sum w A' P A) s = sum w A' P e. The entries of A are 0, 1, x and y.
struct Sums {
  float xx[6], xy[6], yy[6]; // w P times 1, x, y, x², xy, y²
  float gx[3], gy[3];        // w P e times 1, x, y
};

// The weight of a point is w = (1 + c e' P e)^-2, c the narrowness: the weight function of Geman
// and McClure (Bull. Int. Stat. Inst. 52, 1987). It is 0 where e' P e reaches the limit.
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

// Solves n s = g by Gaussian elimination without pivots, as n is symmetric and positive definite.
// Only the upper triangle of n is read; n is overwritten, and g becomes s. Adds g' s to `gain`, by
// which the sum of squares falls. Returns false if a pivot after the first two, which belong to the
// translation, is not above `least`.
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

// Returns the step of a model, or nothing if the points do not determine it. Translation:
// d = (x0, y0). Similarity: d = (x0, y0) + g (x, y) + r (-y, x). Affine: all six parameters.
std::optional<Step> solve(MotionModel model, const Sums &s) {
  // Least variance of the points' places that determines a gradient, px².
  constexpr float kSmallestSpread = 1;
  // Keeps the motion as it is along a direction without precision.
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

// The start of a robust fit and its likely error, in standard deviations.
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

// The scale of the errors from their median, as 1.4826 MAD is for one dimension: the median of chi
// square with two degrees of freedom is 2 ln 2.
Start start_at(const Points &points, const Motion &motion) {
  constexpr float kFarthest = 1e4F;
  const float sigmas = std::sqrt(median_error(points, motion) / kMedianOfChi2);
  return {motion, std::clamp(sigmas, 1.0F, kFarthest)};
}

// Begins at the mean weighted by precision, after one step towards the majority.
Start mean_start(const Points &points) {
  if (points.count == 1)
    return {{points.dx[0], points.dy[0]}, 1};
  const auto mean = step_from({}, MotionModel::translation, points, 0, kInfinity);
  const Start rough = start_at(points, mean ? mean->motion : Motion{});
  const auto step = step_from(rough.motion, MotionModel::translation, points,
                              1 / (9 * rough.sigmas * rough.sigmas), kInfinity);
  return step ? start_at(points, rough.motion + step->motion) : rough;
}

// Iteratively re-weighted least squares with graduated non-convexity (Blake and Zisserman, Visual
// Reconstruction, 1987): the scale of the weight function falls from the error of the start to that
// of the precision, so that points of a rotation do not count as outliers at first. The last step
// takes the points within kOutlier alone, all with weight 1. Returns nothing if the points do not
// determine the model.
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

// The price of a model's k parameters in the geometric robust information criterion of Torr (IJCV
// 50(1), 2002): k ln(r n) with n points and r = 4 numbers of a pair of places. The price of moving
// at all is at least 2 ln 200, so that noise alone passes it once in 200 frames, for few points
// too: chi square with two degrees of freedom exceeds t with probability exp(-t/2).
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
  float cost = 0;            // GRIC; the smaller the better
  std::size_t explained = 0; // points
};

// GRIC = sum of min(e' P e, kOutlier) + price. Torr's term of the manifold's dimension is the same
// for all models and left out.
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

// Whether the points are as many as the model needs, and two more that can contradict it.
bool suffices(MotionModel model, std::size_t count) {
  return model <= MotionModel::translation || count >= parameters(model) / 2 + 2;
}

// Whether no larger model can gain its price, measured by one step of least squares on the points
// that the fit explains.
bool is_enough(const Fit &fit, const Points &points) {
  // The step does not see the other points; another model may explain them.
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

// Returns the best fit, or the current model's if it is nearly as good: then the best becomes the
// model only if it was the best of the frame before, too.
Selection settled(const Fit &best, const std::optional<Fit> &current, ModelHistory history) {
  constexpr float kClear = 2;
  if (!current || current->model == best.model || current->cost - best.cost > kClear ||
      history.challenger == best.model)
    return {best, {best.model, MotionModel::none}};
  return {*current, {current->model, best.model}};
}

// Returns the model with the smallest GRIC from `smallest` on.
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
    // The price of its parameters alone exceeds the best GRIC.
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

// Fits a translation from the displacement that most others are near to. The mean may be far from
// all of them.
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
