// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/calibration.hpp"

#include "model/gentle-pull.hpp"
#include "spidar/device.hpp"
#include "spidar/error.hpp"
#include "spidar/simulator.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <locale>

namespace spidar_calibration_test {

using namespace spidar;

/// What the counters show when the grip goes from the centre to `position`.
Counts counts_at(const Geometry &truth, const Vector3 &position) {
  Pose pose;
  pose.position = position;
  const StringLengths change = string_lengths(truth, pose) - string_lengths(truth, {});
  Counts counts{};
  for (std::size_t i = 0; i < kStrings; ++i)
    counts[i] = static_cast<std::int32_t>(std::lround(change[i] / truth.metres_per_count[i]));
  return counts;
}

Geometry builtin() {
  return load_geometry(kDefaultGeometry);
}

Geometry scaled(Geometry geometry, double counts) {
  for (double &metres : geometry.metres_per_count)
    metres *= counts;
  return geometry;
}

template <class Call>
std::string refusal(Cause cause, Call call) {
  try {
    call();
  } catch (const Error &error) {
    EXPECT_EQ(error.cause(), cause) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return "";
}

TEST(Calibration, FindsTheLengthOfACountFromAMoveAlongAnyAxis) {
  const Geometry truth = scaled(builtin(), 1.3);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double moved : {-0.02, 0.01, 0.03}) {
      Vector3 place = Vector3::Zero();
      place[axis] = moved;
      const Geometry found =
          with_measured_counts(builtin(), {}, counts_at(truth, place), axis, moved);
      for (std::size_t i = 0; i < kStrings; ++i)
        EXPECT_NEAR(found.metres_per_count[i] / truth.metres_per_count[i], 1, 0.002);
    }
  }
}

TEST(Calibration, RefusesAMoveThatDoesNotFit) {
  const Geometry truth = builtin();
  const Counts right = counts_at(truth, {0.02, 0, 0});
  const auto measured = [&](const Counts &there, int axis, double moved) {
    return refusal(Cause::argument,
                   [&] { with_measured_counts(builtin(), {}, there, axis, moved); });
  };
  EXPECT_NE(measured(right, 0, -0.02).find("in the right direction"), std::string::npos);
  EXPECT_NE(measured(right, 1, 0.02).find("along y"), std::string::npos);
  EXPECT_NE(measured({}, 0, 0.02).find("have not moved"), std::string::npos);
  EXPECT_NE(measured(right, 0, 0.001).find("at least 5 mm"), std::string::npos);
  EXPECT_NE(measured(right, 0, std::numeric_limits<double>::quiet_NaN()).find("5 mm"),
            std::string::npos);
  // Millimetres taken for centimetres.
  EXPECT_NE(measured(counts_at(truth, {0.002, 0, 0}), 0, 0.02).find("unit"), std::string::npos);
}

TEST(Calibration, AMotorThatPullsTooWeaklyGetsMoreVolts) {
  const Geometry found = with_measured_force(builtin(), 1, 0.8);
  for (std::size_t i = 0; i < kStrings; ++i)
    EXPECT_DOUBLE_EQ(found.volts_per_newton[i], builtin().volts_per_newton[i] / 0.8);
  for (const double nonsense : {0.0, -1.0, 100.0, std::numeric_limits<double>::infinity()})
    refusal(Cause::argument, [&] { with_measured_force(builtin(), 1, nonsense); });
}

TEST(Calibration, AMirroredGeometryPullsTheOtherWayAndNoOther) {
  for (const std::string &name : builtin_geometries()) {
    const Geometry geometry = load_geometry(name);
    for (int axis = 0; axis < 3; ++axis) {
      const Geometry turned = mirrored(geometry, axis);
      EXPECT_NO_THROW(check_geometry(turned));
      for (std::size_t i = 0; i < kStrings; ++i)
        for (int other = 0; other < 3; ++other)
          EXPECT_EQ(turned.motors[i][other], (other == axis ? -1 : 1) * geometry.motors[i][other]);
    }
  }
}

/// 1.000.000,5
struct OtherDigits : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(Calibration, WhatIsSavedInAProgramWithAnotherLocaleIsReadable) {
  const std::string path = std::filesystem::temp_directory_path() / "spidar-locale-test.ini";
  const Geometry geometry = load_geometry("spidar-g6x3r");
  const std::locale before =
      std::locale::global(std::locale(std::locale::classic(), new OtherDigits));
  save_geometry(geometry, path);
  std::locale::global(before);
  const Geometry loaded = load_geometry(path);
  EXPECT_EQ(loaded.dac_limit, geometry.dac_limit);
  EXPECT_EQ(loaded.motors, geometry.motors);
  std::filesystem::remove(path);
}

