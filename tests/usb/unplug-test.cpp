// SPDX-License-Identifier: LGPL-2.1-or-later
// Unplugged at any instant: noticed, survived, and opened again when it is back.
#include "direct-fixture.hpp"
#include "loop-priority.hpp"
#include "report-line.hpp"

#include <random>

namespace unplug_test {

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
    // In the midst of an exchange, or between two.
    const auto after = random() % 30; // exchanges
    const auto then = random() % 300; // turns of the hand's thread
    std::atomic<unsigned> exchanges = 0;
    Clock::time_point unplugged;
    std::jthread hand([&] {
      while (exchanges < after)
        std::this_thread::yield();
      for (unsigned turn = 0; turn < then; ++turn)
        std::this_thread::yield();
      unplugged = bus_->unplug(device_number_);
    });
    spidar::Counts counts{};
    while (controller->connected()) {
      controller->exchange({}, counts);
      ++exchanges;
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

} // namespace unplug_test
