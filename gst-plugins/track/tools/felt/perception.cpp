// SPDX-License-Identifier: LGPL-2.1-or-later
#include "felt/perception.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <numbers>

namespace haptic {
namespace {

constexpr std::int64_t kCoarse = 20;     // steps
constexpr std::int64_t kFarthest = 2000; // steps
constexpr std::int64_t kUnfelt = 45;     // steps, the largest shift that is not felt
// A shift that is felt must have a misfit smaller by a share and by a difference.
constexpr double kFitsBetter = 0.95;
constexpr double kFitsBetterBy = 0.003;
static_assert(kUnfelt * kForceStep <= kLeastShift && (kUnfelt + 1) * kForceStep > kLeastShift);

double square(double value) {
  return value * value;
}

double squared_difference(const Force &a, const Force &b) {
  return square(a.x - b.x) + square(a.y - b.y) + square(a.z - b.z);
}

double norm(const Force &force) {
  return std::sqrt(squared_difference(force, {}));
}

bool is_any_felt(const Force &a, const Force &b) {
  return std::max(norm(a), norm(b)) > kLeastForce;
}

// Means over kCoarse steps.
ForceSignal coarse(const ForceSignal &signal) {
  const auto bin_of = [](std::int64_t step) {
    return step >= 0 ? step / kCoarse : (step + 1) / kCoarse - 1;
  };
  ForceSignal means;
  means.first = bin_of(signal.first);
  means.forces.resize(static_cast<std::size_t>(bin_of(signal.end() - 1) - means.first + 1));
  for (std::int64_t step = signal.first; step < signal.end(); ++step) {
    const Force force = signal.at(step);
    Force &mean = means.forces[static_cast<std::size_t>(bin_of(step) - means.first)];
    mean.x += force.x / kCoarse;
    mean.y += force.y / kCoarse;
    mean.z += force.z / kCoarse;
  }
  return means;
}

// How well two signals fit at a shift, where they overlap.
struct Fit {
  std::int64_t shift = 0; // steps
  double squares = 0;     // N^2, sum over |a - b|^2
  double energy = 0;      // N^2, sum over |a|^2 + |b|^2

  // Shifts that leave less than half of the shorter signal do not count.
  void add(const ForceSignal &a, const ForceSignal &b, std::int64_t by) {
    const std::int64_t first = std::max(a.first, b.first - by);
    const std::int64_t end = std::min(a.end(), b.end() - by);
    if (2 * (end - first) < static_cast<std::int64_t>(std::min(a.forces.size(), b.forces.size())))
      return;
    for (std::int64_t step = first; step < end; ++step) {
      squares += squared_difference(a.at(step), b.at(step + by));
      energy += squared_difference(a.at(step), {}) + squared_difference(b.at(step + by), {});
    }
  }
  // 0: equal; 1: of no relation.
  double misfit() const {
    return energy > 0 ? std::sqrt(squares / energy) : std::numeric_limits<double>::infinity();
  }
};

// Returns the fits at these shifts, the small ones first.
std::vector<Fit> fits_between(std::int64_t first, std::int64_t last, std::int64_t by) {
  std::vector<Fit> fits;
  for (std::int64_t shift = first; shift <= last; shift += by)
    fits.push_back({.shift = shift});
  std::ranges::stable_sort(fits, {}, [](const Fit &fit) { return std::abs(fit.shift); });
  return fits;
}

// Returns the best one of those whose shift is felt, or is not.
Fit best(const std::vector<Fit> &fits, bool felt) {
  Fit best;
  for (const Fit &fit : fits)
    if ((std::abs(fit.shift) > kUnfelt) == felt && fit.misfit() < best.misfit())
      best = fit;
  return best;
}

// Returns the steps of `a` that count: while either signal lasts. A difference of beginnings or
// ends that is not felt does not count.
std::pair<std::int64_t, std::int64_t> compared_steps(const SignalPair &pair, std::int64_t shift) {
  const auto &[a, b] = pair;
  const auto [first, second] = std::minmax({a.first, b.first - shift});
  const auto [last_but_one, last] = std::minmax({a.end(), b.end() - shift});
  return {second - first > kUnfelt ? first : second,
          last - last_but_one > kUnfelt ? last : last_but_one};
}

struct Sums {
  double steps = 0;
  double distinguishable = 0;
  double felt = 0;
  double squares = 0;

