// SPDX-License-Identifier: LGPL-2.1-or-later
// What reaches the motors when the guardian, the endpoint or the replies misbehave.
#include "direct-fixture.hpp"
#include "eventually.hpp"
#include "fake-guardian.hpp"
#include "loop-priority.hpp"

#include <random>

namespace guarded_test {

using namespace test;
using spidar::Counts;
using spidar::DacWords;

constexpr DacWords kRestWords = {46, 46, 46, 46, 46, 46, 46, 46};
constexpr DacWords kForceWords = {900, 46, 46, 46, 46, 46, 46, 46};
constexpr std::array kBlocked = {0ms, 15ms, 30ms, 60ms};

int rounds(int without) {
  const char *wanted = std::getenv("FEELING_WIND_KILLS");
  return wanted ? std::atoi(wanted) : without;
}

class Guarded : public DirectlyOnBusOf {
protected:
  void SetUp() override {
    DirectlyOnBusOf::SetUp();
    if (IsSkipped())
      return;
    plug(GetParam(), 4);
    guardian_ = std::make_unique<FakeGuardian>();
  }
  void TearDown() override {
    controller_.reset();
    guardian_.reset();
    DirectlyOnBusOf::TearDown();
  }

  void open() {
    controller_ = spidar::open_usb("4");
    controller_->guard(kRestWords);
  }

  /// Full force in ticks of at least 1 ms until the motors have `words`, or a second is over.
  /// Returns their number.
  int drive_to(const DacWords &words) {
    const AsTheLoop priority;
    int ticks = 0;
    do {
      std::this_thread::sleep_for(1ms);
      controller_->exchange(kForceWords, counts_);
    } while (++ticks < 1000 && unit_->words() != words);
    return ticks;
  }

  /// Full force, of which nothing may reach the motors while its interruption is reported.
  void expect_rest_while_interrupted() {
    bool interrupted = true;
    for (int ticks = 0; ticks < 1000 && interrupted; ++ticks) {
      std::this_thread::sleep_for(1ms);
      controller_->exchange(kForceWords, counts_);
      interrupted = controller_->interrupted();
      ASSERT_TRUE(interrupted || ticks > 0) << "the force must begin anew, from zero";
      ASSERT_TRUE(!interrupted || unit_->words() == kRestWords) << ticks;
    }
    EXPECT_FALSE(interrupted);
  }

  /// Packets that set the motors, from now on: whether each had rest words.
  void watch_words() {
    unit_->faults([this](Faults &faults) {
      faults.watch = [this](std::span<const std::uint8_t> packet) {
        const bool sh4 = GetParam() == Model::sh4;
        if (packet[0] == (sh4 ? 0x01 : 0x52))
          rested_.push_back(packet[sh4 ? 2 : 1] == 46 && packet[sh4 ? 3 : 2] == 0);
      };
    });
  }

