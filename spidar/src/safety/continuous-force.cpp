// SPDX-License-Identifier: LGPL-2.1-or-later
#include "safety/continuous-force.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace haptic {
namespace {

constexpr double kReserve = 0.5;  // of the budget, for the time after a peak
constexpr double kFadeTime = 1.2; // s; the force of a peak fades with twice this
constexpr double kRecovery = 1;   // 1/s of the budget: how fast the limit rises again
constexpr double kUnlimited = std::numeric_limits<double>::infinity();

} // namespace

// What is left of the budget, N²·s. The complete bins and the current one cover every window of 60
// s that ends now, and at most 0.1 s more.
double ContinuousForce::left() const noexcept {
  return budget_ * budget_ * (kWindow + kBin) - complete_ - current_;
}

double ContinuousForce::step(double force, double budget, double dt) noexcept {
  if (budget != budget_) {
    budget_ = budget;
    limit_ = kUnlimited;
    update_steady();
  }
  double remaining = std::clamp(dt, 0.0, kWindow + kBin);
  const bool bin_ends = elapsed_ + remaining >= kBin;
  while (elapsed_ + remaining >= kBin) {
    current_ += force * force * (kBin - elapsed_);
    remaining -= kBin - elapsed_;
    end_bin();
  }
  current_ += force * force * remaining;
  elapsed_ += remaining;
  if (bin_ends)
    update_steady();
  if (!(budget_ > 0))
    return kUnlimited;

  // F² <= (left - reserve) / T falls exponentially, F with 2 T, and never uses up the reserve.
  const double peak = (left() - kReserve * budget_ * budget_ * kWindow) / kFadeTime;
  const double highest = std::sqrt(std::max({peak, steady_, 0.0}));
  limit_ = std::min(highest, limit_ + kRecovery * budget_ * dt);
  return limit_;
}

void ContinuousForce::end_bin() noexcept {
  bins_[oldest_] = current_;
  oldest_ = (oldest_ + 1) % kBins;
  current_ = 0;
  elapsed_ = 0;
}

// The highest constant F² that never exceeds the budget B while the past leaves the window:
// F² = min over k of (left + the oldest k - 1 bins) / (k T_bin), k = 1 to 600.
void ContinuousForce::update_steady() noexcept {
  complete_ = 0;
  for (const double bin : bins_)
    complete_ += bin;
  double available = left();
  steady_ = available / kBin;
  for (std::size_t k = 1; k < kBins; ++k) {
    available += bins_[(oldest_ + k - 1) % kBins];
    steady_ = std::min(steady_, available / (static_cast<double>(k + 1) * kBin));
  }
}

double ContinuousForce::rms() const noexcept {
  return std::sqrt((complete_ + current_) / (kWindow + elapsed_));
}

double ContinuousForce::used() const noexcept {
  const double whole = budget_ * budget_ * (kWindow + kBin);
  return whole > 0 ? (complete_ + current_) / whole : 0;
}

} // namespace haptic
