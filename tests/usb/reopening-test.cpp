// SPDX-License-Identifier: LGPL-2.1-or-later
// A device that was unplugged is opened again, and no other in its place.
#include "bus-fixture.hpp"

#include "drivers/device-choice.hpp"

namespace reopening_test {

using test::Model;

class ReopeningOnUsb : public test::OnBus, public ::testing::WithParamInterface<const char *> {
protected:
  void expect_away() const {
    try {
      haptic::reopen_device(choice_, identity_);
      ADD_FAILURE() << "opened another one";
    } catch (const spidar::Error &error) {
      EXPECT_EQ(error.cause(), spidar::Cause::not_found) << error.what();
    }
  }

  const haptic::DeviceChoice choice_{.device = GetParam()};
  std::string identity_;
};

TEST_P(ReopeningOnUsb, OnlyTheSameModelWithTheSameSwitchWillDo) {
  const int lost = plug(Model::simple, 6);
  identity_ = haptic::open_device(choice_).device->identity();
  EXPECT_NE(identity_, "");
  bus_->unplug(lost);
  expect_away();
  plug(Model::simple, 5);
  expect_away();
  const int alike = plug(Model::sh4, 6);
  expect_away();
  bus_->unplug(alike);
  plug(Model::simple, 6);
  EXPECT_EQ(haptic::reopen_device(choice_, identity_)->identity(), identity_);
}

INSTANTIATE_TEST_SUITE_P(Choices, ReopeningOnUsb, ::testing::Values("auto", "usb"));

} // namespace reopening_test
