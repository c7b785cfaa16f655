// SPDX-License-Identifier: LGPL-2.1-or-later
#include "results/statistics.hpp"

#include "scenes/random.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace lab {

double percentile(std::vector<double> values, double fraction) {
  if (values.empty())
    return 0;
  std::ranges::sort(values);
  const double rank = fraction * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], rank - static_cast<double>(below));
}

double mean(std::span<const double> values) {
  return values.empty() ? 0
                        : std::accumulate(values.begin(), values.end(), 0.0) /
                              static_cast<double>(values.size());
}

Interval bootstrap(std::span<const double> values, std::span<const int> blocks,
                   std::uint64_t seed) {
  constexpr int kDraws = 1000;
  struct Block {
    double sum = 0;
    double count = 0;
  };
  std::map<int, Block> by_name;
  for (std::size_t i = 0; i < values.size(); ++i) {
    by_name[blocks[i]].sum += values[i];
    ++by_name[blocks[i]].count;
  }
  if (by_name.empty())
    return {0, 0};
  std::vector<Block> list;
  for (const auto &[name, block] : by_name)
    list.push_back(block);
  Random random(seed);
  std::vector<double> means;
  for (int draw = 0; draw < kDraws; ++draw) {
    Block drawn;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Block &block = list[random.index(list.size())];
      drawn.sum += block.sum;
      drawn.count += block.count;
    }
    means.push_back(drawn.sum / drawn.count);
  }
  return {percentile(means, 0.025), percentile(means, 0.975)};
}

// (p + z^2/2n +- z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n), p = good/n.
Interval wilson(std::size_t good, std::size_t all) {
  constexpr double kZ = 1.959964;
  const auto n = static_cast<double>(all);
  const double p = static_cast<double>(good) / n;
  const double middle = p + kZ * kZ / (2 * n);
  const double half = kZ * std::sqrt(p * (1 - p) / n + kZ * kZ / (4 * n * n));
  const double scale = 1 / (1 + kZ * kZ / n);
  return {std::max(0.0, (middle - half) * scale), std::min(1.0, (middle + half) * scale)};
}

bool dominates(const SpeedAndError &a, const SpeedAndError &b) {
  return a.time <= b.time && a.error <= b.error && (a.time < b.time || a.error < b.error);
}

std::vector<bool> pareto_front(std::span<const SpeedAndError> all) {
  std::vector<bool> on_front;
  for (const SpeedAndError &one : all)
    on_front.push_back(
        std::ranges::none_of(all, [&](const auto &other) { return dominates(other, one); }));
  return on_front;
}

std::vector<RocPoint> roc(std::span<const double> confidences, const std::vector<bool> &bad) {
  std::vector<std::size_t> order(confidences.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return confidences[i]; });
  const auto total_bad = static_cast<double>(std::ranges::count(bad, true));
  const double total_good = static_cast<double>(bad.size()) - total_bad;
  std::vector<RocPoint> curve{{0, 0, 0}};
  double bad_below = 0;
  double good_below = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    (bad[order[i]] ? bad_below : good_below) += 1;
    // Equal confidences share one threshold.
    if (i + 1 == order.size() || confidences[order[i + 1]] > confidences[order[i]])
      curve.push_back({confidences[order[i]], total_good > 0 ? good_below / total_good : 1,
                       total_bad > 0 ? bad_below / total_bad : 1});
  }
  return curve;
}

double area_under(std::span<const RocPoint> curve) {
  double area = 0;
  for (std::size_t i = 1; i < curve.size(); ++i)
    area += (curve[i].false_alarms - curve[i - 1].false_alarms) *
            (curve[i].detections + curve[i - 1].detections) / 2;
  return area;
}

void Judged::add(double confidence, double error, bool is_unseen) {
  confidences.push_back(confidence);
  errors.push_back(is_unseen ? std::numeric_limits<double>::infinity() : error);
}

void Judged::add(const Judged &more) {
  confidences.insert(confidences.end(), more.confidences.begin(), more.confidences.end());
  errors.insert(errors.end(), more.errors.begin(), more.errors.end());
}

std::vector<RocPoint> Judged::curve() const {
  std::vector<bool> bad;
  for (const double error : errors)
    bad.push_back(error > kBadError);
  return roc(confidences, bad);
}

} // namespace lab
