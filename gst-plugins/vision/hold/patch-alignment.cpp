// SPDX-License-Identifier: LGPL-2.1-or-later
#include "hold/patch-alignment.hpp"

#include "hold/patch-kernels.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>

namespace haptic {
namespace {

constexpr float kPlain = 2;        // grey levels squared: less is no texture
constexpr float kLeastGain = 0.6F; // of an illumination that changes
constexpr float kMostGain = 1.6F;
constexpr float kLeastScale = 1.2F;              // grey levels, of errors: rounding and noise
constexpr float kLeastVariance = 1;              // grey levels squared, of errors
constexpr float kMostTurn = 0.08F;               // of scale and angle in one iteration
constexpr float kMostStep = kPatchRadius / 4.0F; // samples
// Neighbouring samples share their noise, because the planes are smoothed and coded in blocks.
constexpr float kSharedNoise = 4;

struct Correction {
  Eigen::Vector4f parameters = Eigen::Vector4f::Zero(); // x, y, scale, angle
  float variance = 0;                                   // samples squared, of x and y together
};

std::optional<Correction> solve(const NormalEquations &sums, float similarity) {
  const float error = std::max(sums.squares / std::max(sums.weight, 1e-6F), kLeastVariance);
  Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
  const int size = similarity > 0 ? 4 : 2;
  std::size_t k = 0;
  for (int i = 0; i < size; ++i)
    for (int j = 0; j <= i; ++j, ++k)
      matrix(i, j) = matrix(j, i) = sums.matrix[k];
  const float trace = matrix(0, 0) + matrix(1, 1);
  const float determinant = matrix(0, 0) * matrix(1, 1) - matrix(0, 1) * matrix(0, 1);
  if (!(determinant > 1e-6F))
    return std::nullopt;
  Correction correction{.variance = kSharedNoise * error * trace / determinant};
  for (int i = 2; i < size; ++i)
    matrix(i, i) += kSharedNoise * error / (similarity * similarity);
  const float ridge = 1e-3F * trace + 1;
  matrix(0, 0) += ridge;
  matrix(1, 1) += ridge;
  const Eigen::LLT<Eigen::Matrix4f> factors(matrix);
  if (factors.info() != Eigen::Success)
    return std::nullopt;
  const auto &right = sums.right;
  correction.parameters = factors.solve(
      Eigen::Vector4f(right[0], right[1], size > 2 ? right[2] : 0, size > 2 ? right[3] : 0));
  return correction;
}

// The step of inverse composition: the pose after the inverse of the correction. Returns its
// length.
float compose(PatchPose &pose, const Correction &correction, float unit) {
  const float turn = std::clamp(correction.parameters[2], -kMostTurn, kMostTurn);
  const float angle = std::clamp(correction.parameters[3], -kMostTurn, kMostTurn);
  const float determinant = (1 + turn) * (1 + turn) + angle * angle;
  const float along = (1 + turn) / determinant;
  const float across = angle / determinant;
  PatchPose next = pose;
  next.a = pose.a * along - pose.b * across;
  next.b = pose.a * across + pose.b * along;
  next.c = pose.c * along - pose.d * across;
  next.d = pose.c * across + pose.d * along;
  float x = correction.parameters[0];
  float y = correction.parameters[1];
  float length = std::hypot(x, y);
  if (length > kMostStep) {
    x *= kMostStep / length;
    y *= kMostStep / length;
    length = kMostStep;
  }
  next.x -= (next.a * x + next.b * y) * unit;
  next.y -= (next.c * x + next.d * y) * unit;
  pose = next;
  return length;
}

bool is_sane(const PatchPose &pose) {
  constexpr float kSmallest = 0.1F; // of the area that was taken
  constexpr float kLargest = 9;
  return std::abs(pose.area()) > kSmallest && std::abs(pose.area()) < kLargest;
}

} // namespace

std::optional<PatchAlignment>
PatchAligner::align(const LumaLayer &layer, const PatchTemplate &patch, const PatchSamples &weights,
                    const PatchPose &start, const AlignmentOptions &options) {
  PatchAlignment found{.pose = start};
  for (int i = 0; i < options.iterations; ++i) {
    if (!layer.sample(found.pose, now_))
      return std::nullopt;
    const PatchMoments moments = compare_patches(weights, now_, patch.grey);
    if (moments.variance_b < kPlain)
      return std::nullopt;
    found.correlation =
        moments.covariance / std::sqrt(moments.variance_a * moments.variance_b + 1e-6F);
    const float gain = std::clamp(std::sqrt(moments.variance_b / (moments.variance_a + 1e-3F)),
                                  kLeastGain, kMostGain);
    const float amount = subtract_patches(weights, now_, patch.grey, gain,
                                          moments.mean_b - gain * moments.mean_a, errors_);
    const SmallErrors small =
        sum_small_errors(weights, errors_, 1.5F * amount / moments.weight + 1e-6F);
    found.error_scale = std::max(kLeastScale, 2 * small.amount / (small.weight + 1e-6F));
    const NormalEquations sums = sum_normal_equations(
        patch, errors_, weights, 2.5F * found.error_scale, options.similarity > 0);
    const std::optional<Correction> correction = solve(sums, options.similarity);
    if (!correction)
      return std::nullopt;
    found.variance = correction->variance * layer.unit * layer.unit;
    found.step = compose(found.pose, *correction, layer.unit);
    if (!is_sane(found.pose))
      return std::nullopt;
    if (found.step < options.enough && i > 0)
      break;
  }
  return found;
}

} // namespace haptic
