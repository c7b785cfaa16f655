// SPDX-License-Identifier: LGPL-2.1-or-later
// The button of a grip on USB, which the geometry names: as dead-man switch, and for the pointer.
#include "direct-fixture.hpp"

#include "drivers/device-choice.hpp"
#include "loop/haptic-loop.hpp"
#include "temporary-folder.hpp"

#include <spidar/calibration.hpp>

namespace button_test {

using namespace test;
using haptic::DeadMan;

constexpr int kPin = 2;

class Button : public DirectlyOnBusOf {
protected:
  /// A unit with its button at kPin, which reads `level` while it is pressed.
  void plug_with_button(bool level) {
    plug(GetParam(), 6);
    level_ = level;
    spidar::Geometry geometry = spidar::load_geometry(spidar::kDefaultGeometry);
    geometry.button = {.bit = kPin, .pressed = level};
    spidar::save_geometry(geometry, geometry_);
  }
  void press(bool pressed) {
    unit_->use([&](emulator::Unit &unit) { unit.firmware().set_input(kPin, pressed == level_); });
  }
  /// The loop plays a film in which everything moves to the right.
  void play(DeadMan dead_man) {
    device_ = haptic::open_device({.device = "usb:6", .geometry = geometry_, .dead_man = dead_man})
                  .device;
    loop_.prepare({.device = device_.get(), .dead_man = dead_man == DeadMan::button});
    loop_.unhold(haptic::kHoldClosed | haptic::kHoldPaused);
  }
  void TearDown() override {
    loop_.prepare({}); // the device goes before the bus
    device_.reset();
    DirectlyOnBusOf::TearDown();
  }
  void run(int ticks) {
    haptic::MotionSample sample;
    sample.velocity_x = 300;
    sample.confidence = 1;
    sample.interval = 33 * kMs;
    sample.frame_width = 352;
    sample.frame_height = 288;
    for (int i = 0; i < ticks; ++i, now_ += kMs) {
      if (i % 33 == 0)
        loop_.submit(sample, now_);
      loop_.tick(now_, now_);
    }
  }
  bool has_force() const { return loop_.wrench().force.x() > 0.3; }

  static constexpr std::int64_t kMs = 1'000'000; // ns

  TemporaryFolder folder_;
  const std::string geometry_ = folder_.path_of("with-button.ini");
  bool level_ = true;
  std::unique_ptr<spidar::HapticDevice> device_;
  haptic::HapticLoop loop_;
  std::int64_t now_ = 1000 * kMs;
};
INSTANTIATE_TEST_SUITE_P(Both, Button, ::testing::Values(Model::simple, Model::sh4), name_of_model);

TEST_P(Button, OfTheGeometryIsADeadManSwitchWhateverItsLevel) {
  for (const bool level : {true, false}) {
    plug_with_button(level);
    press(false);
    play(DeadMan::button);
    run(500);
    EXPECT_TRUE(loop_.silent());
    for (int i = 0; i < 2; ++i) {
      press(true);
      run(500);
      EXPECT_TRUE(has_force()) << level;
      press(false);
      run(100);
      EXPECT_TRUE(loop_.silent()) << level;
    }
    loop_.prepare({});
    device_.reset();
    bus_->unplug(device_number_);
  }
}

TEST_P(Button, OfTheGeometryPressesWithThePointer) {
  plug_with_button(true);
  press(false);
  play(DeadMan::none);
  for (const bool pressed : {false, true, false}) {
    press(pressed);
    run(2);
    EXPECT_EQ(loop_.hand().pressed, pressed);
  }
}

// A wrong pin, or a broken cable, may read as pressed for ever.
TEST_P(Button, CountsOnceItWasSeenReleased) {
  plug_with_button(true);
  press(true);
  play(DeadMan::button);
  run(500);
  EXPECT_TRUE(loop_.silent());
  press(false);
  run(10);
  press(true);
  run(500);
  EXPECT_TRUE(has_force());
}

TEST_P(Button, IsReleasedWhenTheDeviceDoesNotAnswer) {
  plug_with_button(true);
  press(false);
  play(DeadMan::button);
  run(5);
  press(true);
  run(500);
  unit_->faults([](Faults &faults) { faults.stalled_replies = 1; });
  run(1);
  EXPECT_NE(loop_.reasons() & haptic::kHoldDeadMan, 0U);
}

TEST_P(Button, ThatNoGeometryNamesIsRefusedWithTheKeysThatNameIt) {
  plug(GetParam(), 6);
  try {
    haptic::open_device({.device = "usb:6", .dead_man = DeadMan::button});
    ADD_FAILURE() << "opened";
  } catch (const spidar::Error &error) {
    expect_words(error, spidar::Cause::argument, {"switch 6", "button-bit", "button-pressed"});
  }
}

} // namespace button_test