  std::unique_ptr<FakeGuardian> guardian_;
  std::unique_ptr<spidar::Controller> controller_;
  Counts counts_{};
  std::vector<bool> rested_;
};
INSTANTIATE_TEST_SUITE_P(Both, Guarded, ::testing::Values(Model::simple, Model::sh4),
                         name_of_model);

TEST_P(Guarded, AStoppedGuardianIsNoticedAndTheMotorsStayAtRestUntilItAnswers) {
  open();
  double slowest = 0; // ms
  for (int round = 0; round < rounds(3); ++round) {
    drive_to(kForceWords);
    ASSERT_EQ(unit_->words(), kForceWords) << round;
    controller_->interrupted();
    guardian_->stop();
    const auto begin = Clock::now();
    const int ticks = drive_to(kRestWords);
    slowest = std::max(slowest, milliseconds(Clock::now() - begin));
    EXPECT_LE(ticks, 10) << "of at least 1 ms each";
    EXPECT_TRUE(controller_->interrupted());
    for (int i = 0; i < 100; ++i) {
      EXPECT_TRUE(controller_->exchange(kForceWords, counts_));
      ASSERT_EQ(unit_->words(), kRestWords);
      ASSERT_TRUE(controller_->interrupted()) << "these words did not act";
    }
    EXPECT_TRUE(controller_->connected());

    guardian_->go_on();
    drive_to(kForceWords);
    ASSERT_EQ(unit_->words(), kForceWords) << round;
    EXPECT_TRUE(controller_->interrupted()) << "the force must begin anew, from zero";
  }
  report("stopped-guardian-to-rest-ms", slowest);
}

TEST_P(Guarded, AGuardianThatDiesDuringAnExchangeLeavesNoForce) {
  open();
  drive_to(kForceWords);
  ASSERT_EQ(unit_->words(), kForceWords);
  unit_->faults([this](Faults &faults) {
    faults.watch = [this](std::span<const std::uint8_t>) { guardian_->die(); };
  });
  EXPECT_FALSE(controller_->exchange(kForceWords, counts_));
  EXPECT_FALSE(controller_->connected());
  EXPECT_EQ(unit_->words(), kRestWords) << "and no exchange will follow";
}

TEST_P(Guarded, AForceIsInterruptedByAGuardianThatDeliversNothingToo) {
  open();
  for (int round = 0; round < rounds(3); ++round) {
    drive_to(kForceWords);
    ASSERT_EQ(unit_->words(), kForceWords) << round;
    controller_->interrupted();
    guardian_->announce();
    drive_to(kRestWords);
    ASSERT_EQ(unit_->words(), kRestWords) << round;
    EXPECT_TRUE(controller_->interrupted());
    guardian_->give_up();
    expect_rest_while_interrupted();
  }
}

TEST_P(Guarded, NoForceOfBeforeIsSentWhenAStoppedGuardianGoesOn) {
  open();
  for (int round = 0; round < rounds(10); ++round) {
    drive_to(kForceWords);
    ASSERT_EQ(unit_->words(), kForceWords) << round;
    guardian_->stop();
    drive_to(kRestWords);
    ASSERT_EQ(unit_->words(), kRestWords) << round;
    controller_->interrupted();
    guardian_->go_on();
    expect_rest_while_interrupted();
  }
}

TEST_P(Guarded, TheGuardianIsToldWhatWasDelivered) {
  allow_exchanges(5ms);
  open();
  Counts counts{};
  controller_->exchange(kForceWords, counts);
  EXPECT_TRUE(guardian_->is_told(spidar::kForce));
  unit_->faults([](Faults &faults) { faults.refuse_out = true; });
  for (int i = 0; i < 10; ++i)
    EXPECT_FALSE(controller_->exchange(kRestWords, counts));
  EXPECT_TRUE(guardian_->is_told(spidar::kForce)) << "the motors still have it";
  unit_->faults([](Faults &faults) { faults.refuse_out = false; });
  for (int i = 0; i < 5; ++i)
    controller_->exchange(kRestWords, counts);
  EXPECT_TRUE(guardian_->is_told(spidar::kRest));
}

class Closing : public DirectlyOnBusOf {};
INSTANTIATE_TEST_SUITE_P(Both, Closing, ::testing::Values(Model::simple, Model::sh4),
                         name_of_model);

TEST_P(Closing, WhatTakesNothingMeanwhileIsAtRestAsSoonAsItTakesSomething) {
  allow_exchanges(5ms);
  plug(GetParam(), 4);
  const ThreadedGuardian guardian;
  auto controller = spidar::open_usb("4");
  controller->guard(kRestWords);
  Counts counts{};
  while (unit_->words() != kForceWords)
    controller->exchange(kForceWords, counts);
  unit_->faults([](Faults &faults) { faults.refuse_out = true; });
  controller.reset();
  EXPECT_EQ(unit_->words(), kForceWords);
  unit_->faults([](Faults &faults) { faults.refuse_out = false; });
  EXPECT_TRUE(eventually([&] { return unit_->words() == kRestWords; }));
}

TEST_P(Guarded, AnEndpointThatTakesDataAgainGetsRestWordsFirst) {
  allow_exchanges(5ms);
  open();
  for (int round = 0; round < rounds(12); ++round) {
    drive_to(kForceWords);
    ASSERT_EQ(unit_->words(), kForceWords);
    watch_words();
    unit_->faults([](Faults &faults) { faults.refuse_out = true; });
    const auto end = Clock::now() + kBlocked[static_cast<std::size_t>(round) % kBlocked.size()];
    do
      EXPECT_FALSE(controller_->exchange(kForceWords, counts_));
    while (Clock::now() < end);
    ASSERT_TRUE(rested_.empty());
    controller_->interrupted();
    unit_->faults([](Faults &faults) { faults.refuse_out = false; });
    controller_->exchange(kForceWords, counts_);
    ASSERT_FALSE(rested_.empty());
    EXPECT_TRUE(rested_.front());
    EXPECT_EQ(unit_->words(), kRestWords) << "the words of this exchange are older than the rest";
    EXPECT_TRUE(controller_->interrupted());
    rested_.clear();
    unit_->faults([](Faults &faults) { faults.watch = nullptr; });
  }
}

/// The counts carry the number of the request: the model latches them when it gets one.
class Stamped : public Guarded {
protected:
  static constexpr int kStep = 40;

