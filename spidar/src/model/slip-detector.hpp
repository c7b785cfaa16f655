// SPDX-License-Identifier: LGPL-2.1-or-later
// Notices a string that has slipped on its drum: eight lengths of a grip with six degrees of
// freedom then contradict each other more than the calibration explains. SI units. Real-time safe.
#pragma once

#include "spidar/types.hpp"

#include <array>

namespace spidar {

/// A unit that differs from its geometry, or was calibrated with the grip off the centre, has a
/// misfit without a slip. That misfit changes with the way of the grip, and a slip needs no way. So
/// the misfit is compared with those at the centre (zero), a second ago and a moment ago, and may
/// differ in proportion to the way from there. How much, is learnt from the calibration on.
class SlipDetector {
public:
  explicit SlipDetector(double grip_radius) noexcept : grip_radius_(grip_radius) {}

  /// The grip is at the centre, and every length is right.
  void calibrate() noexcept { *this = SlipDetector(grip_radius_); }
  /// `misfit`: measured minus modelled lengths at this pose, m; `elapsed`: s since the one before.
  void step(const StringLengths &misfit, const Pose &pose, double elapsed) noexcept;
  /// The grip is seen where no hand can have taken it. Strings that agree about it have not
  /// slipped.
  void jump(const StringLengths &misfit) noexcept;

  /// A string has slipped, and has not come back.
  bool slipping() const noexcept { return slipping_ || jumped_; }
  /// That was so for 0.2 s. Until calibrate().
  bool slipped() const noexcept { return slipped_; }

private:
  struct Place {
    StringLengths misfit = StringLengths::Zero(); ///< m
    Pose pose;
  };
  enum { kCentre, kSecondAgo, kMomentAgo, kPlaces };

  double way(const Place &from, const Place &to) const noexcept;
  bool is_slipping(const Place &here) noexcept;
  void learn(const Place &here, double elapsed) noexcept;

  double grip_radius_; ///< m
  std::array<Place, kPlaces> places_{};
  double feared_ = 0.03;    ///< misfit for each way, until the unit has moved enough to be known
  double shown_ = 0;        ///< the same, the most that was seen
  double slipping_for_ = 0; ///< s
  std::size_t noticed_ = 0; ///< from which place
  double unexplained_ = 0;  ///< m, the misfit from which on it was a slip
  bool jumped_ = false;
  bool slipping_ = false;
  bool slipped_ = false;
};

} // namespace spidar
