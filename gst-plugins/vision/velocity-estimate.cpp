#include "velocity-estimate.hpp"

#include "gsthapticmotionmeta.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <experimental/simd>
#include <limits>
#include <optional>

namespace haptic {
namespace {

constexpr std::size_t kCapacity = GST_HAPTIC_MOTION_META_MAX_PATCHES;

// Vectors of the machine's width: this runs for every picture, and most of it is sums over points.
namespace simd = std::experimental;
using Lanes = simd::native_simd<float>;
constexpr std::size_t kLanes = Lanes::size();
static_assert(kCapacity % kLanes == 0);

struct alignas(simd::memory_alignment_v<Lanes>) Values : std::array<float, kCapacity> {
  Lanes lanes(std::size_t i) const { return {data() + i, simd::vector_aligned}; }
  void set_lanes(std::size_t i, const Lanes &value) {
    value.copy_to(data() + i, simd::vector_aligned);
  }
};

// A squared error beyond this many variances is another object (99 % of chi square with two
// degrees of freedom), and how far off it is does not matter.
constexpr float kOutlier = 9.21F;
// Median of chi square with two degrees of freedom.
constexpr float kMedianOfChi2 = 1.386F;
// Smaller groups that agree are not a motion of their own: false matches agree by chance.
constexpr std::size_t kSmallestLayer = 3;

// Displacement (px) about the pointer: dx = x0 + xx*x + xy*y, dy = y0 + yx*x + yy*y.
struct Displacement {
  float x0 = 0, y0 = 0;
  float xx = 0, xy = 0, yx = 0, yy = 0;

  template <typename Number>
  Number dx(const Number &x, const Number &y) const {
    return x0 + xx * x + xy * y;
  }
  template <typename Number>
  Number dy(const Number &x, const Number &y) const {
    return y0 + yx * x + yy * y;
  }
  friend Displacement operator+(const Displacement &a, const Displacement &b) {
    return {a.x0 + b.x0, a.y0 + b.y0, a.xx + b.xx, a.xy + b.xy, a.yx + b.yx, a.yy + b.yy};
  }
};

// What the patches say, in rows of their own. Entries from `count` on are zero: without
// information they have no say.
struct Points {
  std::size_t count = 0;
  Values x{}, y{};      // px from the pointer
  Values dx{}, dy{};    // px
  Values information{}; // one over the variance of a component, 1/px²

  // To be added to the lanes counted when entries beyond `count` are counted too.
  std::size_t padding() const { return (kLanes - count % kLanes) % kLanes; }

  Lanes error_x(const Displacement &motion, std::size_t i) const {
    return dx.lanes(i) - motion.dx(x.lanes(i), y.lanes(i));
  }
  Lanes error_y(const Displacement &motion, std::size_t i) const {
    return dy.lanes(i) - motion.dy(x.lanes(i), y.lanes(i));
  }
  // In variances.
  Lanes squared_errors(const Displacement &motion, std::size_t i) const {
    const Lanes ex = error_x(motion, i);
    const Lanes ey = error_y(motion, i);
    return (ex * ex + ey * ey) * information.lanes(i);
  }
  bool is_explained(const Displacement &motion, std::size_t i) const {
    const float ex = dx[i] - motion.dx(x[i], y[i]);
    const float ey = dy[i] - motion.dy(x[i], y[i]);
    return (ex * ex + ey * ey) * information[i] < kOutlier;
  }
  void copy(const Points &from, std::size_t i) {
    x[count] = from.x[i];
    y[count] = from.y[i];
    dx[count] = from.dx[i];
    dy[count] = from.dy[i];
    information[count] = from.information[i];
    ++count;
  }
};

// Symmetric 2x2 matrix.
struct Precision {
  float xx = 0, xy = 0, yy = 0;

