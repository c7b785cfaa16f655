#include "velocity-estimate.hpp"

#include "gsthapticmotionmeta.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace haptic {
namespace {

constexpr std::size_t kCapacity = GST_HAPTIC_MOTION_META_MAX_PATCHES;

using Weights = std::array<double, kCapacity>;
using Values = std::array<double, kCapacity>;

// Displacement (px) about the pointer: dx = x0 + xx*x + xy*y, dy = y0 + yx*x + yy*y.
struct Displacement {
  double x0 = 0, y0 = 0;
  double xx = 0, xy = 0, yx = 0, yy = 0;
};

double median(std::span<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1)
    return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

// Weighted moments of the patches about their weighted centroid.
struct Moments {
  double weight = 0;
  double x = 0, y = 0, dx = 0, dy = 0; // means, x and y from the pointer
  double xx = 0, xy = 0, yy = 0;       // sums of products
  double x_dx = 0, x_dy = 0, y_dx = 0, y_dy = 0;

  Moments(const PatchSet &set, const Weights &weights) {
    for (std::size_t i = 0; i < set.patches.size(); ++i) {
      const GstHapticPatch &patch = set.patches[i];
      weight += weights[i];
      x += weights[i] * (patch.x - set.pointer_x);
      y += weights[i] * (patch.y - set.pointer_y);
      dx += weights[i] * patch.dx;
      dy += weights[i] * patch.dy;
    }
    if (!(weight > 0))
      return;
    x /= weight;
    y /= weight;
    dx /= weight;
    dy /= weight;
    for (std::size_t i = 0; i < set.patches.size(); ++i) {
      const GstHapticPatch &patch = set.patches[i];
      const double px = patch.x - set.pointer_x - x;
      const double py = patch.y - set.pointer_y - y;
      const double pdx = patch.dx - dx;
      const double pdy = patch.dy - dy;
      xx += weights[i] * px * px;
      xy += weights[i] * px * py;
      yy += weights[i] * py * py;
      x_dx += weights[i] * px * pdx;
      x_dy += weights[i] * px * pdy;
      y_dx += weights[i] * py * pdx;
      y_dy += weights[i] * py * pdy;
    }
  }

