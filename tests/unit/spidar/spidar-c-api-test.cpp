// SPDX-License-Identifier: LGPL-2.1-or-later
// The C API with the simulator: what it does, and what it refuses. The C compiler sees it in
// spidar/examples.
#include "spidar/spidar.h"

#include <gtest/gtest.h>
#include <limits>
#include <string>

namespace spidar_c_api_test {

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

TEST_F(CApi, LimitsTheForceAndSaysSo) {
  open();
  EXPECT_NEAR(state_under({3, 0, 0}).force[0], 1, 0.02);
  spidar_safety safety = SPIDAR_SAFETY_INIT;
  ASSERT_EQ(spidar_get_safety(device_, &safety), SPIDAR_OK);
  EXPECT_NEAR(safety.force[0], 1, 1e-9);
  EXPECT_NEAR(safety.work, 0, 1e-5) << "J: the hand rests";
  EXPECT_EQ(safety.limited_by, unsigned{SPIDAR_LIMIT_FORCE});
  EXPECT_EQ(safety.holds, 0U);
  EXPECT_EQ(safety.armed, 1);
  spidar_limits limits = SPIDAR_LIMITS_INIT;
  limits.force = 2;
  ASSERT_EQ(spidar_set_limits(device_, &limits), SPIDAR_OK);
  EXPECT_NEAR(state_under({3, 0, 0}).force[0], 2, 0.02);
  limits.force = 5.5;
  EXPECT_EQ(spidar_set_limits(device_, &limits), SPIDAR_E_ARGUMENT);
  EXPECT_NEAR(state_under({3, 0, 0}).force[0], 2, 0.02);
}

TEST_F(CApi, ReleasesAndArms) {
  open();
  state_under({0.5, 0, 0});
  ASSERT_EQ(spidar_release(device_), SPIDAR_OK);
  state_under({0.5, 0, 0});
  spidar_safety safety = SPIDAR_SAFETY_INIT;
  ASSERT_EQ(spidar_get_safety(device_, &safety), SPIDAR_OK);
  EXPECT_EQ(safety.force[0], 0);
  EXPECT_EQ(safety.armed, 0);
  EXPECT_EQ(safety.holds, unsigned{SPIDAR_HOLD_RELEASED});
  EXPECT_NE(std::string(spidar_hold_text(safety.holds)).find("spidar_arm()"), std::string::npos);
  ASSERT_EQ(spidar_arm(device_), SPIDAR_OK);
  for (int i = 0; i < 6; ++i)
    state_under({0.5, 0, 0});
  ASSERT_EQ(spidar_get_safety(device_, &safety), SPIDAR_OK);
  EXPECT_NEAR(safety.force[0], 0.5, 1e-9);
}

TEST_F(CApi, SwitchesTheSafetyOff) {
  open();
  ASSERT_EQ(spidar_switch_off_safety(device_, SPIDAR_SAFETY_ALL), SPIDAR_OK);
  EXPECT_NEAR(state_under({2, 0, 0}).force[0], 2, 0.02);
  spidar_safety safety = SPIDAR_SAFETY_INIT;
  ASSERT_EQ(spidar_get_safety(device_, &safety), SPIDAR_OK);
  EXPECT_EQ(safety.switched_off, SPIDAR_SAFETY_ALL);
}

TEST_F(CApi, ExplainsEveryHold) {
  EXPECT_STREQ(spidar_hold_text(0), "");
  for (const unsigned hold :
       {SPIDAR_HOLD_RELEASED, SPIDAR_HOLD_LET_GO, SPIDAR_HOLD_FAULTED, SPIDAR_HOLD_LATE,
        SPIDAR_HOLD_NO_POSE, SPIDAR_HOLD_NOT_FINITE, SPIDAR_HOLD_SLIPPED})
    EXPECT_GT(std::string(spidar_hold_text(hold)).size(), 10U) << hold;
  EXPECT_STREQ(spidar_hold_text(SPIDAR_HOLD_LATE | SPIDAR_HOLD_FAULTED),
               spidar_hold_text(SPIDAR_HOLD_FAULTED))
      << "what needs a person comes first";
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
  spidar_safety safety = SPIDAR_SAFETY_INIT;
  safety.struct_size += 8;
  EXPECT_EQ(spidar_get_safety(device_, &safety), SPIDAR_E_VERSION);
  spidar_limits limits = SPIDAR_LIMITS_INIT;
  limits.struct_size = 0;
  EXPECT_EQ(spidar_set_limits(device_, &limits), SPIDAR_E_VERSION);
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
  spidar_safety safety = SPIDAR_SAFETY_INIT;
  const spidar_limits limits = SPIDAR_LIMITS_INIT;
  EXPECT_EQ(spidar_get_safety(nullptr, &safety), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_set_limits(nullptr, &limits), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_arm(nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_release(nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_switch_off_safety(nullptr, 0), SPIDAR_E_NULL);
  open();
  EXPECT_EQ(spidar_get_state(device_, nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_describe(device_, nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_command(device_, nullptr, kNothing), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_command(device_, kNothing, nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_workspace(device_, nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_get_safety(device_, nullptr), SPIDAR_E_NULL);
  EXPECT_EQ(spidar_set_limits(device_, nullptr), SPIDAR_E_NULL);
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
  EXPECT_NE(std::string(spidar_error_text(SPIDAR_E_ARGUMENT)).find("spidar_limits"),
            std::string::npos)
      << "spidar_set_limits() gives it, too";
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

} // namespace spidar_c_api_test
