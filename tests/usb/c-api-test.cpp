// SPDX-License-Identifier: LGPL-2.1-or-later
// The C API with an emulated controller.
#include "bus-fixture.hpp"

#include <spidar/spidar.h>

namespace c_api_test {

using namespace test;

class CApi : public OnBusOf {};
INSTANTIATE_TEST_SUITE_P(Both, CApi, ::testing::Values(Model::simple, Model::sh4), name_of_model);

TEST_P(CApi, DrivesTheUnitUntilItIsUnplugged) {
  plug(GetParam(), 3);
  spidar_options options = SPIDAR_OPTIONS_INIT;
  options.device = "usb:3";
  spidar_device *device = nullptr;
  ASSERT_EQ(spidar_open(&options, &device), SPIDAR_OK) << spidar_open_error();
  const char *name = nullptr;
  ASSERT_EQ(spidar_describe(device, &name), SPIDAR_OK);
  EXPECT_NE(std::string(name).find("switch 3"), std::string::npos) << name;

  constexpr double kForce[3] = {0.5, 0, 0};
  constexpr double kTorque[3] = {0, 0, 0};
  const spidar::DacWords rest = unit_->words();
  ASSERT_EQ(spidar_command(device, kForce, kTorque), SPIDAR_OK);
  const std::int64_t begin = spidar::monotonic_time();
  for (int tick = 0; tick < 50; ++tick) // the force begins from zero
    ASSERT_EQ(spidar_exchange(device, begin + 1000000 * tick), SPIDAR_OK);
  EXPECT_NE(unit_->words(), rest);

  bus_->unplug(device_number_);
  EXPECT_EQ(spidar_exchange(device, spidar::monotonic_time()), SPIDAR_E_IO);
  spidar_state state = SPIDAR_STATE_INIT;
  ASSERT_EQ(spidar_get_state(device, &state), SPIDAR_OK);
  EXPECT_EQ(state.valid, 0);
  EXPECT_EQ(state.connected, 0);
  EXPECT_EQ(spidar_close(device), SPIDAR_OK);
}

TEST_P(CApi, LeavesTheMotorsAtRest) {
  plug(GetParam(), 3);
  spidar_options options = SPIDAR_OPTIONS_INIT;
  spidar_device *device = nullptr;
  ASSERT_EQ(spidar_open(&options, &device), SPIDAR_OK) << spidar_open_error();
  const spidar::DacWords rest = unit_->words();
  constexpr double kForce[3] = {0.5, 0, 0};
  constexpr double kTorque[3] = {0, 0, 0};
  spidar_command(device, kForce, kTorque);
  const std::int64_t begin = spidar::monotonic_time();
  for (int tick = 0; tick < 50; ++tick)
    spidar_exchange(device, begin + 1000000 * tick);
  EXPECT_NE(unit_->words(), rest);
  EXPECT_EQ(spidar_close(device), SPIDAR_OK);
  EXPECT_EQ(unit_->words(), rest);
}

TEST_P(CApi, SaysWhoMayNotOpenIt) {
  spidar_options options = SPIDAR_OPTIONS_INIT;
  spidar_device *device = nullptr;
  EXPECT_EQ(spidar_open(&options, &device), SPIDAR_E_NOT_FOUND);
  EXPECT_NE(std::string(spidar_open_error()).find("Plug it in"), std::string::npos);
  plug(GetParam(), 3);
  bus_->hold(device_number_, true);
  EXPECT_EQ(spidar_open(&options, &device), SPIDAR_E_BUSY);
  EXPECT_NE(std::string(spidar_open_error()).find("Close that program"), std::string::npos);
}

} // namespace c_api_test
