// SPDX-License-Identifier: LGPL-2.1-or-later
// The C API with the simulator: what it does, and what it refuses. The C compiler sees it in
// spidar/examples.
#include "spidar/spidar.h"

#include <gtest/gtest.h>
#include <limits>
#include <string>

namespace {

constexpr double kNothing[3] = {0, 0, 0};

class CApi : public ::testing::Test {
protected:
  CApi() {
    options_.device = "sim";
    options_.sim_hand = "hold:0.5,0.25,0";
  }
  ~CApi() override { spidar_close(device_); }

  void open() { ASSERT_EQ(spidar_open(&options_, &device_), SPIDAR_OK) << spidar_open_error(); }

  /// The state after some ticks with this force.
  spidar_state state_under(const double (&force)[3]) {
    for (int tick = 0; tick < 100; ++tick) {
      EXPECT_EQ(spidar_command(device_, force, kNothing), SPIDAR_OK);
      EXPECT_EQ(spidar_exchange(device_, now_ += 1000000), SPIDAR_OK);
    }
    spidar_state state = SPIDAR_STATE_INIT;
    EXPECT_EQ(spidar_get_state(device_, &state), SPIDAR_OK);
    return state;
  }

  void expect_refused(int code, const char *text) {
    EXPECT_EQ(spidar_open(&options_, &device_), code);
    EXPECT_EQ(device_, nullptr);
    EXPECT_NE(std::string(spidar_open_error()).find(text), std::string::npos)
        << spidar_open_error();
  }