  void open() {
    Guarded::open();
    for (int i = 0; i < 500; ++i) // until the grip stands still
      controller_->exchange(kRestWords, start_);
  }

  /// Exchanges behind the newest request, or nothing if there was no answer.
  std::optional<int> lag() {
    ++request_;
    unit_->faults([this](Faults &faults) { faults.offset.fill(request_ * kStep); });
    Counts counts{};
    if (!controller_->exchange(kRestWords, counts))
      return std::nullopt;
    const auto moved = static_cast<std::int16_t>(counts[3] - start_[3]);
    const auto behind = static_cast<std::int16_t>(request_ * kStep - moved);
    return (behind + (behind < 0 ? -kStep / 2 : kStep / 2)) / kStep;
  }

  /// Injects one fault.
  void inject(unsigned what, int count) {
    switch (what) {
    case 0:
      unit_->faults([&](Faults &faults) { faults.held_replies = count; });
      break;
    case 1:
      unit_->faults([&](Faults &faults) { faults.short_replies = count; });
      break;
    case 2:
      unit_->faults([&](Faults &faults) { faults.stalled_replies = count; });
      break;
    case 3:
      for (int i = 0; i < count; ++i)
        unit_->leave_reply(Bytes(packet_size(), static_cast<std::uint8_t>(0x40 + i)));
      break;
    case 4:
      guardian_->intervene(*unit_, count);
      break;
    case 5: // one that is told only after an exchange
      guardian_->announce();
      guardian_->write(*unit_);
      lag();
      guardian_->finish();
      break;
    case 6:
      unit_->faults([](Faults &faults) { faults.late_by = 12ms; });
      lag();
      unit_->faults([](Faults &faults) { faults.late_by = 0ms; });
      break;
    default:
      unit_->faults([](Faults &faults) { faults.silent = true; });
      lag();
      unit_->faults([](Faults &faults) { faults.silent = false; });
    }
  }

  /// Whether one of the next exchanges is answered, in ticks of at least 1 ms: the guardian, which
  /// may have something to say, is another thread.
  bool recovers() {
    for (int i = 0; i < 200; ++i, std::this_thread::sleep_for(1ms))
      if (lag())
        return true;
    return false;
  }

  Counts start_{};
  int request_ = 0;
};
INSTANTIATE_TEST_SUITE_P(Both, Stamped, ::testing::Values(Model::simple, Model::sh4),
                         name_of_model);

TEST_P(Stamped, NoSeriesOfFaultsLeavesTheRepliesBehind) {
  allow_exchanges(8ms);
  open();
  std::mt19937 random(GetParam() == Model::sh4 ? 205 : 203);
  for (int series = 0; series < rounds(60) && !HasFatalFailure(); ++series) {
    const auto faults = 1 + random() % 4;
    std::string story;
    for (unsigned i = 0; i < faults; ++i) {
      const auto what = static_cast<unsigned>(random() % 8);
      const int count = static_cast<int>(1 + random() % 3);
      story += " " + std::to_string(what) + "x" + std::to_string(count);
      inject(what, count);
      for (auto k = random() % 3; k > 0; --k)
        lag();
    }
    unit_->faults([](Faults &f) { f.held_replies = f.short_replies = f.stalled_replies = 0; });
    ASSERT_TRUE(recovers()) << series << story;
    ASSERT_TRUE(recovers()) << series << story;
    for (int i = 0; i < 20; ++i)
      EXPECT_EQ(lag().value_or(0), 0) << series << story;
  }
}

TEST_P(Stamped, ALateReplyIsNeverTakenForAnother) {
  allow_exchanges(20ms);
  open();
  for (int round = 0; round < 50; ++round) {
    unit_->faults([](Faults &faults) { faults.held_replies = 1; });
    EXPECT_FALSE(lag().has_value()) << "it was not there";
    for (int i = 0; i < 5; ++i)
      EXPECT_EQ(lag(), 0) << round;
  }
}

TEST_P(Stamped, PacketsOfTheGuardianLeaveNoReplyBehind) {
  open();
  for (int round = 0; round < 50; ++round) {
    guardian_->intervene(*unit_, 1 + round % 3);
    for (int i = 0; i < 5; ++i)
      EXPECT_EQ(lag().value_or(0), 0) << round;
    ASSERT_TRUE(recovers());
    EXPECT_EQ(lag(), 0) << round;
  }
}

/// The real guardian, and a process that stands still before a system call of an exchange.
class Stopped : public DirectlyOnBusOf {
protected:
  static constexpr int kCalls = 9; // an exchange makes eight, with an SH4 six

