// SPDX-License-Identifier: LGPL-2.1-or-later
#include "mpeg-haptics/curve-interpolation.hpp"

#include <algorithm>
#include <cmath>

namespace haptic {
namespace {

constexpr double kFinest = 0.002; // N; half a step of the 8 bits of an amplitude at 1 N
constexpr double kMostLines = 16; // between two keyframes
constexpr std::size_t kAhead = 2; // keyframes behind a segment on which Akima's slopes depend
constexpr std::size_t kBehind = 2;
constexpr double kNoBend = 1e-9; // difference of slopes relative to them

} // namespace

bool is_drawn(CurveType type) noexcept {
  return type == CurveType::linear || type == CurveType::cubic || type == CurveType::akima;
}

CurveDrawing::CurveDrawing(CurveType type, double largest) noexcept
    : type_(type), finest_(kFinest * std::min(1.0, std::abs(largest))) {}

// Slope of the line from a key to the next. Beyond the ends it goes on as a parabola would (Akima,
// J. ACM 17:589, 1970, section 2.3).
double CurveDrawing::slope_between(std::ptrdiff_t from) const {
  const auto last = static_cast<std::ptrdiff_t>(keys_.size()) - 2;
  if (from < 0 || from > last) {
    const std::ptrdiff_t end = from < 0 ? 0 : last;
    const std::ptrdiff_t inner = std::clamp<std::ptrdiff_t>(from < 0 ? 1 : last - 1, 0, last);
    const auto beyond = static_cast<double>(std::abs(from - end));
    return slope_between(end) + beyond * (slope_between(end) - slope_between(inner));
  }
  const CurvePoint &a = keys_[static_cast<std::size_t>(from)];
  const CurvePoint &b = keys_[static_cast<std::size_t>(from) + 1];
  return a.tick == b.tick ? 0 : (b.value - a.value) / static_cast<double>(b.tick - a.tick);
}

// With m(i) the slope between the keys i and i + 1:
// (|m(k+1) - m(k)| m(k-1) + |m(k-1) - m(k-2)| m(k)) / (the sum of both weights).
double CurveDrawing::slope_at(std::size_t key) const {
  const auto k = static_cast<std::ptrdiff_t>(key);
  const double before = slope_between(k - 1);
  const double after = slope_between(k);
  const double bend_after = std::abs(slope_between(k + 1) - after);
  const double bend_before = std::abs(before - slope_between(k - 2));
  const double bends = bend_after + bend_before;
  if (bends <= kNoBend * (std::abs(before) + std::abs(after)))
    return before;
  return (bend_after * before + bend_before * after) / bends;
}

// Appends the curve from a key to the next: with u from 0 to 1, the cubic through both values with
// the slopes at both. Those of `cubic` are 0.
void CurveDrawing::draw(std::size_t from, std::vector<CurvePoint> &points) const {
  const CurvePoint &a = keys_[from];
  const CurvePoint &b = keys_[from + 1];
  const auto length = static_cast<double>(b.tick - a.tick);
  const bool is_bent = length > 1 && (type_ == CurveType::cubic || type_ == CurveType::akima);
  if (is_bent) {
    const bool is_akima = type_ == CurveType::akima;
    const double rise = b.value - a.value;
    const double slope_a = is_akima ? length * slope_at(from) : 0;
    const double slope_b = is_akima ? length * slope_at(from + 1) : 0;
    const double square = 3 * rise - 2 * slope_a - slope_b;
    const double cube = slope_a + slope_b - 2 * rise;
    // A line across 1/n of the curve differs by (second derivative) / (8 n^2) at most.
    const double bend = std::max(std::abs(2 * square), std::abs(2 * square + 6 * cube));
    const double needed = finest_ > 0 ? std::ceil(std::sqrt(bend / (8 * finest_))) : 1;
    // `needed` last: it is no number where a gain makes the values infinite.
    const auto lines = static_cast<std::int64_t>(std::min({kMostLines, length, needed}));
    for (std::int64_t i = 1; i < lines; ++i) {
      const std::int64_t tick = a.tick + (b.tick - a.tick) * i / lines;
      const double u = static_cast<double>(tick - a.tick) / length;
      points.push_back({tick, a.value + u * (slope_a + u * (square + u * cube))});
    }
  }
  points.push_back(b);
}

void CurveDrawing::append(std::span<const CurvePoint> keys, std::vector<CurvePoint> &points) {
  if (keys_.empty() && !keys.empty())
    points.push_back(keys.front());
  keys_.insert(keys_.end(), keys.begin(), keys.end());
  const std::size_t ahead = type_ == CurveType::akima ? kAhead : 0;
  for (; drawn_ + 1 + ahead < keys_.size(); ++drawn_)
    draw(drawn_, points);
  if (drawn_ > kBehind) {
    keys_.erase(keys_.begin(), keys_.begin() + static_cast<std::ptrdiff_t>(drawn_ - kBehind));
    drawn_ = kBehind;
  }
}

void CurveDrawing::finish(std::vector<CurvePoint> &points) {
  for (; drawn_ + 1 < keys_.size(); ++drawn_)
    draw(drawn_, points);
}

} // namespace haptic
