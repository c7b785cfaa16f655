// SPDX-License-Identifier: LGPL-2.1-or-later
#include "array/array-mapping.hpp"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <limits>
#include <numeric>

namespace haptic {

namespace {

double cross(const Eigen::Vector2d &a, const Eigen::Vector2d &b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Whether `d` is inside the circle through a, b and c, which turn to the left.
bool is_in_circle(const SkinPlace &a, const SkinPlace &b, const SkinPlace &c, const SkinPlace &d) {
  Eigen::Matrix3d rows;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector2d from = (i == 0 ? a : i == 1 ? b : c) - d;
    rows.row(i) << from.x(), from.y(), from.squaredNorm();
  }
  return rows.determinant() > 0;
}

} // namespace

SkinMap::SkinMap(const ArrayLayout &layout) {
  for (const Actuator &actuator : layout.actuators)
    places_.emplace_back(actuator.x, actuator.y);
  lowest_ = highest_ = places_.front();
  for (const SkinPlace &place : places_) {
    lowest_ = lowest_.cwiseMin(place);
    highest_ = highest_.cwiseMax(place);
    double nearest = std::numeric_limits<double>::infinity();
    for (const SkinPlace &other : places_)
      if (&other != &place)
        nearest = std::min(nearest, (other - place).norm());
    spacing_ += nearest / static_cast<double>(places_.size());
  }
  triangulate();
  if (triangles_.empty())
    join_in_line();
  else
    collect_sides();
}

// Tries all triangles: there are at most 41 664, once.
void SkinMap::triangulate() {
  // Four places of a grid are on one circle, so that both ways to cut it are right. Places that are
  // displaced by a billionth of the spacing have only one.
  std::vector<SkinPlace> displaced = places_;
  for (std::size_t i = 0; i < displaced.size(); ++i) {
    const auto angle = static_cast<double>(i * i);
    displaced[i] += 1e-9 * spacing_ * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  }
  const auto count = static_cast<std::uint8_t>(places_.size());
  const double flat = 1e-3 * spacing_ * spacing_;
  for (std::uint8_t a = 0; a < count; ++a)
    for (std::uint8_t b = a + 1; b < count; ++b)
      for (std::uint8_t c = b + 1; c < count; ++c) {
        const double area = cross(places_[b] - places_[a], places_[c] - places_[a]);
        if (std::abs(area) < flat)
          continue;
        const Triangle triangle = area > 0 ? Triangle{a, b, c} : Triangle{a, c, b};
        const auto is_inside = [&](const SkinPlace &place) {
          return is_in_circle(displaced[triangle[0]], displaced[triangle[1]],
                              displaced[triangle[2]], place);
        };
        bool empty = true;
        for (std::uint8_t d = 0; d < count && empty; ++d)
          empty = d == a || d == b || d == c || !is_inside(displaced[d]);
        if (empty)
          triangles_.push_back(triangle);
      }
}

// All places are on one line: from each to the next.
void SkinMap::join_in_line() {
  std::vector<std::uint8_t> order(places_.size());
  std::iota(order.begin(), order.end(), std::uint8_t{0});
  const Eigen::Vector2d along = places_.back() - places_.front();
  std::ranges::sort(order, {}, [&](std::uint8_t i) { return places_[i].dot(along); });
  for (std::size_t i = 1; i < order.size(); ++i)
    sides_.push_back({order[i - 1], order[i]});
}

void SkinMap::collect_sides() {
  for (const Triangle &triangle : triangles_)
    for (std::size_t i = 0; i < 3; ++i)
      sides_.push_back({triangle[i], triangle[(i + 1) % 3]});
}

Eigen::Vector3d SkinMap::coordinates(const Triangle &triangle, const SkinPlace &place) const {
  const SkinPlace &a = places_[triangle[0]];
  const SkinPlace &b = places_[triangle[1]];
  const SkinPlace &c = places_[triangle[2]];
  const double area = cross(b - a, c - a);
  const double of_b = cross(place - a, c - a) / area;
  const double of_c = cross(b - a, place - a) / area;
  return {1 - of_b - of_c, of_b, of_c};
}

const SkinMap::Triangle *SkinMap::triangle_at(const SkinPlace &place) const {
  constexpr double kRounding = -1e-9;
  for (const Triangle &triangle : triangles_)
    if (coordinates(triangle, place).minCoeff() >= kRounding)
      return &triangle;
  return nullptr;
}

Eigen::Vector2d SkinMap::visible(const Eigen::Vector2d &velocity) const {
  if (!triangles_.empty())
    return velocity;
  const Eigen::Vector2d along = (places_.back() - places_.front()).normalized();
  return velocity.dot(along) * along;
}

bool SkinMap::contains(const SkinPlace &place) const {
  if (!triangles_.empty())
    return triangle_at(place) != nullptr;
  const SkinPlace &from = places_[sides_.front()[0]];
  const SkinPlace &to = places_[sides_.back()[1]];
  const double along = (place - from).dot(to - from) / (to - from).squaredNorm();
  return along >= 0 && along <= 1;
}

void SkinMap::share_energy(const SkinPlace &place, std::span<double> shares) const {
  std::ranges::fill(shares, 0);
  if (const Triangle *triangle = triangle_at(place)) {
    Eigen::Vector3d own = coordinates(*triangle, place).cwiseMax(0);
    own /= own.sum();
    for (std::size_t i = 0; i < 3; ++i)
      shares[(*triangle)[i]] = own[static_cast<int>(i)];
    return;
  }
  double nearest = std::numeric_limits<double>::infinity();
  const Side *best = &sides_.front();
  double share = 0;
  for (const Side &side : sides_) {
    const SkinPlace &from = places_[side[0]];
    const Eigen::Vector2d along = places_[side[1]] - from;
    const double at = std::clamp((place - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
    const double distance = (from + at * along - place).squaredNorm();
    if (distance < nearest) {
      nearest = distance;
      best = &side;
      share = at;
    }
  }
  shares[(*best)[0]] = 1 - share;
  shares[(*best)[1]] = share;
}

Stroke::Stroke(const SkinMap &map)
    : map_(map), place_((map.lowest() + map.highest()) / 2), left_(place_),
      leaving_(map.places().size()) {}

// Where the line through the place comes into the array: on its other side.
SkinPlace Stroke::entry(const Eigen::Vector2d &direction) const {
  const Eigen::Vector2d size = map_.highest() - map_.lowest();
  const double step = map_.spacing() / 16;
  const double farthest = size.norm();
  SkinPlace last = place_;
  bool was_inside = false;
  for (double back = step; back < farthest + step; back += step) {
    const SkinPlace place = place_ - back * direction;
    if (map_.contains(place)) {
      was_inside = true;
      last = place;
    } else if (was_inside) {
      break;
    }
  }
  return last;
}

void Stroke::step(const Eigen::Vector2d &velocity, double dt, std::span<double> shares) {
  constexpr double kRelative = 0.32;  // Tactile Brush
  constexpr double kAtLeast = 0.0473; // s
  constexpr double kFade = 0.05;      // s
  // The onsets of two neighbours are spacing / speed apart, and each vibrates twice as long.
  const double fastest = map_.spacing() * (1 - 2 * kRelative) / kAtLeast;
  const Eigen::Vector2d visible = map_.visible(velocity);
  const double speed = visible.norm();
  if (speed > 0) {
    const Eigen::Vector2d direction = visible / speed;
    const SkinPlace next = place_ + dt * std::min(speed, 1.0) * fastest * direction;
    if (map_.contains(next)) {
      place_ = next;
    } else if (fade_ >= 1) {
      left_ = place_;
      place_ = entry(direction);
      fade_ = 0;
    }
  }
  fade_ = std::min(1.0, fade_ + dt / kFade);
  map_.share_energy(place_, shares);
  if (fade_ >= 1)
    return;
  map_.share_energy(left_, leaving_);
  for (std::size_t i = 0; i < shares.size(); ++i)
    shares[i] = fade_ * shares[i] + (1 - fade_) * leaving_[i];
}

} // namespace haptic
