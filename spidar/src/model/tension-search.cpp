// SPDX-License-Identifier: LGPL-2.1-or-later
#include "model/tension-search.hpp"

#include <cmath>

namespace spidar {

namespace {

constexpr double kLargestComponent = 1e4;  // N or N at the grip radius; far beyond any device
constexpr double kMultiplierSlack = 1e-11; // N, below which a bound counts as wanted
constexpr int kMostPivots = 40;
constexpr int kSmallestIndexAfter = 20; // pivots: ends cycling (Bland)

/// minimise 1/2 t'Ht - g't over the free tensions, the others as they are.
struct FreeBlock {
  std::array<std::size_t, kStrings> index{};
  std::size_t size = 0;
  std::array<double, kStrings> optimum{};

  void solve(const TensionProblem::Matrix8 &hessian, const Tensions &gradient,
             const Tensions &tensions, const ActiveSet &active) noexcept {
    size = 0;
    for (std::size_t i = 0; i < kStrings; ++i)
      if (active[i] == 0)
        index[size++] = i;

    // Cholesky without square roots, L D L': one division per row instead of one per element.
    using Row = std::array<double, kStrings>;
    std::array<Row, kStrings> factor; // L below the diagonal
    Row inverse;                      // of D
    for (std::size_t row = 0; row < size; ++row) {
      const std::size_t i = index[row];
      double right = gradient[i];
      for (std::size_t j = 0; j < kStrings; ++j)
        if (active[j] != 0)
          right -= hessian(j, i) * tensions[j];
      Row scaled; // this row of L times D
      double pivot = hessian(i, i);
      for (std::size_t column = 0; column < row; ++column) {
        double sum = hessian(index[column], i);
        for (std::size_t k = 0; k < column; ++k)
          sum -= scaled[k] * factor[column][k];
        scaled[column] = sum;
        factor[row][column] = sum * inverse[column];
        pivot -= sum * factor[row][column];
        right -= factor[row][column] * optimum[column];
      }
      // The tension weight keeps the pivot positive whatever the pose.
      inverse[row] = 1 / std::max(pivot, 0.5 * TensionProblem::kTensionWeight);
      optimum[row] = right;
    }
    for (std::size_t row = size; row-- > 0;) {
      optimum[row] *= inverse[row];
      for (std::size_t k = row + 1; k < size; ++k)
        optimum[row] -= factor[k][row] * optimum[k];
    }
  }
};

/// Moves the free tensions to their optimum, or to the first limit on the way, which becomes
/// active. True if no limit was met.
bool move_to_optimum(const TensionProblem &problem, const FreeBlock &block, Tensions &tensions,
                     ActiveSet &active) noexcept {
  double share = 1; // of the way
  std::size_t blocking = kStrings;
  for (std::size_t k = 0; k < block.size; ++k) {
    const std::size_t i = block.index[k];
    const double target = block.optimum[k];
    if (target >= problem.lower && target <= problem.upper)
      continue;
    const double limit = target < problem.lower ? problem.lower : problem.upper;
    const double reach = (limit - tensions[i]) / (target - tensions[i]);
    if (reach < share) {
      share = reach;
      blocking = i;
    }
  }
  const bool free = blocking == kStrings;
  for (std::size_t k = 0; k < block.size; ++k) {
    const std::size_t i = block.index[k];
    const double target = block.optimum[k];
    if (i == blocking)
      active[i] = target < problem.lower ? -1 : 1;
    const double there = free ? target : tensions[i] + share * (target - tensions[i]);
    tensions[i] = std::clamp(there, problem.lower, problem.upper); // rounding crosses no limit
  }
  if (!free)
    tensions[blocking] = active[blocking] < 0 ? problem.lower : problem.upper;
  return free;
}

/// Frees the tension whose limit costs most; after many iterations the first one that costs, which
/// ends cycling (Bland's rule). True if there is none: the optimum is reached.
bool release_limit(const TensionProblem &problem, const Tensions &tensions, ActiveSet &active,
                   int iterations) noexcept {
  double worst = kMultiplierSlack;
  std::size_t release = kStrings;
  for (std::size_t i = 0; i < kStrings; ++i) {
    if (active[i] == 0)
      continue;
    const double multiplier =
        active[i] * (problem.hessian.col(i).dot(tensions) - problem.gradient[i]);
    if (multiplier <= worst)
      continue;
    release = i;
    if (iterations > kSmallestIndexAfter)
      break;
    worst = multiplier;
  }
  if (release == kStrings)
    return true;
  active[release] = 0;
  return false;
}

} // namespace

TensionProblem::TensionProblem(const Geometry &geometry, const WrenchMatrix &pull) noexcept
    : weighted(pull), grip_radius(geometry.grip_radius), lower(geometry.tension_min),
      upper(geometry.tension_max) {
  weighted.bottomRows<3>() *= std::sqrt(kTorqueWeight) / grip_radius;
  hessian = weighted.transpose().lazyProduct(weighted);
  hessian.diagonal().array() += kTensionWeight;
}

void TensionProblem::want(const Wrench &wrench) noexcept {
  Vector6 wanted;
  wanted.head<3>() = wrench.force;
  wanted.tail<3>() = wrench.torque / grip_radius;
  const double largest = wanted.cwiseAbs().maxCoeff();
  if (largest > kLargestComponent)
    wanted *= kLargestComponent / largest;
  wanted.tail<3>() *= std::sqrt(kTorqueWeight);
  gradient = weighted.transpose() * wanted;
  gradient.array() += kTensionWeight * lower;
}

int find_tensions(const TensionProblem &problem, Tensions &tensions, ActiveSet &active) noexcept {
  FreeBlock block;
  int iterations = 0;
  for (bool done = false; !done && iterations < kMostPivots;) {
    ++iterations;
    block.solve(problem.hessian, problem.gradient, tensions, active);
    done = move_to_optimum(problem, block, tensions, active) &&
           release_limit(problem, tensions, active, iterations);
  }
  return iterations;
}

} // namespace spidar
