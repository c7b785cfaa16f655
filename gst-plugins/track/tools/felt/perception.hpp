// SPDX-License-Identifier: LGPL-2.1-or-later
// A model of what a hand can tell apart. docs/comparing.md has its limits and sources.
#pragma once

#include "felt/force-signal.hpp"

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

namespace haptic {

inline constexpr double kLeastForce = 0.03;      ///< N, the least difference that is felt
inline constexpr double kLeastForceShare = 0.07; ///< the same as a share of the stronger force
inline constexpr double kLeastDirected = 0.05;   ///< N; weaker forces have no direction
inline constexpr double kLeastAngle = 18.4;      ///< degrees
inline constexpr double kLeastShift = 0.045;     ///< s

/// Returns whether a hand can tell two forces apart, one of which is felt: is above kLeastForce. Of
/// two forces above kLeastDirected: strengths that differ by more than kLeastForce and
/// kLeastForceShare, or directions by more than kLeastAngle. Of others: a difference, as a vector,
/// above kLeastForce. Symmetric.
bool differ(const Force &a, const Force &b) noexcept;

using SignalPair = std::pair<ForceSignal, ForceSignal>;

/// Returns the pair at a place. Is called several times for each.
using SignalsAt = std::function<SignalPair(std::size_t place)>;

struct PlaceComparison {
  double distinguishable = 0; ///< share of the time, 0..1
  double felt = 0;            ///< share of the time in which something is felt
  double force_rms = 0;       ///< N, of the difference while something is felt
};

struct Comparison {
  PlaceComparison all;        ///< at all places together
  double shift = 0;           ///< s, by which the second signal is later; the same at all places
  bool is_start_known = true; ///< otherwise the shift says nothing
  std::vector<PlaceComparison> places;
  std::int64_t first = 0; ///< steps of kForceStep: the time that was compared
  std::int64_t end = 0;

  /// Returns whether the shift alone is felt.
  bool is_late() const noexcept;
  /// Returns whether a hand can tell the forces at this step of the first signal apart.
  bool is_distinguishable(const SignalPair &pair, std::int64_t step) const noexcept;
};

/// Returns the shift up to 2 s at which the signals of `places` places fit best, s: the energy of
/// their difference, over their own, is the least where both last. A shift above kLeastShift must
/// fit better by 5 %.
double best_shift(std::size_t places, const SignalsAt &signals_at);

/// Compares at a shift. If it is above kLeastShift, all that is felt can be told apart, unless
/// nobody knows when the signals start. A signal that has ended is zero.
Comparison compare_at(double shift, std::size_t places, const SignalsAt &signals_at,
                      bool is_start_known = true);

} // namespace haptic
