// SPDX-License-Identifier: LGPL-2.1-or-later
// What cannot be opened is refused with its own message and remedy, and nothing moves.
#include "bus-fixture.hpp"

#include <unistd.h>

namespace refusals_test {

using namespace test;
using spidar::Cause;

class Refusals : public OnBus {
protected:
  /// A controller on which nothing but `allowed` words have ever been.
  std::shared_ptr<MockUnit> plug_watched(Model model, int rotary_switch) {
    plug(model, rotary_switch);
    const std::size_t offset = model == Model::sh4 ? 2 : 1;
    unit_->faults([this, offset, model](Faults &faults) {
      faults.watch = [this, offset, model](std::span<const std::uint8_t> packet) {
        if (model == Model::simple && packet[0] != 0x52)
          return;
        for (std::size_t i = offset; i < offset + 16; ++i)
          moved_ = moved_ || packet[i] != 0;
      };
    });
    return unit_;
  }
  void TearDown() override {
    EXPECT_FALSE(moved_);
    OnBus::TearDown();
  }
  std::atomic<bool> moved_ = false;
};

TEST_F(Refusals, NothingPluggedIn) {
  expect_words(refusal(""), Cause::not_found, {"Plug it in", "0cec:0203"});
}

TEST_F(Refusals, TwoUnitsWithTheSameSwitch) {
  plug_watched(Model::simple, 4);
  plug_watched(Model::sh4, 4);
  plug_watched(Model::sh4, 5);
  expect_words(refusal("4"), Cause::argument,
               {"Two SPIDAR-Gs", "device 5", "device 6", "Turn the switch"});
  EXPECT_NO_THROW(spidar::open_usb("5"));
}

TEST_F(Refusals, AnotherSwitchThanTheWantedOne) {
  plug_watched(Model::simple, 10);
  expect_words(refusal("3"), Cause::not_found, {"rotary switch at 3", "Found", "switch 10"});
}

TEST_F(Refusals, HeldByAnotherProgram) {
  plug_watched(Model::sh4, 0);
  bus_->hold(device_number_, true);
  expect_words(refusal(""), Cause::busy, {"in use by", "Close that program"});
}

TEST_F(Refusals, HeldByThisProgramAlready) {
  plug_watched(Model::sh4, 0);
  const auto first = spidar::open_usb("");
  expect_words(refusal(""), Cause::busy, {"in use by this program"});
}

TEST_F(Refusals, MissingPermission) {
  plug_watched(Model::simple, 0);
  bus_->forbid(device_number_);
  const bool root = geteuid() == 0;
  ASSERT_TRUE(!root || seteuid(65534) == 0);
  const spidar::Error error = refusal("");
  ASSERT_TRUE(!root || seteuid(0) == 0);
  expect_words(error, Cause::permission, {"TAG+=\"uaccess\"", "70-spidar.rules"});
}

TEST_F(Refusals, AUnitThatAnswersNothing) {
  allow_exchanges(2ms);
  for (const Model model : {Model::simple, Model::sh4}) {
    plug_watched(model, 0);
    unit_->faults([](Faults &faults) { faults.silent = true; });
    expect_words(refusal(""), Cause::io, {"does not answer", "off and on"});
    bus_->unplug(device_number_);
  }
}

TEST_F(Refusals, AUnitThatTakesNothing) {
  allow_exchanges(2ms);
  plug_watched(Model::simple, 0);
  unit_->faults([](Faults &faults) { faults.refuse_out = true; });
  expect_words(refusal(""), Cause::io, {"does not answer"});
}

TEST_F(Refusals, TheOldControllerIsNamed) {
  bus_->plug(std::make_shared<MockUnit>(Model::simple, 0), 0x0cec, 0x0201);
  expect_words(refusal(""), Cause::not_found, {"0cec:0201", "cannot be driven"});
  const auto units = spidar::list_usb();
  ASSERT_EQ(units.size(), 1U);
  ASSERT_TRUE(units[0].problem);
  expect_words(*units[0].problem, Cause::io, {"0cec:0201", "cannot be driven"});
}

TEST_F(Refusals, AnImpossibleGeometryBeforeAnythingMoves) {
  plug_watched(Model::simple, 0);
  spidar::Geometry geometry = spidar::load_geometry(spidar::kDefaultGeometry);
  geometry.attachments.fill(spidar::Vector3::Zero());
  try {
    spidar::Device device(spidar::open_usb(""), geometry);
    FAIL();
  } catch (const spidar::Error &error) {
    expect_words(error, Cause::geometry, {"cannot pull in every direction", "turn about"});
  }
}

TEST_F(Refusals, WithoutAGuardianNothingMoves) {
  plug_watched(Model::simple, 0);
  const char *guardian = getenv("SPIDAR_GUARDIAN");
  const std::string before = guardian ? guardian : "";
  setenv("SPIDAR_GUARDIAN", "/nowhere/spidar-guardian", 1);
  try {
    open_device();
    ADD_FAILURE();
  } catch (const spidar::Error &error) {
    expect_words(error, Cause::io, {"/nowhere/spidar-guardian", "SPIDAR_GUARDIAN"});
  }
  setenv("SPIDAR_GUARDIAN", before.c_str(), 1);
}

TEST_F(Refusals, TheListNamesEveryUnitAndWhatIsWrongWithIt) {
  plug(Model::simple, 10);
  const int held = plug(Model::sh4, 2);
  bus_->hold(held, true);
  const auto units = spidar::list_usb();
  ASSERT_EQ(units.size(), 2U);
  for (const spidar::UsbUnit &unit : units) {
    EXPECT_EQ(unit.bus, 1);
    EXPECT_EQ(unit.port, "1-" + std::to_string(unit.address));
    if (unit.address == held) {
      EXPECT_EQ(unit.model, "USB2.0 SH4");
      EXPECT_FALSE(unit.switch_at);
      ASSERT_TRUE(unit.problem);
      EXPECT_EQ(unit.problem->cause(), Cause::busy);
    } else {
      EXPECT_EQ(unit.model, "USB2.0 Simple");
      EXPECT_EQ(unit.switch_at, 10);
      EXPECT_FALSE(unit.problem);
    }
  }
}

TEST_F(Refusals, AnotherVendorIsTakenOnlyIfToldTo) {
  bus_->plug(std::make_shared<MockUnit>(Model::simple, 7), 0x04b4, 0x8613);
  expect_words(refusal(""), Cause::not_found, {"Plug it in"});
  setenv("SPIDAR_USB_ID", "04b4:8613=simple", 1);
  EXPECT_NO_THROW(spidar::open_usb("7"));
  setenv("SPIDAR_USB_ID", "04b4:8613=smart", 1);
  expect_words(refusal(""), Cause::argument, {"SPIDAR_USB_ID", "=sh4"});
  EXPECT_THROW(spidar::usb_present(), spidar::Error) << "else a simulated device would be taken";
  unsetenv("SPIDAR_USB_ID");
}

TEST_F(Refusals, AKnownUnitThatIsNamedAgainIsOneUnit) {
  bus_->plug(std::make_shared<MockUnit>(Model::sh4, 7), 0x0cec, 0x0205);
  setenv("SPIDAR_USB_ID", "0cec:0205=sh4", 1);
  const auto units = spidar::list_usb();
  unsetenv("SPIDAR_USB_ID");
  ASSERT_EQ(units.size(), 1U);
  EXPECT_FALSE(units[0].problem);
}

} // namespace refusals_test
