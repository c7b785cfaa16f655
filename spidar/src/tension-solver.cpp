// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/tension-solver.hpp"

#include "string-kinematics.hpp"

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

} // namespace

TensionSolver::TensionSolver(const Geometry &geometry)
    : geometry_(geometry), tensions_(Tensions::Constant(geometry.tension_min)) {
  active_.fill(-1);
}

TensionSolver::Result TensionSolver::solve(const Wrench &wrench, const Pose &pose) noexcept {
  const double lower = geometry_.tension_min;
  const double upper = geometry_.tension_max;
  if (!finite(wrench, pose)) {
    tensions_.setConstant(lower);
    active_.fill(-1);
    const Pose known = finite({}, pose) ? pose : Pose{};
    return {tensions_, realised_wrench(string_kinematics(geometry_, known).pull, tensions_), false,
            0};
  }

  const WrenchMatrix pull = string_kinematics(geometry_, pose).pull;
  Vector6 wanted;
  wanted << wrench.force, wrench.torque / geometry_.grip_radius;
  const double largest = wanted.cwiseAbs().maxCoeff();
  if (largest > kLargestComponent)
    wanted *= kLargestComponent / largest;
  WrenchMatrix weighted = pull;
  weighted.bottomRows<3>() *= std::sqrt(kTorqueWeight) / geometry_.grip_radius;
  wanted.tail<3>() *= std::sqrt(kTorqueWeight);
  Matrix8 hessian = weighted.transpose() * weighted;
  hessian.diagonal().array() += kTensionWeight;
  Tensions gradient = weighted.transpose() * wanted;
  gradient.array() += kTensionWeight * lower;

  FreeBlock block;
  int iterations = 0;
  while (iterations < kMostPivots) {
    ++iterations;
    block.solve(hessian, gradient, tensions_, active_);

    double share = 1; // of the way to the optimum of the free block, up to the first limit
    std::size_t blocking = kStrings;
    signed char side = 0;
    for (std::size_t k = 0; k < block.size; ++k) {
      const std::size_t i = block.index[k];
      const double target = block.optimum[k];
      if (target >= lower && target <= upper)
        continue;
      const double limit = target < lower ? lower : upper;
      const double reach = (limit - tensions_[i]) / (target - tensions_[i]);
      if (reach < share) {
        share = reach;
        blocking = i;
        side = target < lower ? -1 : 1;
      }
    }
    for (std::size_t k = 0; k < block.size; ++k) {
      const std::size_t i = block.index[k];
      const double target = blocking == kStrings
                                ? block.optimum[k]
                                : tensions_[i] + share * (block.optimum[k] - tensions_[i]);
      tensions_[i] = std::clamp(target, lower, upper); // rounding must not cross a limit
    }
    if (blocking != kStrings) {
      tensions_[blocking] = side < 0 ? lower : upper;
      active_[blocking] = side;
      continue;
    }

    double worst = kMultiplierSlack;
    std::size_t release = kStrings;
    for (std::size_t i = 0; i < kStrings; ++i) {
      if (active_[i] == 0)
        continue;
      const double wish = active_[i] * (hessian.col(i).dot(tensions_) - gradient[i]);
      if (wish <= worst)
        continue;
      release = i;
      if (iterations > kSmallestIndexAfter)
        break;
      worst = wish;
    }
    if (release == kStrings)
      break;
    active_[release] = 0;
  }

  const Wrench realised = realised_wrench(pull, tensions_);
  return {tensions_, realised, (realised.force - wrench.force).norm() <= kFeasible, iterations};
}

} // namespace spidar
