// SPDX-License-Identifier: LGPL-2.1-or-later
// Statistics of the charts from single measurements.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lab {

/// Linear between the ranks; `fraction` 0..1. 0 of nothing.
double percentile(std::vector<double> values, double fraction);

double mean(std::span<const double> values);

struct Interval {
  double low;
  double high;
};

/// 95 % bootstrap interval of the mean. Values of one block are drawn together, because
/// neighbouring regions of one frame are not independent. Same result on every machine.
Interval bootstrap(std::span<const double> values, std::span<const int> blocks, std::uint64_t seed);

/// 95 % interval of a share, of which `good` of `all` were seen (Wilson, J. Am. Stat. Assoc. 22,
/// 1927). `all` > 0.
Interval wilson(std::size_t good, std::size_t all);

struct SpeedAndError {
  double time;
  double error;
};

/// Whether `a` is at least as good as `b` in both and better in one.
bool dominates(const SpeedAndError &a, const SpeedAndError &b);

/// For each point, whether no other dominates it.
std::vector<bool> pareto_front(std::span<const SpeedAndError> all);

struct RocPoint {
  double threshold;
  double false_alarms; ///< share of the good answers that fall below the threshold
  double detections;   ///< share of the bad answers that fall below it
};

/// ROC curve of low confidence as a detector of bad answers, from (0, 0) to (1, 1).
std::vector<RocPoint> roc(std::span<const double> confidences, const std::vector<bool> &bad);

/// Area under the curve, 0.5 for guessing, 1 for always right.
double area_under(std::span<const RocPoint> curve);

inline constexpr double kBadError = 0.3; ///< px; an answer with a larger error is bad

/// Answers with their confidence.
struct Judged {
  std::vector<double> confidences;
  std::vector<double> errors; ///< px; of an answer where there should be none: infinite

  void add(double confidence, double error, bool is_unseen);
  void add(const Judged &more);
  std::vector<RocPoint> curve() const; ///< of bad answers
  double area() const { return area_under(curve()); }
};

} // namespace lab
