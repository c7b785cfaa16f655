// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/calibration.hpp"

#include "fail.hpp"

#include <cmath>

namespace spidar {

namespace {

constexpr double kLeastMove = 0.005; // m; ±1 mm of a hand is then 20 %
constexpr double kLargestFactor = 5; // beyond it the unit was mistaken, not the scale
constexpr double kWorstFit = 0.3;    // of the change of length that is not explained

constexpr const char *kAxes[] = {"x", "y", "z"};

void check_factor(double factor, const char *what) {
  if (!(factor > 1 / kLargestFactor && factor < kLargestFactor))
    fail(Cause::argument, messages::kScaleTooFar, what, formatted("%g", factor).c_str());
}

} // namespace

Geometry with_measured_counts(Geometry geometry, const Counts &centre, const Counts &there,
                              int axis, double moved) {
  if (!std::isfinite(moved) || std::abs(moved) < kLeastMove)
    fail(Cause::argument, messages::kMoveTooSmall, kAxes[axis]);
  Pose pose;
  pose.position[axis] = moved;
  const StringLengths expected = string_lengths(geometry, pose) - string_lengths(geometry, {});
  StringLengths seen;
  for (std::size_t i = 0; i < kStrings; ++i)
    seen[i] = (static_cast<double>(there[i]) - centre[i]) * geometry.metres_per_count[i];
  if (seen.norm() < kLeastMove / 10)
    fail(Cause::argument, messages::kCountersStill);
  // One factor for all strings: their drums are alike.
  const double factor = seen.dot(expected) / seen.squaredNorm();
  const double rest = (expected - factor * seen).norm() / expected.norm();
  if (!(factor > 0) || rest > kWorstFit)
    fail(Cause::argument, messages::kMovedOtherwise, kAxes[axis]);
  check_factor(factor, "The length of a count");
  for (double &metres : geometry.metres_per_count)
    metres *= factor;
  return geometry;
}

Geometry with_measured_force(Geometry geometry, double commanded, double measured) {
  if (!(std::isfinite(measured) && measured > 0 && commanded > 0))
    fail(Cause::argument, messages::kForceNotPositive);
  const double factor = commanded / measured;
  check_factor(factor, "The voltage for a newton");
  for (double &volts : geometry.volts_per_newton)
    volts *= factor;
  return geometry;
}

Geometry mirrored(Geometry geometry, int axis) {
  for (std::size_t i = 0; i < kStrings; ++i) {
    geometry.motors[i][axis] *= -1;
    geometry.attachments[i][axis] *= -1;
  }
  return geometry;
}

} // namespace spidar
