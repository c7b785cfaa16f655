// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/stick.hpp"

#include <gtest/gtest.h>
#include <memory>

namespace stick_test {

using haptic::Stick;

/// A device that only libevdev knows.
class Device {
public:
  Device &axis(unsigned code, int least, int most) {
    const input_absinfo info{
        .value = 0, .minimum = least, .maximum = most, .fuzz = 0, .flat = 0, .resolution = 0};
    libevdev_enable_event_code(device_.get(), EV_ABS, code, &info);
    return *this;
  }
  Device &button(unsigned code) {
    libevdev_enable_event_code(device_.get(), EV_KEY, code, nullptr);
    return *this;
  }
  void move(unsigned code, int value) {
    ASSERT_EQ(libevdev_set_event_value(device_.get(), EV_ABS, code, value), 0);
  }
  void press(unsigned code, bool pressed) {
    ASSERT_EQ(libevdev_set_event_value(device_.get(), EV_KEY, code, pressed), 0);
  }
  const libevdev *get() const { return device_.get(); }

private:
  struct Free {
    void operator()(libevdev *device) const { libevdev_free(device); }
  };
  std::unique_ptr<libevdev, Free> device_{libevdev_new()};
};

TEST(Stick, ItsPlaceIsZeroInTheMiddleAndOneAtTheEndsWithYUp) {
  Device device;
  device.axis(ABS_X, 0, 1023).axis(ABS_Y, 0, 1023);
  Stick stick(device.get());
  ASSERT_TRUE(stick.has_x() && stick.has_y());
  EXPECT_DOUBLE_EQ(stick.step(), 1 / 511.5);
  device.move(ABS_X, 1023);
  device.move(ABS_Y, 0);
  EXPECT_EQ(stick.read(device.get()).place, spidar::Vector3(1, 1, 0));
  device.move(ABS_X, 512);
  EXPECT_NEAR(stick.read(device.get()).place.x(), 0, stick.step());
}

TEST(Stick, TheAxesOfAGamepadLieAboutZero) {
  Device device;
  device.axis(ABS_X, -32768, 32767).axis(ABS_Y, -32768, 32767);
  Stick stick(device.get());
  ASSERT_TRUE(stick.has_y());
  device.move(ABS_Y, 32767);
  EXPECT_EQ(stick.read(device.get()).place.y(), -1);
}

TEST(Stick, ThePedalsOfAWheelAreNoSecondAxis) {
  Device wheel; // a G27: clutch on ABS_Y, which rests at 255
  wheel.axis(ABS_X, 0, 16383).axis(ABS_Y, 0, 255).axis(ABS_Z, 0, 255).axis(ABS_RZ, 0, 255);
  wheel.move(ABS_Y, 255);
  Stick stick(wheel.get());
  ASSERT_TRUE(stick.has_x());
  EXPECT_FALSE(stick.has_y());
  wheel.move(ABS_X, 16383);
  EXPECT_EQ(stick.read(wheel.get()).place, spidar::Vector3(1, 0, 0));
}

TEST(Stick, AWheelMayHaveAnAxisOfItsOwnName) {
  Device wheel;
  wheel.axis(ABS_WHEEL, -100, 100).axis(ABS_GAS, 0, 255);
  wheel.move(ABS_WHEEL, -50);
  EXPECT_EQ(Stick(wheel.get()).read(wheel.get()).place.x(), -0.5);
}

TEST(Stick, WithoutAnAxisItHasNoPlace) {
  Device device;
  device.button(BTN_JOYSTICK);
  Stick stick(device.get());
  EXPECT_FALSE(stick.has_x());
  EXPECT_EQ(stick.step(), 0);
  EXPECT_EQ(stick.read(device.get()).place, spidar::Vector3(0, 0, 0));
}

TEST(Stick, EachButtonOfAHandPresses) {
  for (const unsigned code : {BTN_TRIGGER, BTN_BASE6, BTN_GAMEPAD, BTN_THUMBR}) {
    Device device;
    device.axis(ABS_X, 0, 255).button(code);
    Stick stick(device.get());
    EXPECT_TRUE(stick.has_button());
    EXPECT_FALSE(stick.read(device.get()).pressed);
    device.press(code, true);
    EXPECT_TRUE(stick.read(device.get()).pressed) << code;
    device.press(code, false);
    EXPECT_FALSE(stick.read(device.get()).pressed) << code;
  }
}

TEST(Stick, AGearLeverIsNoButton) {
  for (const unsigned code : {BTN_BASE6 + 1U, unsigned{BTN_DEAD}, unsigned{BTN_GEAR_UP}}) {
    Device wheel;
    wheel.axis(ABS_X, 0, 16383).button(code);
    Stick stick(wheel.get());
    EXPECT_FALSE(stick.has_button()) << code;
    EXPECT_FALSE(stick.read(wheel.get()).pressed);
    wheel.press(code, true);
    EXPECT_FALSE(stick.read(wheel.get()).pressed) << code;
  }
}

TEST(Stick, ASwitchThatIsOnFromTheBeginningPressesNothingUntilItWasOff) {
  Device device;
  device.axis(ABS_X, 0, 255).button(BTN_TRIGGER).button(BTN_THUMB);
  device.press(BTN_THUMB, true);
  Stick stick(device.get());
  EXPECT_FALSE(stick.read(device.get()).pressed);
  device.press(BTN_TRIGGER, true);
  EXPECT_TRUE(stick.read(device.get()).pressed) << "the other button";
  device.press(BTN_TRIGGER, false);
  EXPECT_FALSE(stick.read(device.get()).pressed);
  device.press(BTN_THUMB, false);
  EXPECT_FALSE(stick.read(device.get()).pressed);
  device.press(BTN_THUMB, true);
  EXPECT_TRUE(stick.read(device.get()).pressed);
}

} // namespace stick_test
