// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/geometry.hpp"

#include "fail.hpp"
#include "model/string-kinematics.hpp"
#include "model/wrench-closure.hpp"

#include <cmath>

namespace spidar {

namespace {

class Check {
public:
  explicit Check(const Geometry &geometry) : geometry_(geometry) {}

  void device() const {
    positive("digits-per-volt", geometry_.digits_per_volt);
    require(geometry_.dac_limit >= 1 && geometry_.dac_limit <= 32767, "dac-limit",
            "must be 1 to 32767");
    positive("tension-min", geometry_.tension_min);
    positive("tension-max", geometry_.tension_max);
    require(geometry_.tension_min < geometry_.tension_max, "tension-min",
            "must be smaller than tension-max");
    require(geometry_.grip_radius > 0 && geometry_.grip_radius < kLargest, "grip-radius",
            "must be more than 0 m and less than 10 m");
    require(!geometry_.button || (geometry_.button->bit >= 0 && geometry_.button->bit <= 3),
            "button-bit", "must be 0 to 3");
  }

  void workspace() const {
    for (int axis = 0; axis < 3; ++axis) {
      double extent = 0;
      for (const Vector3 &motor : geometry_.motors)
        extent = std::max(extent, std::abs(motor[axis]));
      const double half = geometry_.workspace_half[axis];
      require(half > 0 && half < extent, "workspace-half",
              "must be more than 0 m and end before the motors on each axis");
    }
  }

  void string(std::size_t i) const {
    const auto key = [i](const char *name) { return "[string-" + std::to_string(i) + "] " + name; };
    const auto near = [](const Vector3 &point) {
      return point.allFinite() && point.cwiseAbs().maxCoeff() < kLargest;
    };
    require(near(geometry_.motors[i]), key("motor"),
            "must be three numbers in metres, each less than 10 m");
    require(near(geometry_.attachments[i]), key("attachment"),
            "must be three numbers in metres, each less than 10 m");
    require((geometry_.motors[i] - geometry_.attachments[i]).norm() > kShortestString, key("motor"),
            "must be at least 1 mm away from the attachment");
    const double count = std::abs(geometry_.metres_per_count[i]);
    require(count > 0 && count < kCoarsestCount, key("metres-per-count"),
            "must not be zero and less than 0.001 m");
    const double volts = std::abs(geometry_.volts_per_newton[i]);
    require(volts > 0 && std::isfinite(volts), key("volts-per-newton"),
            "must be a number other than zero");
    const double smallest = std::ceil(geometry_.tension_min * volts * geometry_.digits_per_volt);
    const double largest = std::floor(geometry_.tension_max * volts * geometry_.digits_per_volt);
    require(smallest <= geometry_.dac_limit, key("volts-per-newton"),
            "needs more than dac-limit for tension-min");
    require(smallest <= largest, key("volts-per-newton"),
            "leaves no D/A word between tension-min and tension-max");
  }

private:
  static constexpr double kLargest = 10;          // m; millimetres taken for metres exceed it
  static constexpr double kShortestString = 1e-3; // m
  static constexpr double kCoarsestCount = 1e-3;  // m

  void require(bool holds, const std::string &key, const std::string &reason) const {
    if (!holds)
      fail(Cause::geometry, messages::kGeometryValue, geometry_.name.c_str(), key.c_str(),
           reason.c_str());
  }
  void positive(const char *key, double value) const {
    require(std::isfinite(value) && value > 0, key, "must be a number greater than zero");
  }

  const Geometry &geometry_;
};

} // namespace

void check_geometry(const Geometry &geometry) {
  const Check check(geometry);
  check.device();
  for (std::size_t i = 0; i < kStrings; ++i)
    check.string(i);
  check.workspace();
  const std::string missing = unreachable_directions(geometry);
  if (!missing.empty())
    fail(Cause::geometry, messages::kGeometryClosure, geometry.name.c_str(), missing.c_str());
}

StringLengths string_lengths(const Geometry &geometry, const Pose &pose) {
  return string_kinematics(geometry, pose).lengths;
}

std::string unreachable_directions(const Geometry &geometry) {
  WrenchMatrix pull = string_kinematics(geometry, {}).pull;
  pull.bottomRows<3>() /= geometry.grip_radius;
  return directions_out_of_reach(pull);
}

} // namespace spidar