  void add(const Sums &other) {
    steps += other.steps;
    distinguishable += other.distinguishable;
    felt += other.felt;
    squares += other.squares;
  }
  PlaceComparison shares() const {
    return {distinguishable / std::max(steps, 1.0), felt / std::max(steps, 1.0),
            std::sqrt(squares / std::max(felt, 1.0))};
  }
};

} // namespace

bool differ(const Force &a, const Force &b) noexcept {
  if (!is_any_felt(a, b))
    return false;
  const double strong = norm(a);
  const double weak = norm(b);
  if (std::min(strong, weak) < kLeastDirected)
    return squared_difference(a, b) > square(kLeastForce);
  const double least = std::max(kLeastForce, kLeastForceShare * std::max(strong, weak));
  const double cosine = (static_cast<double>(a.x) * b.x + static_cast<double>(a.y) * b.y +
                         static_cast<double>(a.z) * b.z) /
                        (strong * weak);
  return std::abs(strong - weak) > least || cosine < std::cos(kLeastAngle / 180 * std::numbers::pi);
}

bool Comparison::is_late() const noexcept {
  return is_start_known && std::abs(shift) > kLeastShift;
}

bool Comparison::is_distinguishable(const SignalPair &pair, std::int64_t step) const noexcept {
  const Force a = pair.first.at(step);
  const Force b = pair.second.at(step + std::llround(shift / kForceStep));
  return is_late() ? is_any_felt(a, b) : differ(a, b);
}

double best_shift(std::size_t places, const SignalsAt &signals_at) {
  std::vector<Fit> rough = fits_between(-kFarthest, kFarthest, kCoarse);
  for (std::size_t place = 0; place < places; ++place) {
    const auto [a, b] = signals_at(place);
    const ForceSignal a_means = coarse(a);
    const ForceSignal b_means = coarse(b);
    for (Fit &fit : rough)
      fit.add(a_means, b_means, fit.shift / kCoarse);
  }
  std::vector<Fit> fine;
  for (const bool felt : {false, true}) {
    const std::int64_t middle = best(rough, felt).shift;
    std::ranges::copy(fits_between(middle - kCoarse, middle + kCoarse, 1),
                      std::back_inserter(fine));
  }
  for (std::size_t place = 0; place < places; ++place) {
    const auto [a, b] = signals_at(place);
    for (Fit &fit : fine)
      fit.add(a, b, fit.shift);
  }
  const Fit unfelt = best(fine, false);
  const Fit felt = best(fine, true);
  const bool late = felt.misfit() < kFitsBetter * unfelt.misfit() - kFitsBetterBy;
  return static_cast<double>((late ? felt : unfelt).shift) * kForceStep;
}

Comparison compare_at(double shift_time, std::size_t places, const SignalsAt &signals_at,
                      bool is_start_known) {
  Comparison result;
  result.is_start_known = is_start_known;
  const std::int64_t shift = std::llround(shift_time / kForceStep);
  result.shift = static_cast<double>(shift) * kForceStep;
  Sums all;
  for (std::size_t place = 0; place < places; ++place) {
    const SignalPair pair = signals_at(place);
    const auto &[a, b] = pair;
    const auto [first, end] = compared_steps(pair, shift);
    result.first = place == 0 ? first : std::min(result.first, first);
    result.end = place == 0 ? end : std::max(result.end, end);
    Sums sums;
    for (std::int64_t step = first; step < end; ++step) {
      ++sums.steps;
      sums.distinguishable += result.is_distinguishable(pair, step);
      if (!is_any_felt(a.at(step), b.at(step + shift)))
        continue;
      ++sums.felt;
      sums.squares += squared_difference(a.at(step), b.at(step + shift));
    }
    result.places.push_back(sums.shares());
    all.add(sums);
  }
  result.all = all.shares();
  return result;
}

} // namespace haptic
