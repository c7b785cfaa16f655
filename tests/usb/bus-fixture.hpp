// SPDX-License-Identifier: LGPL-2.1-or-later
// A mocked bus with a unit on it. Exchanges may take 250 ms, so that they fail for no other reason
// than the fault of a test, however busy the machine is.
#pragma once

#include "mock-bus.hpp"
#include "report-line.hpp"

#include <chrono>
#include <cstdlib>
#include <gtest/gtest.h>
#include <spidar/device.hpp>
#include <spidar/usb.hpp>
#include <thread>

namespace test {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

inline double milliseconds(Clock::duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

class OnBus : public ::testing::Test {
protected:
  void SetUp() override {
    if (!mocking())
      GTEST_SKIP() << "needs umockdev: run it by 'meson test', or under umockdev-wrapper";
    allow_exchanges(250ms);
    bus_ = std::make_unique<MockBus>();
  }
  void TearDown() override {
    bus_.reset();
    unsetenv("SPIDAR_USB_TIMEOUT");
  }

  /// How long an exchange may take, of devices opened from now on.
  static void allow_exchanges(std::chrono::milliseconds time) {
    setenv("SPIDAR_USB_TIMEOUT", std::to_string(time.count()).c_str(), 1);
  }

  int plug(Model model, int rotary_switch) {
    unit_ = std::make_shared<MockUnit>(model, rotary_switch);
    return device_number_ = bus_->plug(unit_);
  }

  static std::unique_ptr<spidar::Device> open_device(const std::string &id = "") {
    return std::make_unique<spidar::Device>(spidar::open_usb(id),
                                            spidar::load_geometry(spidar::kDefaultGeometry));
  }

  /// The error that open_usb() throws. Reports how long it took.
  static spidar::Error refusal(const std::string &id) {
    const auto begin = Clock::now();
    try {
      spidar::open_usb(id);
    } catch (const spidar::Error &error) {
      report("refusal-ms", milliseconds(Clock::now() - begin));
      return error;
    }
    ADD_FAILURE() << "opened";
    return {spidar::Cause::io, ""};
  }

  static void expect_words(const spidar::Error &error, spidar::Cause cause,
                           std::initializer_list<const char *> words) {
    EXPECT_EQ(error.cause(), cause) << error.what();
    for (const char *word : words)
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos)
          << "'" << word << "' is missing in: " << error.what();
  }

  std::unique_ptr<MockBus> bus_;
  std::shared_ptr<MockUnit> unit_;
  int device_number_ = 0;
};

class OnBusOf : public OnBus, public ::testing::WithParamInterface<Model> {
protected:
  static std::size_t packet_size() { return GetParam() == Model::sh4 ? 512 : 32; }
};

inline std::string name_of_model(const ::testing::TestParamInfo<Model> &info) {
  return info.param == Model::sh4 ? "Sh4" : "Simple";
}

} // namespace test
