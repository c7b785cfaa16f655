// SPDX-License-Identifier: LGPL-2.1-or-later
// Unplugged at any instant: noticed, survived, and opened again when it is back.
#include "direct-fixture.hpp"
#include "loop-priority.hpp"
#include "report-line.hpp"

#include <random>

namespace {

using namespace test;

class Unplug : public DirectlyOnBusOf {};
INSTANTIATE_TEST_SUITE_P(Both, Unplug, ::testing::Values(Model::simple, Model::sh4), name_of_model);

TEST_P(Unplug, AHundredTimesAtRandomInstants) {
  const AsTheLoop priority;
  std::mt19937 random(GetParam() == Model::sh4 ? 13 : 14);
  double worst = 0; // ms
  for (int round = 0; round < 100; ++round) {
    plug(GetParam(), round % 16);
    auto controller = spidar::open_usb("");
    const auto wait = std::chrono::microseconds(random() % 3000);
    Clock::time_point unplugged;
    std::jthread hand([&] {
      std::this_thread::sleep_for(wait);
      unplugged = bus_->unplug(device_number_);
    });
    spidar::Counts counts{};
    const auto begin = Clock::now();
    while (controller->connected() && Clock::now() - begin < 60s) { // not for ever
      controller->exchange({}, counts);
      std::this_thread::yield(); // to the hand, which may have only this processor
    }
    const auto noticed = Clock::now();
    hand.join();
    ASSERT_FALSE(controller->connected()) << round;
    worst = std::max(worst, milliseconds(noticed - unplugged));
    ASSERT_FALSE(controller->exchange({}, counts));
  }
  report("unplug-noticed-ms", worst);
}

TEST_P(Unplug, ItIsThereAgainAfterwards) {
  plug(GetParam(), 2);
  auto controller = spidar::open_usb("2");
  bus_->unplug(device_number_);
  spidar::Counts counts{};
  controller->exchange({}, counts);
  EXPECT_FALSE(controller->connected());
  controller.reset();
  EXPECT_THROW(spidar::open_usb("2"), spidar::Error);
  plug(GetParam(), 2);
  EXPECT_TRUE(spidar::open_usb("2")->exchange({}, counts));
}

} // namespace
