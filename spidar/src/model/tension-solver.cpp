// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/tension-solver.hpp"

#include "model/string-kinematics.hpp"

#include <cmath>

namespace spidar {

namespace {

using Matrix8 = Eigen::Matrix<double, kStrings, kStrings>;

// Away from the centre eight strings with minimum tension cannot give every wrench. Torque, in
// units of the grip radius, gives way first, and the smallest tensions are chosen among those that
// do. With this weight forces up to 1 N keep within 10 mN also in the corners of a workspace of
// +-25 mm with the grip tilted by 20 degrees; with 1e-3 they miss by up to 17 mN there.
constexpr double kTorqueWeight = 4e-4;
constexpr double kTensionWeight = 1e-4;
constexpr double kFeasible = 0.01;         // N
constexpr double kLargestComponent = 1e4;  // N or N at the grip radius; far beyond any device
constexpr double kMultiplierSlack = 1e-11; // N, below which a bound counts as wanted
constexpr int kMostPivots = 40;
constexpr int kSmallestIndexAfter = 20; // pivots: ends cycling (Bland)

/// minimise 1/2 t'Ht - g't over the free tensions, the others as they are.
struct FreeBlock {
  std::array<std::size_t, kStrings> index{};
  std::size_t size = 0;
  std::array<double, kStrings> optimum{};

  void solve(const Matrix8 &hessian, const Tensions &gradient, const Tensions &tensions,
             const std::array<signed char, kStrings> &active) noexcept {
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
      inverse[row] = 1 / std::max(pivot, 0.5 * kTensionWeight);
      optimum[row] = right;
    }
    for (std::size_t row = size; row-- > 0;) {
      optimum[row] *= inverse[row];
      for (std::size_t k = row + 1; k < size; ++k)
        optimum[row] -= factor[k][row] * optimum[k];
    }
  }
};

bool finite(const Wrench &wrench, const Pose &pose) noexcept {
  return wrench.force.allFinite() && wrench.torque.allFinite() && pose.position.allFinite() &&
         pose.rotation.allFinite();
}

/// Minimise |W^1/2 (A t - w)|² + eps |t - t_min|²: half of it is 1/2 t'Ht - g't and a constant,
/// with H = A'WA + eps I and g = A'Ww + eps t_min. A: wrench of each string per newton, torques in
/// units of the grip radius; W: 1 for forces, kTorqueWeight for torques; eps: kTensionWeight.
struct Problem {
  Matrix8 hessian;
  Tensions gradient;
  double lower; ///< N
  double upper; ///< N

  Problem(const Geometry &geometry, const WrenchMatrix &pull, const Wrench &wrench) noexcept
      : lower(geometry.tension_min), upper(geometry.tension_max) {
    Vector6 wanted;
    wanted << wrench.force, wrench.torque / geometry.grip_radius;
    const double largest = wanted.cwiseAbs().maxCoeff();
    if (largest > kLargestComponent)
      wanted *= kLargestComponent / largest;
    WrenchMatrix weighted = pull;
    weighted.bottomRows<3>() *= std::sqrt(kTorqueWeight) / geometry.grip_radius;
    wanted.tail<3>() *= std::sqrt(kTorqueWeight);
    hessian = weighted.transpose().lazyProduct(weighted);
    hessian.diagonal().array() += kTensionWeight;
    gradient = weighted.transpose() * wanted;
    gradient.array() += kTensionWeight * lower;
  }
};

using ActiveSet = std::array<signed char, kStrings>; ///< -1 at the lower limit, +1 at the upper

/// Moves the free tensions to their optimum, or to the first limit on the way, which becomes
/// active. True if no limit was met.
bool move_to_optimum(const Problem &problem, const FreeBlock &block, Tensions &tensions,
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
bool release_limit(const Problem &problem, const Tensions &tensions, ActiveSet &active,
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

TensionSolver::TensionSolver(const Geometry &geometry)
    : geometry_(geometry), tensions_(Tensions::Constant(geometry.tension_min)) {
  active_.fill(-1);
}

TensionSolver::Result TensionSolver::solve(const Wrench &wrench, const Pose &pose) noexcept {
  if (!finite(wrench, pose)) {
    tensions_.setConstant(geometry_.tension_min);
    active_.fill(-1);
    const Pose known = finite({}, pose) ? pose : Pose{};
    return {tensions_, realised_wrench(string_kinematics(geometry_, known).pull, tensions_), false,
            0};
  }
  const WrenchMatrix pull = string_kinematics(geometry_, pose).pull;
  const Problem problem(geometry_, pull, wrench);
  FreeBlock block;
  int iterations = 0;
  for (bool done = false; !done && iterations < kMostPivots;) {
    ++iterations;
    block.solve(problem.hessian, problem.gradient, tensions_, active_);
    done = move_to_optimum(problem, block, tensions_, active_) &&
           release_limit(problem, tensions_, active_, iterations);
  }
  const Wrench realised = realised_wrench(pull, tensions_);
  return {tensions_, realised, (realised.force - wrench.force).norm() <= kFeasible, iterations};
}

} // namespace spidar
