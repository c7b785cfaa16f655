// SPDX-License-Identifier: LGPL-2.1-or-later
#include "model/slip-detector.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace spidar {

namespace {

// Misfits are rms over the strings. A slip of 3 mm within 15 mm and 10 degrees shows 0.24 mm at
// least.
constexpr double kNoise = 4e-5;     // m; counts of 35 µm alone are 5 µm
constexpr double kStay = 0.2;       // s; the force has long faded
constexpr double kSecond = 1;       // s
constexpr double kMoment = 0.03;    // s
constexpr double kLeastWay = 0.003; // m, from which on a misfit for each way means something

// Misfit for each way. Motors that are off by 1 mm and drums by 0.5 % show 0.0043 at most, and a
// calibration 3 mm and 3 degrees off the centre 0.022.
constexpr double kBest = 0.0065;
constexpr double kMargin = 2;    // of what was seen
constexpr double kLearns = 0.05; // more, for each m that the grip moves
constexpr double kGetsKnown = 2; // m that the grip moves

double rms(const StringLengths &misfit) noexcept {
  constexpr double kCount = kStrings;
  return std::sqrt(misfit.squaredNorm() / kCount);
}

} // namespace

double SlipDetector::way(const Place &from, const Place &to) const noexcept {
  // |R - S| = sqrt(2) times the angle between them, if it is small.
  return (to.pose.position - from.pose.position).norm() +
         grip_radius_ * (to.pose.rotation - from.pose.rotation).norm() / std::numbers::sqrt2;
}

bool SlipDetector::is_slipping(const Place &here) noexcept {
  const auto change = [&](std::size_t place) { return rms(here.misfit - places_[place].misfit); };
  if (slipping_)
    return change(noticed_) > unexplained_ / 2;
  const double for_each_way = std::max({kMargin * shown_, feared_, kBest});
  for (std::size_t place = 0; place < kPlaces; ++place) {
    noticed_ = place;
    unexplained_ = kNoise + for_each_way * way(places_[place], here);
    if (change(place) > unexplained_)
      return true;
  }
  return false;
}

void SlipDetector::learn(const Place &here, double elapsed) noexcept {
  const double moved = way(places_[kMomentAgo], here) * std::min(elapsed / kMoment, 1.0);
  feared_ *= std::exp(-moved / kGetsKnown);
  for (const Place &place : places_) {
    const double from = way(place, here);
    if (from > kLeastWay) {
      const double seen = (rms(here.misfit - place.misfit) - kNoise) / from;
      shown_ += std::clamp(seen - shown_, 0.0, kLearns * moved);
    }
  }
  const auto follow = [&](Place &place, double time) {
    const double share = 1 - std::exp(-elapsed / time);
    place.misfit += share * (here.misfit - place.misfit);
    place.pose.position += share * (here.pose.position - place.pose.position);
    place.pose.rotation += share * (here.pose.rotation - place.pose.rotation);
  };
  follow(places_[kSecondAgo], kSecond);
  follow(places_[kMomentAgo], kMoment);
}

void SlipDetector::jump(const StringLengths &misfit) noexcept {
  jumped_ = rms(misfit) > kNoise;
}

void SlipDetector::step(const StringLengths &misfit, const Pose &pose, double elapsed) noexcept {
  const Place here{misfit, pose};
  slipping_ = is_slipping(here);
  if (!slipping())
    learn(here, elapsed);
  slipping_for_ = slipping() ? slipping_for_ + elapsed : 0;
  slipped_ |= slipping_for_ >= kStay;
}

} // namespace spidar