  float least_eigenvalue() const {
    return std::max(0.0F, (xx + yy) / 2 - std::sqrt((xx - yy) * (xx - yy) / 4 + xy * xy));
  }
  // (P^-1 + variance I)^-1, which exists for a P of rank 1 too.
  Precision blurred(float variance) const {
    const float determinant = xx * yy - xy * xy;
    const float scale =
        1 / ((1 + variance * xx) * (1 + variance * yy) - variance * xy * variance * xy);
    return {scale * (xx + variance * determinant), scale * xy,
            scale * (yy + variance * determinant)};
  }
};

// What tracking cannot do better than even on noiseless texture (interpolation), px² per component.
constexpr float kTrackingFloor = 0.02F * 0.02F;

Precision precision_of(const GstHapticPatch &patch) {
  const Precision p{patch.precision_xx, patch.precision_xy, patch.precision_yy};
  if (!std::isfinite(p.xx + p.xy + p.yy) || p.xx < 0 || p.yy < 0)
    return {};
  return p;
}

bool is_known(const Precision &p) {
  return p.xx > 0 || p.yy > 0;
}

float information_of(const GstHapticPatch &patch) {
  constexpr float kUnknown = 0.1F * 0.1F; // px²
  constexpr float kBlind = 10.0F * 10.0F; // px², of an edge along which nothing was seen
  const Precision p = precision_of(patch);
  if (!is_known(p))
    return 1 / kUnknown;
  return 1 / (kTrackingFloor + 1 / std::max(p.least_eigenvalue(), 1 / kBlind));
}

// False for a number that is not finite, too.
bool is_usable(const GstHapticPatch &patch) {
  constexpr float kLargest = 1e5F; // px
  return std::abs(patch.x) < kLargest && std::abs(patch.y) < kLargest &&
         std::abs(patch.dx) < kLargest && std::abs(patch.dy) < kLargest;
}

Points points_of(const PatchSet &set) {
  Points points;
  for (const GstHapticPatch &patch : set.patches) {
    if (!is_usable(patch))
      continue;
    points.x[points.count] = patch.x - set.pointer_x;
    points.y[points.count] = patch.y - set.pointer_y;
    points.dx[points.count] = patch.dx;
    points.dy[points.count] = patch.dy;
    points.information[points.count] = information_of(patch);
    ++points.count;
  }
  return points;
}

// By rank: at these numbers comparing each with all is faster than sorting.
float median(Values &values, std::size_t count) {
  for (std::size_t i = count; i % kLanes != 0; ++i)
    values[i] = std::numeric_limits<float>::infinity();
  const std::size_t upper_place = count / 2;
  const std::size_t lower_place = (count - 1) / 2;
  const Lanes upper_rank = static_cast<float>(upper_place);
  const Lanes lower_rank = static_cast<float>(lower_place);
  Lanes lower = -std::numeric_limits<float>::infinity();
  Lanes upper = lower;
  for (std::size_t i = 0; i < count; i += kLanes) {
    const Lanes candidates = values.lanes(i);
    Lanes below = 0;
    Lanes not_above = 0;
    for (std::size_t j = 0; j < count; ++j) {
      const Lanes other = values[j];
      where(other < candidates, below) += 1;
      where(other <= candidates, not_above) += 1;
    }
    where(below <= lower_rank && lower_rank < not_above, lower) = candidates;
    where(below <= upper_rank && upper_rank < not_above, upper) = candidates;
  }
  return (hmax(lower) + hmax(upper)) / 2;
}

Displacement medians(const Points &points) {
  Values dx = points.dx;
  Values dy = points.dy;
  return {median(dx, points.count), median(dy, points.count)};
}

// Weighted moments of the points about their weighted centroid, of what a motion leaves to explain.
struct Moments {
  float weight = 0;
  float x = 0, y = 0, dx = 0, dy = 0; // means, x and y from the pointer
  float xx = 0, xy = 0, yy = 0;       // sums of products
  float x_dx = 0, x_dy = 0, y_dx = 0, y_dy = 0;

  template <typename WeightsOf>
  Moments(const Points &points, const Displacement &at, WeightsOf weights_of) {
    Lanes w_sum = 0, x_sum = 0, y_sum = 0, dx_sum = 0, dy_sum = 0;
    Lanes xx_sum = 0, xy_sum = 0, yy_sum = 0;
    Lanes x_dx_sum = 0, x_dy_sum = 0, y_dx_sum = 0, y_dy_sum = 0;
    for (std::size_t i = 0; i < points.count; i += kLanes) {
      const Lanes px = points.x.lanes(i);
      const Lanes py = points.y.lanes(i);
      const Lanes ex = points.error_x(at, i);
      const Lanes ey = points.error_y(at, i);
      const Lanes w = weights_of(points.information.lanes(i), ex * ex + ey * ey);
      const Lanes wx = w * px;
      const Lanes wy = w * py;
      w_sum += w;
      x_sum += wx;
      y_sum += wy;
      dx_sum += w * ex;
      dy_sum += w * ey;
      xx_sum += wx * px;
      xy_sum += wx * py;
      yy_sum += wy * py;
      x_dx_sum += wx * ex;
      x_dy_sum += wx * ey;
      y_dx_sum += wy * ex;
      y_dy_sum += wy * ey;
    }
    weight = reduce(w_sum);
    if (!(weight > 0))
      return;
    x = reduce(x_sum) / weight;
    y = reduce(y_sum) / weight;
    dx = reduce(dx_sum) / weight;
    dy = reduce(dy_sum) / weight;
    xx = reduce(xx_sum) - weight * x * x;
    xy = reduce(xy_sum) - weight * x * y;
    yy = reduce(yy_sum) - weight * y * y;
    x_dx = reduce(x_dx_sum) - weight * x * dx;
    x_dy = reduce(x_dy_sum) - weight * x * dy;
    y_dx = reduce(y_dx_sum) - weight * y * dx;
    y_dy = reduce(y_dy_sum) - weight * y * dy;
  }

