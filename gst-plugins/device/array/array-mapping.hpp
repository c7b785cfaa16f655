// SPDX-License-Identifier: LGPL-2.1-or-later
// A place on the skin between actuators, and a stroke across them.
#pragma once

#include "array/array-layout.hpp"

#include <array>
#include <cstdint>
#include <Eigen/Core>
#include <span>
#include <vector>

namespace haptic {

/// m, in the frame of the layout.
using SkinPlace = Eigen::Vector2d;

/// Makes a place between actuators felt by the three around it. The shares of the energy are its
/// barycentric coordinates in their triangle: their sum is 1 and their centroid is the place. Along
/// the side of two actuators this is the energy model of Israr and Poupyrev (Tactile Brush, CHI
/// 2011), inside a triangle its extension to three (Park and others, EuroHaptics 2016). Outside,
/// the nearest place of the border is felt.
class SkinMap {
public:
  explicit SkinMap(const ArrayLayout &layout);

  /// Sets the share of each actuator; `shares` has one number for each. Never allocates.
  void share_energy(const SkinPlace &place, std::span<double> shares) const;

  /// Returns the part of a velocity that the array can show: all of it, or that along the line on
  /// which all actuators are.
  Eigen::Vector2d visible(const Eigen::Vector2d &velocity) const;

  /// Returns whether a place is inside the border.
  bool contains(const SkinPlace &place) const;

  const std::vector<SkinPlace> &places() const noexcept { return places_; }
  SkinPlace lowest() const noexcept { return lowest_; }   ///< corner of the box about all places
  SkinPlace highest() const noexcept { return highest_; } ///< the opposite corner
  /// Mean distance of an actuator from its nearest neighbour, m.
  double spacing() const noexcept { return spacing_; }

private:
  using Triangle = std::array<std::uint8_t, 3>;
  using Side = std::array<std::uint8_t, 2>;

  void triangulate();
  void join_in_line();
  void collect_sides();
  Eigen::Vector3d coordinates(const Triangle &triangle, const SkinPlace &place) const;
  const Triangle *triangle_at(const SkinPlace &place) const;

  std::vector<SkinPlace> places_;
  std::vector<Triangle> triangles_; // Delaunay's; none if all places are on one line
  std::vector<Side> sides_;
  SkinPlace lowest_;
  SkinPlace highest_;
  double spacing_ = 0;
};

/// A place that moves across the array as long as something moves in the film: in its direction,
/// from border to border, and again. One thread; never allocates after construction.
class Stroke {
public:
  explicit Stroke(const SkinMap &map);

  /// `velocity`: x to the right, y up, as a share (0..1) of the fastest stroke; `dt` in s. Sets the
  /// share of the energy of each actuator. The fastest stroke is the one in which the onsets of two
  /// neighbours are as far apart as vibrations need to be felt as one motion: SOA = 0.32 d + 0.0473
  /// s (Tactile Brush), where an actuator vibrates for d, from its one neighbour to the other.
  void step(const Eigen::Vector2d &velocity, double dt, std::span<double> shares);

  /// The place where the stroke is now.
  const SkinPlace &place() const noexcept { return place_; }

private:
  SkinPlace entry(const Eigen::Vector2d &direction) const;

  const SkinMap &map_;
  SkinPlace place_;
  SkinPlace left_;  // where the stroke left the array
  double fade_ = 1; // 0..1, from there to the place where it came in again
  std::vector<double> leaving_;
};

} // namespace haptic