  spidar_options options_ = SPIDAR_OPTIONS_INIT;
  spidar_device *device_ = nullptr;
  std::int64_t now_ = 0; // ns
};

TEST_F(CApi, MeasuresThePose) {
  open();
  double half[3] = {};
  ASSERT_EQ(spidar_workspace(device_, half), SPIDAR_OK);
  const spidar_state state = state_under({0, 0, 0});
  constexpr double kStiffness = 1000; // N/m, of the simulated hand; minimum tension pulls it
  EXPECT_NEAR(state.position[0], 0.5 * half[0] + state.force[0] / kStiffness, 1e-4);
  EXPECT_NEAR(state.position[1], 0.25 * half[1] + state.force[1] / kStiffness, 1e-4);
  EXPECT_NEAR(state.rotation[0], 1, 1e-3);
  EXPECT_NEAR(state.rotation[4], 1, 1e-3);
  EXPECT_EQ(state.valid, 1);
  EXPECT_EQ(state.connected, 1);
  EXPECT_EQ(state.interrupted, 0);
  EXPECT_NE(state.counts[0], 0);
}

TEST_F(CApi, ExertsTheForce) {
  open();
  const spidar_state state = state_under({0.3, 0.4, 0});
  EXPECT_NEAR(state.force[0], 0.3, 0.02);
  EXPECT_NEAR(state.force[1], 0.4, 0.02);
  EXPECT_NEAR(state.force[2], 0, 0.02);
  EXPECT_EQ(state.feasible, 1);
}

TEST_F(CApi, CountsAForceThatIsNotFiniteAsZero) {
  open();
  const spidar_state zero = state_under({0, 0, 0});
  state_under({0.3, 0, 0});
  const spidar_state state = state_under({0.3, std::numeric_limits<double>::quiet_NaN(), 0});
  for (int string = 0; string < SPIDAR_STRINGS; ++string)
    EXPECT_NEAR(state.tensions[string], zero.tensions[string], 0.01) << string;
}

TEST_F(CApi, CalibratesToTheCentre) {
  open();
  state_under({0, 0, 0});
  ASSERT_EQ(spidar_calibrate(device_), SPIDAR_OK);
  EXPECT_NEAR(state_under({0, 0, 0}).position[0], 0, 1e-3) << "from 12.5 mm";
}

TEST_F(CApi, DescribesTheDevice) {
  open();
  const char *text = nullptr;
  ASSERT_EQ(spidar_describe(device_, &text), SPIDAR_OK);
  EXPECT_STREQ(text, "simulated SPIDAR-G (spidar-g6x3r)");
}

TEST_F(CApi, RefusesStructsOfAnotherVersion) {
  options_.struct_size = sizeof options_ - sizeof(double);
  expect_refused(SPIDAR_E_VERSION, "SPIDAR_OPTIONS_INIT");
  options_.struct_size = 0;
  expect_refused(SPIDAR_E_VERSION, "SPIDAR_OPTIONS_INIT");
  options_.struct_size = sizeof options_;
  open();
  spidar_state state = SPIDAR_STATE_INIT;
  state.struct_size += 8;
  state.valid = 42;
  EXPECT_EQ(spidar_get_state(device_, &state), SPIDAR_E_VERSION);
  EXPECT_EQ(state.valid, 42) << "nothing is written to a struct that is not known";
}

TEST_F(CApi, RefusesNullPointers) {
  EXPECT_EQ(spidar_open(nullptr, &device_), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_open(&options_, nullptr), SPIDAR_E_NULL);
  spidar_state state = SPIDAR_STATE_INIT;
  const char *text = nullptr;
  double half[3] = {};
  EXPECT_EQ(spidar_close(nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_exchange(nullptr, 0), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_calibrate(nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_get_state(nullptr, &state), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_describe(nullptr, &text), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_command(nullptr, kNothing, kNothing), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_workspace(nullptr, half), SPIDAR_E_NULL);
  open();
  EXPECT_EQ(spidar_get_state(device_, nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_describe(device_, nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_command(device_, nullptr, kNothing), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_command(device_, kNothing, nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_workspace(device_, nullptr), SPIDAR_E_NULL);
}

TEST_F(CApi, NamesWhatIsWrongWithTheOptions) {
  options_.device = "serial";
  expect_refused(SPIDAR_E_ARGUMENT, "'serial' is not known");
  options_.device = "usb:16";
  expect_refused(SPIDAR_E_ARGUMENT, "0 to 15");
  options_.device = "sim";
  options_.sim_hand = "juggle";
  expect_refused(SPIDAR_E_ARGUMENT, "Use hold:");
  options_.sim_hand = nullptr;
  options_.geometry = "nothing";
  expect_refused(SPIDAR_E_NOT_FOUND, "No geometry 'nothing'");
  options_.geometry = nullptr;
  options_.period = std::numeric_limits<double>::quiet_NaN();
  expect_refused(SPIDAR_E_ARGUMENT, "period");
}

TEST_F(CApi, ExplainsEveryCode) {
  const std::string unknown = spidar_error_text(1);
  EXPECT_EQ(unknown, spidar_error_text(-1000));
  for (int code = SPIDAR_E_MEMORY; code <= SPIDAR_OK; ++code) {
    EXPECT_NE(spidar_error_text(code), unknown) << code;
    EXPECT_GT(std::string(spidar_error_text(code)).size(), 10U) << code;
  }
}

TEST_F(CApi, HasTheVersionOfItsHeaders) {
  EXPECT_STREQ(spidar_version(), SPIDAR_VERSION);
  EXPECT_EQ(SPIDAR_VERSION, std::to_string(SPIDAR_VERSION_MAJOR) + "." +
                                std::to_string(SPIDAR_VERSION_MINOR) + "." +
                                std::to_string(SPIDAR_VERSION_MICRO));
  EXPECT_TRUE(SPIDAR_CHECK_VERSION(SPIDAR_VERSION_MAJOR, SPIDAR_VERSION_MINOR, 0));
  EXPECT_FALSE(SPIDAR_CHECK_VERSION(SPIDAR_VERSION_MAJOR, SPIDAR_VERSION_MINOR + 1, 0));
  EXPECT_FALSE(SPIDAR_CHECK_VERSION(SPIDAR_VERSION_MAJOR + 1, 0, 0));
}

} // namespace