  // The motion that has this gradient and is right at the centroid.
  Displacement with_gradient(float gxx, float gxy, float gyx, float gyy) const {
    return {dx - gxx * x - gxy * y, dy - gyx * x - gyy * y, gxx, gxy, gyx, gyy};
  }
};

// Closed-form weighted least squares; nothing if the points do not determine the model.
std::optional<Displacement> solve(MotionModel model, const Moments &m, std::size_t count) {
  // Points closer together than this say nothing about a gradient, px² (of variance).
  constexpr float kSmallestSpread = 1;

  if (!(m.weight > 0))
    return std::nullopt;
  const float spread = m.xx + m.yy;
  if (model == MotionModel::translation)
    return m.with_gradient(0, 0, 0, 0);
  if (model == MotionModel::similarity) {
    if (count < 3 || !(spread > kSmallestSpread * m.weight))
      return std::nullopt;
    const float grow = (m.x_dx + m.y_dy) / spread;
    const float turn = (m.x_dy - m.y_dx) / spread;
    return m.with_gradient(grow, -turn, turn, grow);
  }
  const float determinant = m.xx * m.yy - m.xy * m.xy;
  // Product over sum of the eigenvalues: about the spread across the longest axis.
  if (count < 4 || !(determinant > kSmallestSpread * m.weight * spread))
    return std::nullopt;
  return m.with_gradient(
      (m.x_dx * m.yy - m.y_dx * m.xy) / determinant, (m.y_dx * m.xx - m.x_dx * m.xy) / determinant,
      (m.x_dy * m.yy - m.y_dy * m.xy) / determinant, (m.y_dy * m.xx - m.x_dy * m.xy) / determinant);
}

// Where a robust fit begins, and how far off (in standard deviations) that may be.
struct Start {
  Displacement motion;
  float sigmas = 1;
};

Start median_start(const Points &points) {
  constexpr float kFarthest = 1e4F;
  const Displacement middle = medians(points);
  Values errors;
  for (std::size_t i = 0; i < points.count; i += kLanes)
    errors.set_lanes(i, points.squared_errors(middle, i));
  return {middle,
          std::clamp(std::sqrt(median(errors, points.count) / kMedianOfChi2), 1.0F, kFarthest)};
}

// Geman-McClure re-weighting, from a scale at which the start can be right down to that of the
// precision, so that a turn does not look like outliers; at last only what agrees counts.
std::optional<Displacement> robust_fit(MotionModel model, const Points &points,
                                       const Start &start) {
  constexpr float kNarrowing = 3;
  constexpr int kPassesAtPrecision = 2;
  Displacement motion = start.motion;
  float sigmas = start.sigmas;
  for (int left = kPassesAtPrecision; left > 0; sigmas = std::max(1.0F, sigmas / kNarrowing)) {
    left -= sigmas <= 1;
    const float per_scale = 1 / (9 * sigmas * sigmas);
    const Moments moments(points, motion, [=](const Lanes &information, const Lanes &squares) {
      const Lanes root = 1 / (1 + squares * information * per_scale);
      return information * root * root;
    });
    const auto step = solve(model, moments, points.count);
    if (!step)
      return std::nullopt;
    motion = motion + *step;
  }
  const Moments agreeing(points, motion, [](const Lanes &information, const Lanes &squares) {
    Lanes weights = information;
    where(squares * information >= kOutlier, weights) = 0;
    return weights;
  });
  if (const auto step = solve(model, agreeing, points.count))
    motion = motion + *step;
  return motion;
}

struct Fit {
  Displacement motion;
  MotionModel model = MotionModel::none;
  float cost = 0;            // robust information criterion; the smaller the better
  std::size_t explained = 0; // points
};

std::size_t parameters(MotionModel model) {
  return 2 * (static_cast<std::size_t>(model) - static_cast<std::size_t>(MotionModel::still));
}

// What the parameters of a model cost. Four: the numbers that a pair of places has.
float price(MotionModel model, const Points &points) {
  return static_cast<float>(parameters(model)) * std::log(4 * static_cast<float>(points.count));
}

Fit judged(MotionModel model, const Displacement &motion, const Points &points) {
  Lanes cost = 0;
  std::size_t explained = 0;
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    const Lanes errors = points.squared_errors(motion, i);
    cost += min(errors, Lanes(kOutlier));
    explained += static_cast<std::size_t>(popcount(errors < kOutlier));
  }
  return {motion, model, price(model, points) + reduce(cost), explained - points.padding()};
}

bool explains_most(const Fit &fit, const Points &points) {
  return static_cast<double>(fit.explained) >= 0.6 * static_cast<double>(points.count);
}

struct Selection {
  Fit fit;
  ModelHistory history;
};

// One picture is not enough to change a model that explains nearly as much as the best.
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
  const auto consider = [&](MotionModel model, const Displacement &motion) {
    const Fit fit = judged(model, motion, points);
    if (model == history.current)
      current = fit;
    if (!best || fit.cost < best->cost)
      best = fit;
  };

