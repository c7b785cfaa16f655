// SPDX-License-Identifier: LGPL-2.1-or-later
// The budget for continuous force: the rms of the force over any minute, so that motors and hand do
// not tire (docs/force.md#continuous-force).
#pragma once

#include <array>
#include <cstddef>

namespace haptic {

/// Keeps the rms of a force over any kWindow seconds within a budget. One thread; real-time safe.
class ContinuousForce {
public:
  static constexpr double kWindow = 60; // s

  /// Accounts for `force` (N) that acted for the last `dt` s. Returns the highest force for now, N:
  /// at most five times the budget, and what the rest of the budget can sustain. It falls by at
  /// most 2.1 1/s of the budget. `budget` in N rms; 0: no limit.
  double step(double force, double budget, double dt) noexcept;
  /// The same with the budget of the step before.
  double step(double force, double dt) noexcept { return step(force, budget_, dt); }

  /// Returns the rms of the force over the last kWindow seconds, N.
  double rms() const noexcept;
  /// Returns the share of the budget that the last kWindow seconds used; 0 without a budget.
  double used() const noexcept;

private:
  static constexpr std::size_t kBins = 600;
  static constexpr double kBin = kWindow / kBins; // s

  void end_bin() noexcept;
  void update_steady() noexcept;
  double left() const noexcept;

  std::array<double, kBins> bins_{}; // N²·s each, of the complete ones
  std::size_t oldest_ = 0;
  double complete_ = 0; // N²·s, the sum of bins_
  double current_ = 0;  // N²·s
  double elapsed_ = 0;  // s, of the current bin
  double budget_ = 0;   // N
  double steady_ = 0;   // N², that can be kept up for ever
  double limit_ = 0;    // N
};

} // namespace haptic