TEST(Calibration, WhatIsSavedIsWhatIsLoaded) {
  const std::string path = std::filesystem::temp_directory_path() / "spidar-calibration-test.ini";
  Geometry geometry = mirrored(scaled(load_geometry("spidar-g6x5r"), 1.0 / 3), 1);
  geometry.button = {.bit = 2, .pressed = false};
  save_geometry(geometry, path);
  const Geometry loaded = load_geometry(path);
  EXPECT_EQ(loaded.motors, geometry.motors);
  EXPECT_EQ(loaded.attachments, geometry.attachments);
  EXPECT_EQ(loaded.metres_per_count, geometry.metres_per_count);
  EXPECT_EQ(loaded.volts_per_newton, geometry.volts_per_newton);
  EXPECT_EQ(loaded.tension_max, geometry.tension_max);
  EXPECT_EQ(loaded.dac_limit, geometry.dac_limit);
  EXPECT_EQ(loaded.workspace_half, geometry.workspace_half);
  ASSERT_TRUE(loaded.button);
  EXPECT_EQ(loaded.button->bit, 2);
  EXPECT_FALSE(loaded.button->pressed);
  std::filesystem::remove(path);
}

TEST(Calibration, AGeometryThatCannotBeDrivenIsNotWritten) {
  const std::string path = std::filesystem::temp_directory_path() / "spidar-calibration-none.ini";
  Geometry geometry = builtin();
  geometry.attachments.fill(Vector3::Zero());
  refusal(Cause::geometry, [&] { save_geometry(geometry, path); });
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_NE(refusal(Cause::not_found, [&] { save_geometry(builtin(), "/nowhere/a.ini"); })
                .find("--output"),
            std::string::npos);
}

// ---- the pull of spidar-calibrate ---------------------------------------------------------------

/// Where the hand of a unit is pulled, m. The device believes in the built-in geometry.
Vector3 pulled(const Geometry &truth, GentlePull &pull) {
  auto unit = std::make_unique<Simulator>(truth, parse_hand_script("hold:0,0,0"));
  const Simulator &grip = *unit;
  Device device(std::move(unit), builtin());
  for (std::int64_t tick = 1; tick <= 1500; ++tick) {
    device.exchange(tick * 1'000'000);
    device.command({pull.step(0.001), Vector3::Zero()});
  }
  return grip.pose().position;
}

TEST(GentlePull, PullsTheOtherWayOnceTheAxisIsMirrored) {
  for (int axis = 0; axis < 3; ++axis) {
    const Geometry truth = mirrored(builtin(), axis);
    Vector3 force = Vector3::Zero();
    force[axis] = 1;
    GentlePull pull;
    pull.want(force);
    EXPECT_LT(pulled(truth, pull)[axis], -0.0008) << axis; // 1 N against 1000 N/m
    pull.mirror(axis);
    const Vector3 place = pulled(truth, pull);
    EXPECT_GT(place[axis], 0.0008) << axis;
    EXPECT_LT((place - place[axis] * force).norm(), 0.0002) << axis;
  }
}

TEST(GentlePull, NeverStepsNotEvenWhenAnAxisIsMirrored) {
  GentlePull pull;
  pull.want({0.5, 0, 0});
  Vector3 before = Vector3::Zero();
  for (int tick = 0; tick < 2000; ++tick) {
    if (tick == 700)
      pull.mirror(0);
    if (tick == 1500)
      pull.want(Vector3::Zero());
    const Vector3 force = pull.step(0.001);
    ASSERT_LE((force - before).norm(), 0.002 + 1e-12) << tick;
    before = force;
  }
  EXPECT_EQ(before, Vector3::Zero());
  pull.want({0.5, 0, 0});
  pull.step(0.001);
  pull.release();
  EXPECT_EQ(pull.step(0.001), Vector3::Zero());
}

TEST(GentlePull, IsReleasedWhereItMustNotPull) {
  const auto ticks_to_release = [](const DeviceState &state, bool armed = true) {
    GentlePull pull;
    pull.want({0.5, 0, 0});
    pull.step(0.2);
    int ticks = 0;
    for (; ticks < 10 && pull.norm() > 0; ++ticks)
      pull.release_if_unsafe(state, armed);
    const bool pulls = pull.step(0.1).norm() > 0;
    EXPECT_EQ(pull.ended(), !pulls);
    pull.want({0.5, 0, 0});
    EXPECT_FALSE(pull.ended()) << "a new pull";
    return pulls ? 10 : ticks;
  };
  DeviceState state;
  state.valid = true;
  EXPECT_EQ(ticks_to_release(state), 10) << "never";
  state.valid = false;
  EXPECT_EQ(ticks_to_release(state), 3) << "without a pose";
  state.valid = true;
  state.interrupted = true;
  EXPECT_EQ(ticks_to_release(state), 1);
  state.interrupted = false;
  EXPECT_EQ(ticks_to_release(state, false), 1) << "let go";
  state.slipped = true;
  EXPECT_EQ(ticks_to_release(state), 1) << "the force stays off until it is calibrated";
}

TEST(GentlePull, ALostReplyDoesNotEndIt) {
  GentlePull pull;
  pull.want({0.5, 0, 0});
  for (int tick = 0; tick < 300; ++tick) {
    DeviceState state;
    state.valid = tick % 3 == 0;
    pull.release_if_unsafe(state, true);
    pull.step(0.001);
  }
  EXPECT_DOUBLE_EQ(pull.norm(), 0.5);
}

} // namespace spidar_calibration_test