  void SetUp() override {
    DirectlyOnBusOf::SetUp();
    if (IsSkipped())
      return;
    allow_exchanges(2ms); // the guardian waits 10 ms
    plug(GetParam(), 4);
    if (GetParam() == Model::sh4)
      unit_->faults([](Faults &faults) { faults.most_unread = 4; });
    guardian_ = std::make_unique<ThreadedGuardian>();
    bus_->before_ioctl = [this] {
      if (std::this_thread::get_id() != process_)
        return;
      if (call_ == first_)
        stand_still(GetParam() == Model::sh4 ? 30ms : 15ms); // more rests than room for replies
      if (call_ == second_)
        stand_still(15ms); // the guardian waits 10 ms, then rests each 5 ms
      ++call_;
    };
    controller_ = spidar::open_usb("4");
    controller_->guard(kRestWords);
  }
  void TearDown() override {
    controller_.reset();
    guardian_.reset();
    DirectlyOnBusOf::TearDown();
  }

  /// Returns when the motors have been at rest for `time`, in which a packet that was on its way
  /// has arrived, and the guardian after it.
  void stand_still(std::chrono::milliseconds time) {
    const auto begin = Clock::now();
    auto rest_since = begin;
    for (auto now = begin; now - rest_since < time && now - begin < 1s; now = Clock::now()) {
      bus_->work();
      if (unit_->words() != kRestWords)
        rest_since = now;
      std::this_thread::sleep_for(100us);
    }
    slowest_ = std::max(slowest_, milliseconds(rest_since - begin));
    EXPECT_LT(rest_since - begin, 1s - time)
        << "stopped before calls " << first_ << ", " << second_;
  }

  /// Full force until a number of exchanges in a row were answered and the motors have it.
  bool pulls() {
    for (int ticks = 0, answered = 0; ticks < 1000; ++ticks) {
      std::this_thread::sleep_for(1ms);
      answered = controller_->exchange(kForceWords, counts_) ? answered + 1 : 0;
      if (answered >= 5 && unit_->words() == kForceWords)
        return true;
    }
    return false;
  }

  std::unique_ptr<ThreadedGuardian> guardian_;
  std::unique_ptr<spidar::Controller> controller_;
  Counts counts_{};
  std::thread::id process_ = std::this_thread::get_id();
  int call_ = 0;
  int first_ = -1;
  int second_ = -1;
  double slowest_ = 0; ///< ms
};
INSTANTIATE_TEST_SUITE_P(Both, Stopped, ::testing::Values(Model::simple, Model::sh4),
                         name_of_model);

TEST_P(Stopped, TwiceBeforeAnyTwoCallsOfAnExchangeItLeavesNoForce) {
  for (int first = 0; first < kCalls && !HasFailure(); ++first)
    for (int second = first + 1; second <= first + kCalls; ++second) {
      first_ = second_ = -1;
      ASSERT_TRUE(pulls()) << first << ", " << second;
      const AsTheLoop priority;
      call_ = 0;
      first_ = first;
      second_ = second;
      while (call_ <= second)
        controller_->exchange(kForceWords, counts_);
    }
  report("stopped-at-a-call-to-rest-ms", slowest_);
}

TEST_P(Stopped, RepliesThatNobodyReadsDoNotStopTheGuardian) {
  ASSERT_TRUE(pulls());
  std::atomic<int> rests = 0;
  unit_->faults([&](Faults &faults) { faults.watch = [&](const auto &) { ++rests; }; });
  const auto begin = Clock::now();
  while (rests < 20 && Clock::now() - begin < 10s)
    std::this_thread::sleep_for(1ms);
  EXPECT_GE(rests, 20);
  unit_->faults([](Faults &faults) { faults.watch = nullptr; });
  EXPECT_TRUE(pulls()) << "its count of the replies is right";
}

} // namespace guarded_test