  // The motion that has this gradient and is right at the centroid.
  Displacement with_gradient(double gxx, double gxy, double gyx, double gyy) const {
    return {dx - gxx * x - gxy * y, dy - gyx * x - gyy * y, gxx, gxy, gyx, gyy};
  }
};

// Closed-form weighted least squares; nothing if the patches do not determine the model.
std::optional<Displacement> fit(MotionModel model, const PatchSet &set, const Weights &weights) {
  // Patches closer together than this say nothing about a gradient, px² (of variance).
  constexpr double kSmallestSpread = 1.0;

  const Moments m(set, weights);
  if (!(m.weight > 0))
    return std::nullopt;
  const double spread = m.xx + m.yy;
  if (model == MotionModel::translation)
    return m.with_gradient(0, 0, 0, 0);
  if (model == MotionModel::similarity) {
    if (set.patches.size() < 3 || spread < kSmallestSpread * m.weight)
      return std::nullopt;
    const double grow = (m.x_dx + m.y_dy) / spread;
    const double turn = (m.x_dy - m.y_dx) / spread;
    return m.with_gradient(grow, -turn, turn, grow);
  }
  const double determinant = m.xx * m.yy - m.xy * m.xy;
  // Product over sum of the eigenvalues: about the spread across the longest axis.
  if (set.patches.size() < 4 || !(determinant > kSmallestSpread * m.weight * spread))
    return std::nullopt;
  return m.with_gradient(
      (m.x_dx * m.yy - m.y_dx * m.xy) / determinant, (m.y_dx * m.xx - m.x_dx * m.xy) / determinant,
      (m.x_dy * m.yy - m.y_dy * m.xy) / determinant, (m.y_dy * m.xx - m.x_dy * m.xy) / determinant);
}

Values errors_of(const Displacement &motion, const PatchSet &set) {
  Values errors{};
  for (std::size_t i = 0; i < set.patches.size(); ++i) {
    const GstHapticPatch &patch = set.patches[i];
    const double x = patch.x - set.pointer_x;
    const double y = patch.y - set.pointer_y;
    errors[i] = std::hypot(patch.dx - (motion.x0 + motion.xx * x + motion.xy * y),
                           patch.dy - (motion.y0 + motion.yx * x + motion.yy * y));
  }
  return errors;
}

// Typical error, at least what tracking cannot do better than, px.
double scale_of(const Values &errors, std::size_t count) {
  constexpr double kTrackingFloor = 0.05;
  constexpr double kMedianToSigma = 1 / 1.1774; // of a length with two normal components
  Values sorted = errors;
  return std::max(kTrackingFloor, kMedianToSigma * median(std::span(sorted).first(count)));
}

// Geman-McClure weights: a patch on another object loses its say.
Weights weights_for(const Values &errors, std::size_t count) {
  const double scale = scale_of(errors, count);
  Weights weights{};
  for (std::size_t i = 0; i < count; ++i) {
    const double ratio = errors[i] / (3 * scale);
    const double root = 1 / (1 + ratio * ratio);
    weights[i] = root * root;
  }
  return weights;
}

Displacement medians(const PatchSet &set) {
  Values dx{};
  Values dy{};
  for (std::size_t i = 0; i < set.patches.size(); ++i) {
    dx[i] = set.patches[i].dx;
    dy[i] = set.patches[i].dy;
  }
  const std::size_t count = set.patches.size();
  return {median(std::span(dx).first(count)), median(std::span(dy).first(count))};
}

std::optional<Displacement> robust_fit(MotionModel model, const PatchSet &set) {
  constexpr int kReweightings = 5;
  const std::size_t count = set.patches.size();
  std::optional<Displacement> motion;
  if (model == MotionModel::translation) {
    motion = medians(set);
  } else {
    Weights even{};
    std::fill_n(even.begin(), count, 1.0);
    motion = fit(model, set, even);
  }
  for (int i = 0; i < kReweightings && motion; ++i)
    motion = fit(model, set, weights_for(errors_of(*motion, set), count));
  return motion;
}

struct Fitted {
  Displacement motion;
  MotionModel model;
};

Fitted fit_model(ModelChoice choice, const PatchSet &set) {
  if (choice == ModelChoice::affine)
    if (const auto motion = robust_fit(MotionModel::affine, set))
      return {*motion, MotionModel::affine};
  if (choice == ModelChoice::affine || choice == ModelChoice::similarity)
    if (const auto motion = robust_fit(MotionModel::similarity, set))
      return {*motion, MotionModel::similarity};
  return {robust_fit(MotionModel::translation, set).value_or(medians(set)),
          MotionModel::translation};
}

Displacement mean(const PatchSet &set) {
  Weights even{};
  std::fill_n(even.begin(), set.patches.size(), 1.0);
  return *fit(MotionModel::translation, set, even);
}

// Falls from 1 to 0 as the value goes from `good` to `bad`.
double fade(double value, double good, double bad) {
  return std::clamp((value - bad) / (good - bad), 0.0, 1.0);
}

// Three doubts multiplied: do the patches agree, are there enough of them, do the pictures match?
double confidence_of(const PatchSet &set, int agreeing) {
  double residual = 0;
  for (const GstHapticPatch &patch : set.patches)
    residual += patch.residual;
  residual /= static_cast<double>(set.patches.size());
  const double share = static_cast<double>(agreeing) / std::max(set.candidates, agreeing);
  return fade(share, 0.6, 0.2) * fade(agreeing, 3, 0) * fade(residual, 15, 45);
}

int count_agreeing(const Displacement &motion, const PatchSet &set) {
  // Leaves of one branch do not move as one; what differs by more is another object.
  constexpr double kAlways = 1.0; // px
  constexpr double kOfDisplacement = 0.25;
  const double limit = kAlways + kOfDisplacement * std::hypot(motion.x0, motion.y0);
  const Values errors = errors_of(motion, set);
  return static_cast<int>(std::count_if(
      errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(set.patches.size()),
      [&](double error) { return error <= limit; }));
}

// Time stamps a hair apart make any displacement a speed that no picture shows. False for a number
// that is not finite.
bool is_plausible(const VelocityEstimate &e) {
  constexpr float kFastest = 1e6F; // px/s
  return std::hypot(e.velocity_x, e.velocity_y) < kFastest && std::isfinite(e.spin) &&
         std::isfinite(e.divergence) && e.confidence > 0;
}

} // namespace

VelocityEstimate estimate_velocity(const PatchSet &set, Average average, ModelChoice choice) {
  if (set.patches.empty() || set.patches.size() > kCapacity || !(set.interval > 0))
    return {};

  if (average == Average::model && choice == ModelChoice::still)
    return {.confidence = 1,
            .points = static_cast<int>(set.patches.size()),
            .model = MotionModel::still};

  Fitted fitted{{}, MotionModel::translation};
  if (average == Average::model)
    fitted = fit_model(choice, set);
  else
    fitted.motion = average == Average::mean ? mean(set) : medians(set);

  const Displacement &motion = fitted.motion;
  VelocityEstimate estimate;
  estimate.points = count_agreeing(motion, set);
  estimate.confidence = static_cast<float>(confidence_of(set, estimate.points));
  estimate.velocity_x = static_cast<float>(motion.x0 / set.interval);
  estimate.velocity_y = static_cast<float>(motion.y0 / set.interval);
  estimate.spin = static_cast<float>((motion.yx - motion.xy) / (2 * set.interval));
  estimate.divergence = static_cast<float>((motion.xx + motion.yy) / (2 * set.interval));
  estimate.model = fitted.model;
  if (!is_plausible(estimate))
    return {};
  return estimate;
}

} // namespace haptic
