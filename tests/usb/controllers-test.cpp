// SPDX-License-Identifier: LGPL-2.1-or-later
// The controllers over the real libusb, on a bus that umockdev shows it.
#include "bus-fixture.hpp"

namespace controllers_test {

using namespace test;
using spidar::Counts;
using spidar::DacWords;

class Controllers : public OnBusOf {};
INSTANTIATE_TEST_SUITE_P(Both, Controllers, ::testing::Values(Model::simple, Model::sh4),
                         name_of_model);

TEST_P(Controllers, AreFoundByTheirEndpointsAndNamedByModelSwitchAndPlace) {
  plug(GetParam(), 10);
  const auto controller = spidar::open_usb("10");
  const std::string model = GetParam() == Model::sh4 ? "USB2.0 SH4" : "USB2.0 Simple";
  EXPECT_EQ(controller->description(),
            "SPIDAR-G, controller " + model + ", switch 10, USB bus 1 device 5");
}

TEST_P(Controllers, WordsReachTheMotorsWithinTheExchange) {
  plug(GetParam(), 0);
  const auto controller = spidar::open_usb("");
  const DacWords words = {1, 45, 4095, 0, -1, -4095, 300, 2};
  Counts counts{};
  ASSERT_TRUE(controller->exchange(words, counts));
  EXPECT_EQ(unit_->words(), words);
}

TEST_P(Controllers, CountsFollowTheStringsThroughTheWrapOfTheCounter) {
  plug(GetParam(), 0);
  const auto controller = spidar::open_usb("");
  Counts start{};
  ASSERT_TRUE(controller->exchange({}, start));
  // Turns of 16 bits in both directions; the plant stands still.
  for (const int direction : {1, -1}) {
    for (int step = 0; step <= 20; ++step) {
      const int moved = direction * step * 10'000;
      unit_->faults([&](Faults &faults) { faults.offset.fill(moved); });
      Counts counts{};
      ASSERT_TRUE(controller->exchange({}, counts));
      for (std::size_t i = 0; i < counts.size(); ++i)
        ASSERT_NEAR(counts[i], start[i] + moved, 3) << i;
    }
    unit_->faults([](Faults &faults) { faults.offset.fill(0); });
    for (int step = 20; step >= 0; --step) {
      unit_->faults([&](Faults &f) { f.offset.fill(direction * step * 10'000); });
      Counts counts{};
      ASSERT_TRUE(controller->exchange({}, counts));
    }
  }
}

TEST_P(Controllers, RepliesLeftByAProgramBeforeAreNotTakenForOurs) {
  plug(GetParam(), 3);
  for (int i = 0; i < 5; ++i)
    unit_->leave_reply(Bytes(packet_size(), 0x77)); // switch 7, absurd counters
  const auto controller = spidar::open_usb("3");
  Counts first{};
  Counts second{};
  ASSERT_TRUE(controller->exchange({}, first));
  ASSERT_TRUE(controller->exchange({}, second));
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_NEAR(first[i], second[i], 3);
}

TEST_P(Controllers, AReplyThatComesLateIsNotTakenForTheNextOne) {
  plug(GetParam(), 0);
  const auto controller = spidar::open_usb("");
  Counts counts{};
  ASSERT_TRUE(controller->exchange({}, counts));
  unit_->faults([](Faults &faults) { faults.held_replies = 1; });
  EXPECT_FALSE(controller->exchange({}, counts));
  const Counts before = counts;
  // The late reply now comes together with this one's; only the newest is true.
  unit_->faults([](Faults &faults) { faults.offset.fill(500); });
  int answered = 0;
  for (int i = 0; i < 3; ++i)
    answered += controller->exchange({}, counts);
  EXPECT_GE(answered, 2);
  for (std::size_t i = 0; i < counts.size(); ++i)
    EXPECT_NEAR(counts[i], before[i] + 500, 3);
}

TEST_P(Controllers, AStalledEndpointIsClearedBeforeTheNextExchange) {
  plug(GetParam(), 0);
  const auto controller = spidar::open_usb("");
  Counts counts{};
  for (int i = 0; i < 20; ++i) {
    unit_->faults([](Faults &faults) { faults.stalled_replies = 1; });
    const auto begin = Clock::now();
    EXPECT_FALSE(controller->exchange({}, counts));
    EXPECT_TRUE(controller->exchange({}, counts));
    report("stall-cleared-ms", milliseconds(Clock::now() - begin));
  }
  EXPECT_GE(bus_->halts_cleared, 20);
}

TEST_P(Controllers, AnEndpointThatTakesNothingForFiveExchangesIsSurvived) {
  plug(GetParam(), 0);
  allow_exchanges(10ms);
  const auto controller = spidar::open_usb("");
  Counts counts{};
  unit_->faults([](Faults &faults) { faults.refuse_out = true; });
  for (int i = 0; i < 5; ++i)
    EXPECT_FALSE(controller->exchange({}, counts));
  EXPECT_TRUE(controller->connected());
  unit_->faults([](Faults &faults) { faults.refuse_out = false; });
  bool answered = false;
  for (int i = 0; i < 100 && !answered; ++i) // the second, unless the machine is very busy
    answered = controller->exchange({}, counts);
  EXPECT_TRUE(answered);
}

TEST_P(Controllers, RepliesOfAWrongLengthOrFromAnotherSwitchAreRefused) {
  plug(GetParam(), 5);
  const auto controller = spidar::open_usb("");
  Counts counts{};
  ASSERT_TRUE(controller->exchange({}, counts));
  const Counts before = counts;
  for (const std::size_t size : {0U, 1U, 31U, 33U, 511U}) {
    unit_->faults([&](Faults &faults) { faults.mangle = [=](Bytes &b) { b.resize(size); }; });
    EXPECT_FALSE(controller->exchange({}, counts)) << size;
    EXPECT_EQ(counts, before);
  }
  unit_->faults([](Faults &f) {
    f.mangle = [](Bytes &b) { b[GetParam() == Model::sh4 ? 48 : 24] ^= 0x10; };
  });
  EXPECT_FALSE(controller->exchange({}, counts));
  EXPECT_EQ(counts, before);
  unit_->faults([](Faults &faults) { faults.mangle = nullptr; });
  EXPECT_TRUE(controller->exchange({}, counts));
}

} // namespace controllers_test