  if (smallest == MotionModel::still)
    consider(MotionModel::still, {});
  std::optional<Start> start;
  for (const MotionModel model :
       {MotionModel::translation, MotionModel::similarity, MotionModel::affine}) {
    // Its parameters alone cost more than the best model with all its errors.
    if (best && best->cost <= price(model, points) && model > history.current)
      break;
    if (model > MotionModel::translation && points.count < parameters(model) / 2 + 2)
      break;
    if (!start)
      start = median_start(points);
    if (const auto motion = robust_fit(model, points, *start))
      consider(model, *motion);
  }
  return settled(*best, current, history);
}

// The displacement that most others share, for when no median is near any of them.
Start commonest(const Points &points) {
  int most = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < points.count; ++i) {
    const Displacement motion{points.dx[i], points.dy[i]};
    int near = 0;
    for (std::size_t j = 0; j < points.count; j += kLanes)
      near += popcount(points.squared_errors(motion, j) < 2 * kOutlier);
    if (near > most) {
      most = near;
      at = i;
    }
  }
  return {{points.dx[at], points.dy[at]}, 1};
}

Fit commonest_translation(const Points &points) {
  const Start start = commonest(points);
  const auto motion = robust_fit(MotionModel::translation, points, start);
  return judged(MotionModel::translation, motion.value_or(start.motion), points);
}

// A second motion among the points that the first does not explain.
std::optional<Displacement> second_motion(const Points &points, const Displacement &first) {
  constexpr double kEnough = 0.12;
  Points others;
  for (std::size_t i = 0; i < points.count; ++i)
    if (!points.is_explained(first, i))
      others.copy(points, i);
  if (others.count < kSmallestLayer ||
      static_cast<double>(others.count) < kEnough * static_cast<double>(points.count))
    return std::nullopt;
  const Fit fit = commonest_translation(others);
  if (fit.explained < kSmallestLayer || !explains_most(fit, others))
    return std::nullopt;
  return fit.motion;
}

struct Box {
  float x = 0, y = 0, width = 0, height = 0;
};

Box region_of(const PatchSet &set, const Points &points) {
  if (set.region_width > 0 && set.region_height > 0)
    return {set.region_x - set.pointer_x, set.region_y - set.pointer_y, set.region_width,
            set.region_height};
  const auto end = static_cast<std::ptrdiff_t>(points.count);
  const auto [left, right] = std::minmax_element(points.x.begin(), points.x.begin() + end);
  const auto [top, bottom] = std::minmax_element(points.y.begin(), points.y.begin() + end);
  return {*left, *top, *right - *left, *bottom - *top};
}

