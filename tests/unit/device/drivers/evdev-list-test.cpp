// SPDX-License-Identifier: LGPL-2.1-or-later
#include "drivers/evdev-device.hpp"
#include "drivers/evdev-list.hpp"

#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <spidar/error.hpp>

namespace evdev_list_test {

namespace fs = std::filesystem;
using haptic::open_evdev;
using spidar::Cause;

// What the kernel shows of its input devices.
class EvdevList : public ::testing::Test {
protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "evdev-list-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }

  void add(const std::string &node, const std::string &name, const std::string &abs,
           const std::string &key, const std::string &ff) {
    const fs::path device = folder_ / node / "device";
    fs::create_directories(device / "capabilities");
    const auto write = [](const fs::path &file, const std::string &text) {
      std::ofstream(file) << text << '\n';
    };
    write(device / "name", name);
    write(device / "capabilities/abs", abs);
    write(device / "capabilities/key", key);
    write(device / "capabilities/ff", ff);
  }

  fs::path folder_;
};

constexpr const char *kSticksButtons = "ffff00000000 0 0 0 0"; // BTN_TRIGGER and on, bit 288
constexpr const char *kKeyboardKeys =
    "1000000000007 ff9f207ac14057ff febeffdfffefffff fffffffffffffffe";

TEST_F(EvdevList, FindsSticksWithForceFeedbackInTheOrderOfTheirNumbers) {
  add("event10", "Wheel", "3f", kSticksButtons,
      "107030000 0"); // FF_RUMBLE is bit 80
  add("event2", "Pad", "3003f", "7cdb000000000000 0 0 0 0", "107030000 0");
  add("event0", "Keyboard", "0", kKeyboardKeys, "0");
  add("event3", "Plain stick", "3f", kSticksButtons, "0");
  add("mouse0", "Mouse", "3", kSticksButtons, "107030000 0");
  const auto units = haptic::list_evdev(folder_);
  ASSERT_EQ(units.with_force.size(), 2U);
  EXPECT_EQ(units.with_force[0].path, "/dev/input/event2");
  EXPECT_EQ(units.with_force[0].name, "Pad");
  EXPECT_EQ(units.with_force[1].path, "/dev/input/event10");
  ASSERT_EQ(units.without.size(), 1U);
  EXPECT_EQ(units.without[0].name, "Plain stick");
}

TEST_F(EvdevList, AStickThatIsPluggedInAgainIsFoundAmongOthersUnderItsNewNumber) {
  add("event4", "Stick", "3f", kSticksButtons, "107030000 0");
  const std::string stick = haptic::list_evdev(folder_).with_force[0].identity;
  EXPECT_EQ(haptic::find_evdev(stick, folder_), "/dev/input/event4");
  fs::remove_all(folder_ / "event4");
  add("event2", "Wheel", "3f", kSticksButtons, "107030000 0");
  EXPECT_EQ(haptic::find_evdev(stick, folder_), "") << "the wheel is another one";
  add("event7", "Stick", "3f", kSticksButtons, "107030000 0");
  EXPECT_EQ(haptic::find_evdev(stick, folder_), "/dev/input/event7");
}

TEST_F(EvdevList, OtherForcesThanThoseThatLastAreNone) {
  add("event1", "Spring only", "3f", kSticksButtons,
      "200000 0"); // FF_DAMPER
  EXPECT_TRUE(haptic::list_evdev(folder_).with_force.empty());
}

TEST_F(EvdevList, WhereThereIsNothingItIsEmpty) {
  EXPECT_TRUE(haptic::list_evdev(folder_ / "nowhere").with_force.empty());
  add("event1", "", "", "", "");
  EXPECT_TRUE(haptic::list_evdev(folder_).with_force.empty());
  EXPECT_TRUE(haptic::list_evdev(folder_).without.empty());
}

TEST(EvdevPath, WhatIsNoInputDeviceSaysSo) {
  const auto cause_and_text = [](const std::string &path) {
    try {
      open_evdev(path);
    } catch (const spidar::Error &error) {
      return std::pair(error.cause(), std::string(error.what()));
    }
    return std::pair(Cause::io, std::string("opened"));
  };
  EXPECT_EQ(cause_and_text("/dev/input/event9999").first, Cause::not_found);
  EXPECT_EQ(cause_and_text("/dev/null").first, Cause::argument);
  EXPECT_NE(cause_and_text("/dev/null").second.find("not an input device"), std::string::npos);
}

} // namespace evdev_list_test
