// SPDX-License-Identifier: LGPL-2.1-or-later
#include "model/wrench-closure.hpp"

#include <Eigen/QR>
#include <vector>

namespace spidar {

namespace {

/// What remains of `wanted` after the best non-negative combination of the columns of `pull`
/// (Lawson and Hanson). The remainder is itself a direction along which no column pulls.
Vector6 out_of_reach(const WrenchMatrix &pull, const Vector6 &wanted) {
  constexpr double kNothing = 1e-10;
  constexpr int kMostRounds = 200; // 2^8 sets at most; a handful is usual
  std::vector<Eigen::Index> used;
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(kStrings);
  Vector6 rest = wanted;
  for (int round = 0; round < kMostRounds; ++round) {
    Eigen::Index next = 0;
    Eigen::VectorXd gain = pull.transpose() * rest;
    for (const Eigen::Index i : used)
      gain[i] = 0;
    if (gain.maxCoeff(&next) <= kNothing)
      break;
    used.push_back(next);
    for (;;) {
      const Eigen::MatrixXd columns = pull(Eigen::all, used);
      const Eigen::VectorXd best = columns.completeOrthogonalDecomposition().solve(wanted);
      if (best.minCoeff() > 0) {
        weights.setZero();
        for (std::size_t k = 0; k < used.size(); ++k)
          weights[used[k]] = best[static_cast<Eigen::Index>(k)];
        break;
      }
      double share = 1;
      for (std::size_t k = 0; k < used.size(); ++k) {
        const double from = weights[used[k]];
        const double to = best[static_cast<Eigen::Index>(k)];
        if (to <= 0)
          share = std::min(share, from / (from - to));
      }
      std::vector<Eigen::Index> kept;
      for (std::size_t k = 0; k < used.size(); ++k) {
        double &weight = weights[used[k]];
        weight += share * (best[static_cast<Eigen::Index>(k)] - weight);
        if (weight > kNothing)
          kept.push_back(used[k]);
        else
          weight = 0;
      }
      used = kept;
      if (used.empty())
        break;
    }
    rest = wanted - pull * weights;
  }
  return rest;
}

} // namespace

std::string directions_out_of_reach(const WrenchMatrix &pull) {
  static constexpr const char *kNames[] = {"pull along +x", "pull along -x", "pull along +y",
                                           "pull along -y", "pull along +z", "pull along -z",
                                           "turn about +x", "turn about -x", "turn about +y",
                                           "turn about -y", "turn about +z", "turn about -z"};
  // A direction against which every string pulls makes others impossible, since they cannot be
  // had without it; then only the culprit is worth naming.
  constexpr double kReached = 1e-6;
  std::string culprits;
  std::string all;
  for (std::size_t direction = 0; direction < std::size(kNames); ++direction) {
    Vector6 wanted = Vector6::Zero();
    wanted[static_cast<Eigen::Index>(direction / 2)] = direction % 2 == 0 ? 1 : -1;
    const double rest = out_of_reach(pull, wanted).norm();
    const auto append = [&](std::string &list) {
      list += (list.empty() ? "" : ", ") + std::string(kNames[direction]);
    };
    if (rest > kReached)
      append(all);
    if (rest > 1 - kReached)
      append(culprits);
  }
  return culprits.empty() ? all : culprits;
}

} // namespace spidar