// The mean over the region: each place moves like the point nearest to it, and points that belong
// to neither motion say nothing.
Displacement mean_by_area(const Points &points, const Box &region, const Displacement &first,
                          const Displacement &second) {
  Points layered;
  std::array<bool, kCapacity> is_second;
  for (std::size_t i = 0; i < points.count; ++i) {
    const bool in_first = points.is_explained(first, i);
    if (!in_first && !points.is_explained(second, i))
      continue;
    is_second[layered.count] = !in_first;
    layered.copy(points, i);
  }

  // Golden-section lattice: even along both axes, and finer than any raster of as many places.
  constexpr int kPlaces = 233;
  constexpr float kGoldenStep = 144.0F / kPlaces;
  Displacement mean;
  for (int place = 0; place < kPlaces; ++place) {
    const float along = static_cast<float>(place) * kGoldenStep;
    const float x = region.x + region.width * (along - std::floor(along) + 0.5F / kPlaces);
    const float y = region.y + region.height * (static_cast<float>(place) + 0.5F) / kPlaces;
    std::size_t nearest = 0;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < layered.count; ++i) {
      const float away_x = layered.x[i] - x;
      const float away_y = layered.y[i] - y;
      const float distance = away_x * away_x + away_y * away_y;
      if (distance < least) {
        least = distance;
        nearest = i;
      }
    }
    const Displacement &motion = is_second[nearest] ? second : first;
    mean.x0 += motion.dx(x, y) / kPlaces;
    mean.y0 += motion.dy(x, y) / kPlaces;
    mean.xx += motion.xx / kPlaces;
    mean.xy += motion.xy / kPlaces;
    mean.yx += motion.yx / kPlaces;
    mean.yy += motion.yy / kPlaces;
  }
  return mean;
}

// How far the points are from moving as one, px² per component.
float scatter_of(const Points &points) {
  const Displacement middle = medians(points);
  Values errors;
  for (std::size_t i = 0; i < points.count; i += kLanes) {
    const Lanes ex = points.error_x(middle, i);
    const Lanes ey = points.error_y(middle, i);
    errors.set_lanes(i, ex * ex + ey * ey);
  }
  return median(errors, points.count) / kMedianOfChi2;
}

void blur(Points &points, float variance) {
  for (std::size_t i = 0; i < points.count; ++i)
    points.information[i] = 1 / (1 / points.information[i] + variance);
}

struct Answer {
  Displacement motion;                // what to feel
  Displacement first;                 // what the points do
  std::optional<Displacement> second; // what the others do, in a mixture
  MotionModel model = MotionModel::translation;
  float scatter = 0; // px² per component that no model explains
  ModelHistory history;
};

Answer answer_of(const Selection &selection) {
  const Fit &fit = selection.fit;
  return {fit.motion, fit.motion, std::nullopt, fit.model, 0, selection.history};
}

Answer explain(const PatchSet &set, Points &points, ModelHistory history) {
  Answer answer;
  Selection selection = select_model(points, MotionModel::still, history);
  if (!explains_most(selection.fit, points)) {
    const Fit common = commonest_translation(points);
    if (common.explained >= kSmallestLayer && common.cost < selection.fit.cost)
      selection = {common, {MotionModel::translation, MotionModel::none}};
  }
  answer = answer_of(selection);
  answer.second = second_motion(points, answer.first);
  if (answer.second) {
    answer.motion = mean_by_area(points, region_of(set, points), answer.first, *answer.second);
    return answer;
  }
  if (explains_most(selection.fit, points))
    return answer;

  // No motion model, no layers: leaves, water. They move, so static is out; the others are judged
  // by how much of the scatter they explain.
  const float scatter = scatter_of(points);
  blur(points, scatter);
  answer = answer_of(select_model(points, MotionModel::translation, history));
  answer.scatter = scatter;
  return answer;
}

// The model that was asked for, or the largest below it that the points determine.
Answer fit_model(MotionModel largest, Points &points) {
  constexpr MotionModel kModels[] = {MotionModel::affine, MotionModel::similarity,
                                     MotionModel::translation};
  Answer answer;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const Start start = median_start(points);
    answer.motion = start.motion;
    for (const MotionModel model : kModels)
      if (model <= largest)
        if (const auto motion = robust_fit(model, points, start)) {
          answer.motion = *motion;
          answer.model = model;
          break;
        }
    if (attempt > 0 || explains_most(judged(answer.model, answer.motion, points), points))
      break;
    answer.scatter = scatter_of(points);
    blur(points, answer.scatter);
  }
  answer.first = answer.motion;
  return answer;
}

Displacement mean(const Points &points) {
  Displacement sum;
  for (std::size_t i = 0; i < points.count; ++i) {
    sum.x0 += points.dx[i];
    sum.y0 += points.dy[i];
  }
  const auto count = static_cast<float>(points.count);
  return {sum.x0 / count, sum.y0 / count};
}

Answer average_of(const PatchSet &set, Points &points, Average average, ModelChoice choice,
                  ModelHistory history) {
  if (average == Average::model) {
    if (choice == ModelChoice::automatic)
      return explain(set, points, history);
    return fit_model(choice == ModelChoice::affine       ? MotionModel::affine
                     : choice == ModelChoice::similarity ? MotionModel::similarity
                                                         : MotionModel::translation,
                     points);
  }
  Answer answer;
  answer.motion = average == Average::median ? medians(points) : mean(points);
  answer.first = answer.motion;
  return answer;
}

// Falls from 1 to 0 as the value goes from `good` to `bad`.
double fade(double value, double good, double bad) {
  return std::clamp((value - bad) / (good - bad), 0.0, 1.0);
}

// Leaves of one branch do not move as one; what differs by more is another object.
bool agrees(const GstHapticPatch &patch, const Displacement &motion, const PatchSet &set) {
  constexpr float kAlways = 1; // px
  constexpr float kOfDisplacement = 0.25F;
  const float x = patch.x - set.pointer_x;
  const float y = patch.y - set.pointer_y;
  const float ex = patch.dx - motion.dx(x, y);
  const float ey = patch.dy - motion.dy(x, y);
  const float limit =
      kAlways + kOfDisplacement * std::sqrt(motion.x0 * motion.x0 + motion.y0 * motion.y0);
  return ex * ex + ey * ey <= limit * limit;
}

// Standard deviation of the velocity along its worse direction, px; by number where no patch knows
// its precision: one is a third of enough.
double enough(const Precision &total, int agreeing) {
  constexpr double kGood = 0.1; // px
  constexpr double kBad = 0.5;
  if (!is_known(total))
    return fade(agreeing, 3, 0);
  return fade(1 / std::sqrt(total.least_eigenvalue()), kGood, kBad);
}

// Three doubts multiplied: do the patches agree, do they determine the velocity, do the pictures
// match?
void set_confidence(VelocityEstimate &estimate, const Answer &answer, const PatchSet &set) {
  double residual = 0;
  int finite = 0;
  Precision total;
  for (const GstHapticPatch &patch : set.patches) {
    if (!is_usable(patch))
      continue;
    ++finite;
    residual += patch.residual;
    if (!agrees(patch, answer.first, set) && !(answer.second && agrees(patch, *answer.second, set)))
      continue;
    ++estimate.points;
    const Precision p = precision_of(patch).blurred(kTrackingFloor + answer.scatter);
    total = {total.xx + p.xx, total.xy + p.xy, total.yy + p.yy};
  }
  residual /= finite;
  const double share =
      static_cast<double>(estimate.points) / std::max({set.candidates, estimate.points, 1});
  estimate.confidence = static_cast<float>(fade(share, 0.6, 0.2) * enough(total, estimate.points) *
                                           fade(residual, 15, 45));
}

// Time stamps a hair apart make any displacement a speed that no picture shows. False for a number
// that is not finite.
bool is_plausible(const VelocityEstimate &e) {
  constexpr float kFastest = 1e6F; // px/s
  return std::hypot(e.velocity_x, e.velocity_y) < kFastest && std::isfinite(e.spin) &&
         std::isfinite(e.divergence) && e.confidence > 0;
}

} // namespace

VelocityEstimate estimate_velocity(const PatchSet &set, Average average, ModelChoice choice,
                                   ModelHistory history) {
  if (set.patches.empty() || set.patches.size() > kCapacity || !(set.interval > 0))
    return {};

  if (average == Average::model && choice == ModelChoice::still)
    return {.confidence = 1,
            .points = static_cast<int>(set.patches.size()),
            .model = MotionModel::still};

  Points points = points_of(set);
  if (points.count == 0)
    return {};
  const Answer answer = average_of(set, points, average, choice, history);

  const Displacement &motion = answer.motion;
  VelocityEstimate estimate;
  set_confidence(estimate, answer, set);
  estimate.velocity_x = static_cast<float>(motion.x0 / set.interval);
  estimate.velocity_y = static_cast<float>(motion.y0 / set.interval);
  estimate.spin = static_cast<float>((motion.yx - motion.xy) / (2 * set.interval));
  estimate.divergence = static_cast<float>((motion.xx + motion.yy) / (2 * set.interval));
  estimate.model = answer.model;
  estimate.mixture = answer.second.has_value();
  estimate.history = answer.history;
  if (!is_plausible(estimate))
    return {};
  return estimate;
}

} // namespace haptic
