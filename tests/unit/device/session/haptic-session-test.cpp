// SPDX-License-Identifier: LGPL-2.1-or-later
// The session with a device that fails and comes back. The clock is driven by hand.
#include "session/haptic-session.hpp"

#include "loop-fixture.hpp"
#include "messages.hpp"
#include "other-threads.hpp"
#include "temporary-folder.hpp"
#include "virtual-clock.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>
#include <memory>
#include <optional>
#include <spidar/error.hpp>
#include <sstream>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <utility>
#include <vector>

namespace haptic_session_test {

using haptic::HapticSession;
using haptic::Notice;
using haptic::NoticeCause;
using haptic::PointerPosition;
using haptic::Severity;
using test::kMs;
using namespace std::chrono_literals;

// What a test sets and sees of all devices that the session opens.
struct Bench {
  bool answers = true;
  bool plugged = true;
  bool pressed = false;
  bool interrupted = false;                           // at the next exchange
  spidar::Vector3 hand = spidar::Vector3::Zero();     // m
  spidar::Vector3 velocity = spidar::Vector3::Zero(); // m/s
  spidar::Wrench commanded;
  int alive = 0; // devices that exist
  std::string remark;
  spidar::DeviceLimits limits{.grip_is_free = true};
};

class FakeDevice final : public spidar::HapticDevice {
public:
  explicit FakeDevice(Bench &bench) : bench_(bench) { ++bench_.alive; }
  ~FakeDevice() override { --bench_.alive; }

  bool exchange(std::int64_t /*now*/) noexcept override {
    connected_ = connected_ && bench_.plugged;
    state_.valid = connected_ && bench_.answers;
    if (state_.valid)
      state_.pose.position = bench_.hand;
    state_.velocity = bench_.velocity;
    state_.interrupted = std::exchange(bench_.interrupted, false);
    state_.pressed = state_.valid && bench_.pressed;
    return state_.valid;
  }
  bool connected() const noexcept override { return connected_; }
  void command(const spidar::Wrench &wrench) noexcept override { bench_.commanded = wrench; }
  void calibrate() noexcept override {}
  const spidar::DeviceState &state() const noexcept override { return state_; }
  const spidar::Vector3 &workspace_half() const noexcept override { return workspace_half_; }
  const spidar::DeviceLimits &limits() const noexcept override { return bench_.limits; }
  std::string description() const override { return "a fake"; }
  std::string identity() const override { return "the fake"; }
  std::string remark() const override { return bench_.remark; }

private:
  Bench &bench_;
  bool connected_ = true;
  spidar::DeviceState state_;
  spidar::Vector3 workspace_half_ = spidar::Vector3::Constant(0.02);
};

class Session : public ::testing::Test, public haptic::SessionClient {
protected:
  void on_notice(const Notice &notice) override {
    if (notice.cause)
      notices_.push_back(notice);
  }
  bool on_point(const PointerPosition &point) override {
    points_.push_back(point);
    return true;
  }
  void on_armed_changed() override { armed_.push_back(session_->is_armed()); }
  void on_session_changed(const haptic::SessionStatus &status) override {
    states_.push_back(name_of(status.state) + (status.reason.empty() ? "" : ": " + status.reason));
    device_ = status.device;
    if (const auto call = std::exchange(while_reporting_, nullptr))
      call();
  }
  std::optional<haptic::ClockReading> read_clocks() override {
    return haptic::ClockReading{now_, now_ - 1000 * kMs};
  }

  void SetUp() override {
    haptic::DeviceOpener opener;
    opener.open = [this](const haptic::DeviceChoice &) { return haptic::OpenedDevice{make()}; };
    opener.reopen = [this](const haptic::DeviceChoice &, const std::string &identity) {
      EXPECT_EQ(identity, "the fake");
      return make();
    };
    session_ = std::make_unique<HapticSession>(*this, opener);
  }
  std::unique_ptr<spidar::HapticDevice> make() {
    if (refusal_)
      throw spidar::Error(*refusal_, "refused");
    return std::make_unique<FakeDevice>(bench_);
  }
  void begin(const std::string &log = "", const std::string &faults = "") {
    ASSERT_TRUE(session_->open(choice_));
    ASSERT_TRUE(
        session_->prepare({.choice = choice_, .log_location = log, .fault_location = faults}));
    session_->play();
  }
  /// The loop's thousand ticks a second, the pointer thread's hundred rounds, 30 samples.
  void run(int ms, float vx = 100) {
    const auto bytes = haptic::pack_motion_sample(test::moving(vx, 0));
    for (int i = 0; i < ms; ++i) {
      now_ += kMs;
      session_->loop().tick(now_, now_);
      if (i % 33 == 0)
        session_->accept(bytes, false, {});
      if (i % 10 == 9)
        session_->round(now_);
    }
  }
  std::vector<std::string> texts() const {
    std::vector<std::string> all;
    for (const Notice &notice : notices_)
      all.push_back(notice.text);
    return all;
  }
  double force() { return session_->loop().wrench().force.x(); }

  Bench bench_;
  std::optional<spidar::Cause> refusal_;
  haptic::DeviceChoice choice_{.device = "usb"};
  std::int64_t now_ = 1000 * kMs;
  std::vector<Notice> notices_;
  std::vector<PointerPosition> points_;
  std::vector<bool> armed_;
  std::vector<std::string> states_; // with their reasons
  std::string device_;
  std::function<void()> while_reporting_; // the next state
  std::unique_ptr<HapticSession> session_;
};

TEST_F(Session, WarnsOfWhatTheDeviceRemarks) {
  bench_.remark = "It is guarded less.";
  ASSERT_TRUE(session_->open(choice_));
  ASSERT_EQ(notices_.size(), 1U);
  EXPECT_EQ(notices_[0].severity, Severity::warning);
  EXPECT_EQ(notices_[0].text, bench_.remark);
}

TEST_F(Session, SaysOnceWhatTheDeviceCannotDoAndNeverCommandsMore) {
  bench_.limits.force = 0.3;
  begin();
  run(1000, 1e5F);
  EXPECT_NEAR(force(), 0.3, 0.001);
  EXPECT_LE(force(), 0.3);
  haptic::LoopSettings settings;
  settings.law_settings.max_force = 5;
  session_->set_settings(settings);
  run(1000, 1e5F);
  EXPECT_NEAR(force(), 0.3, 0.001);
  EXPECT_LE(force(), 0.3);
  ASSERT_EQ(notices_.size(), 1U);
  EXPECT_EQ(notices_[0].severity, Severity::warning);
  EXPECT_NE(notices_[0].text.find("(a fake) cannot do all that is set. It does at most: "
                                  "max-force=0.3 N."),
            std::string::npos)
      << notices_[0].text;
}

TEST_F(Session, TicksNoFasterThanTheDeviceAnswers) {
  bench_.limits.rate = 500;
  begin();
  ASSERT_EQ(notices_.size(), 1U);
  EXPECT_NE(notices_[0].text.find("rate=500 Hz"), std::string::npos) << notices_[0].text;
  run(1);
  EXPECT_NEAR(session_->loop().impulse().time, 0.002, 1e-9);
}

TEST_F(Session, AGripIsLetGoAtTheSpeedOfItsDevice) {
  bench_.limits.let_go_speed = 0.7;
  begin();
  run(500);
  bench_.velocity.x() = 0.8; // m/s
  run(20);
  EXPECT_FALSE(session_->is_armed());
  ASSERT_EQ(notices_.size(), 1U);
  EXPECT_NE(notices_[0].text.find("faster than 0.7 m/s"), std::string::npos) << notices_[0].text;
}

TEST_F(Session, IsFeltAfterItPlaysAndUntilItIsReleased) {
  begin();
  EXPECT_TRUE(session_->is_armed());
  run(500);
  EXPECT_NEAR(force(), 0.5, 1e-6);
  session_->release();
  run(60);
  EXPECT_TRUE(session_->silent());
  EXPECT_EQ(armed_, std::vector{false});
  session_->arm();
  run(600);
  EXPECT_NEAR(force(), 0.5, 1e-6);
  EXPECT_EQ(armed_, (std::vector{false, true}));
  EXPECT_TRUE(notices_.empty());
}

TEST_F(Session, ADeviceThatIsUnpluggedAndComesBackIsReportedInThisOrder) {
  begin();
  run(500);
  bench_.plugged = false;
  refusal_ = spidar::Cause::not_found;
  run(2000);
  EXPECT_EQ(bench_.alive, 0); // destroyed, so that another one can be opened
  EXPECT_FALSE(session_->is_armed());
  EXPECT_EQ(texts(), std::vector<std::string>{haptic::messages::kDeviceSilent});

  bench_.plugged = true;
  refusal_.reset();
  run(600); // the longest time between two attempts is 500 ms
  ASSERT_EQ(notices_.size(), 2U);
  EXPECT_EQ(notices_[0].severity, Severity::warning);
  EXPECT_EQ(notices_[0].cause, NoticeCause::write);
  EXPECT_EQ(notices_[1].severity, Severity::info);
  EXPECT_EQ(notices_[1].cause, NoticeCause::open);
  EXPECT_NE(notices_[1].text.find("is back: a fake."), std::string::npos);
  run(500);
  EXPECT_FALSE(session_->is_armed());
  EXPECT_TRUE(bench_.commanded.force.isZero(0));
  session_->arm();
  run(600);
  EXPECT_NEAR(bench_.commanded.force.x(), 0.5, 1e-6);
  EXPECT_EQ(armed_, (std::vector{false, true}));
}

TEST_F(Session, ADeviceThatIsBackButCannotBeOpenedIsReportedOnce) {
  begin();
  bench_.plugged = false;
  refusal_ = spidar::Cause::permission;
  run(5000);
  EXPECT_EQ(texts(), (std::vector<std::string>{haptic::messages::kDeviceSilent, "refused"}));
}

TEST_F(Session, ADeviceLostInOneRunIsLookedForInTheNext) {
  begin();
  bench_.plugged = false;
  refusal_ = spidar::Cause::not_found;
  run(200);
  session_->end_run();
  ASSERT_TRUE(session_->prepare({.choice = choice_}));
  bench_.plugged = true;
  refusal_.reset();
  run(300);
  EXPECT_EQ(bench_.alive, 1);
  EXPECT_NE(notices_.back().text.find("is back"), std::string::npos);
}

TEST_F(Session, ADeviceOpenedAgainAfterTheLastTickIsUsedInTheNextRun) {
  begin();
  bench_.plugged = false;
  refusal_ = spidar::Cause::not_found;
  run(200);
  bench_.plugged = true;
  refusal_.reset();
  for (int i = 0; i < 100 && bench_.alive == 0; ++i)
    session_->round(now_ += 10 * kMs); // the loop no longer ticks
  ASSERT_EQ(bench_.alive, 1);
  session_->end_run();
  ASSERT_TRUE(session_->prepare({.choice = choice_}));
  session_->play();
  run(200);
  EXPECT_FALSE(session_->is_armed());
  session_->arm();
  run(600);
  EXPECT_NEAR(bench_.commanded.force.x(), 0.5, 1e-6);
}

TEST_F(Session, ADeviceThatFailsAndAnswersAgainIsReportedOnceAndKept) {
  begin();
  run(500);
  bench_.answers = false;
  run(500);
  bench_.answers = true;
  run(500);
  EXPECT_EQ(texts(), std::vector<std::string>{haptic::messages::kDeviceSilent});
  EXPECT_EQ(bench_.alive, 1);
  EXPECT_TRUE(session_->silent());
  session_->arm();
  run(600);
  EXPECT_NEAR(force(), 0.5, 1e-6);
}

TEST_F(Session, AFaultLeavesTheTwoSecondsBeforeItInAFileThatAMessageNames) {
  const test::TemporaryFolder folder;
  begin("", folder.path_of("faults"));
  run(3000);
  EXPECT_TRUE(folder.is_empty()) << "nothing has happened";
  bench_.answers = false;
  run(100);
  ASSERT_EQ(notices_.size(), 2U);
  EXPECT_EQ(notices_[0].text, haptic::messages::kDeviceSilent);
  const auto file = *std::filesystem::directory_iterator(folder.path_of("faults"));
  EXPECT_NE(notices_[1].text.find(file.path().string()), std::string::npos) << notices_[1].text;
  EXPECT_NE(notices_[1].text.find("(faulted)"), std::string::npos) << notices_[1].text;
  std::ifstream lines(file.path());
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, haptic::kTickLogHeader);
  std::vector<double> times;   // s, column mono
  std::uint32_t held_last = 0; // column hold
  while (std::getline(lines, line)) {
    std::istringstream columns(line);
    std::string value;
    for (int column = 0; column <= 23 && std::getline(columns, value, ','); ++column)
      if (column == 22)
        times.push_back(std::stod(value));
    held_last = static_cast<std::uint32_t>(std::stoul(value));
  }
  ASSERT_EQ(times.size(), 2000U);
  EXPECT_TRUE(held_last & haptic::kHoldFaulted);
  EXPECT_NEAR(times.back(), 3.002, 1e-9) << "three exchanges failed";
  EXPECT_NEAR(times.front(), times.back() - 1.999, 1e-9);
}

// It is asked ten times a second only, and stays as it was in between.
TEST_F(Session, AFaultedDeviceThatWasPutAtRestLeavesOneFile) {
  const test::TemporaryFolder folder;
  begin("", folder.path_of("faults"));
  run(500);
  bench_.answers = false;
  run(50);
  bench_.interrupted = true;
  run(500);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path_of("faults")), {}), 1);
}

TEST_F(Session, WhatTheUserReleasesLeavesNoFile) {
  const test::TemporaryFolder folder;
  begin("", folder.path_of("faults"));
  run(500);
  session_->release();
  run(500);
  EXPECT_TRUE(folder.is_empty());
}

TEST_F(Session, ASleepOfTheMachineDisarms) {
  begin();
  session_->loop().hold(haptic::kHoldSuspended);
  run(100);
  EXPECT_TRUE(session_->silent());
  EXPECT_EQ(armed_, std::vector{false});
}

// A new run is no hand on the grip.
TEST_F(Session, WhatDisarmedStaysThroughACloseUntilArmed) {
  begin();
  session_->loop().hold(haptic::kHoldOverspeed);
  session_->end_run();
  session_->close();
  begin();
  run(500);
  EXPECT_TRUE(session_->silent());
  session_->arm();
  run(500);
  EXPECT_NEAR(force(), 0.5, 1e-6);
}

TEST_F(Session, ADeviceThatCannotBeOpenedIsAnErrorWithItsCause) {
  const std::pair<spidar::Cause, NoticeCause> kCauses[] = {
      {spidar::Cause::not_found, NoticeCause::not_found},
      {spidar::Cause::permission, NoticeCause::open},
      {spidar::Cause::busy, NoticeCause::busy},
      {spidar::Cause::geometry, NoticeCause::settings},
      {spidar::Cause::argument, NoticeCause::settings},
      {spidar::Cause::io, NoticeCause::open}};
  for (const auto &[thrown, cause] : kCauses) {
    refusal_ = thrown;
    EXPECT_FALSE(session_->open(choice_));
    EXPECT_EQ(notices_.back().severity, Severity::error);
    EXPECT_EQ(notices_.back().cause, cause);
    EXPECT_EQ(notices_.back().text, "refused");
    EXPECT_FALSE(session_->is_armed());
  }
}

TEST_F(Session, AnotherChoiceAtTheStartOpensAnotherDevice) {
  ASSERT_TRUE(session_->open(choice_));
  ASSERT_TRUE(session_->prepare({.choice = choice_}));
  EXPECT_EQ(bench_.alive, 1);
  choice_.rate = 500;
  refusal_ = spidar::Cause::busy;
  EXPECT_FALSE(session_->prepare({.choice = choice_}));
  EXPECT_EQ(bench_.alive, 0);
  choice_.rate = 1000; // as before
  refusal_.reset();
  EXPECT_TRUE(session_->prepare({.choice = choice_}));
  EXPECT_EQ(bench_.alive, 1);
}

TEST_F(Session, ALogThatCannotBeWrittenIsAnErrorThatNamesIt) {
  ASSERT_TRUE(session_->open(choice_));
  EXPECT_FALSE(session_->prepare({.choice = choice_, .log_location = "/no/such/log.csv"}));
  EXPECT_EQ(notices_.back().cause, NoticeCause::open_log);
  EXPECT_NE(notices_.back().text.find("/no/such/log.csv"), std::string::npos);
}

TEST_F(Session, ALogThatIsAFifoIsAnErrorAndNotAWait) {
  const test::TemporaryFolder folder;
  const std::string fifo = folder.path_of("fifo");
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  ASSERT_TRUE(session_->open(choice_));
  EXPECT_FALSE(session_->prepare({.choice = choice_, .log_location = fifo}));
  EXPECT_EQ(notices_.back().cause, NoticeCause::open_log);
}

// ---- the dead-man switch ------------------------------------------------------------------------

TEST_F(Session, WithADeadManSwitchTheForceLastsAsLongAsTheButtonIsPressed) {
  choice_.dead_man = haptic::DeadMan::button;
  begin();
  run(500);
  EXPECT_TRUE(session_->silent());
  EXPECT_TRUE(session_->is_armed());
  EXPECT_EQ(states_.back(), "held: dead-man");
  for (int i = 0; i < 3; ++i) {
    bench_.pressed = true;
    run(300);
    EXPECT_NEAR(force(), 0.5, 1e-6);
    EXPECT_TRUE(points_.back().pressed);
    EXPECT_EQ(states_.back(), "armed");
    bench_.pressed = false;
    for (double before = force(); !session_->silent(); before = force()) {
      run(1);
      ASSERT_LT(force(), before); // fades without a step
      ASSERT_GT(force(), before - 0.011);
    }
    run(300);
    EXPECT_TRUE(session_->silent());
    EXPECT_FALSE(points_.back().pressed);
  }
}

TEST_F(Session, ADeviceThatDoesNotAnswerDoesNotCountAsPressed) {
  choice_.dead_man = haptic::DeadMan::button;
  bench_.pressed = true;
  begin();
  run(500);
  bench_.answers = false;
  run(100);
  EXPECT_TRUE(session_->silent());
}

// ---- the machine --------------------------------------------------------------------------------

TEST_F(Session, SaysNothingOfAMachineThatIsInTime) {
  begin();
  session_->loop().tick(now_ - 30 * kMs, now_); // while the pipeline begins
  run(8000);
  EXPECT_TRUE(notices_.empty());
}

TEST_F(Session, TellsOnceThatTheMachineIsNotFit) {
  begin();
  run(1500);
  now_ += kMs;
  session_->loop().tick(now_ - 15 * kMs, now_);
  run(4000);
  EXPECT_TRUE(notices_.empty());
  run(1000);
  ASSERT_EQ(notices_.size(), 1U);
  EXPECT_EQ(notices_[0].severity, Severity::info);
  EXPECT_NE(notices_[0].text.find("not fit for a force"), std::string::npos) << notices_[0].text;
  EXPECT_NE(notices_[0].text.find("15.0 ms"), std::string::npos) << notices_[0].text;
  session_->loop().tick(now_ - 15 * kMs, now_);
  run(8000);
  EXPECT_EQ(notices_.size(), 1U);
}

TEST_F(Session, JudgesTheMachineWhileItPlaysAlone) {
  bench_.limits = test::kSpidar;
  begin();
  run(1500);
  session_->pause();
  run(10'000);
  EXPECT_TRUE(notices_.empty());
  session_->play();
  run(1500);
  now_ += kMs;
  session_->loop().tick(now_ - 3 * kMs, now_);
  run(5000);
  ASSERT_EQ(notices_.size(), 1U);
  EXPECT_NE(notices_[0].text.find("50 N/m instead of 200 N/m"), std::string::npos)
      << notices_[0].text;
}

TEST_F(Session, JudgesTheMachineByWhatItsDeviceCanHold) {
  begin(); // on a device that nothing can be touched with
  run(1500);
  now_ += kMs;
  session_->loop().tick(now_ - 3 * kMs, now_);
  run(5000);
  EXPECT_TRUE(notices_.empty());
}

// ---- states -------------------------------------------------------------------------------------

TEST_F(Session, TheStatesOfASessionAreReportedInOrderWithTheirReasons) {
  EXPECT_EQ(session_->state(), haptic::SessionState::closed);
  begin();
  EXPECT_EQ(states_, (std::vector<std::string>{"open"}));
  EXPECT_EQ(device_, "a fake");
  run(300);
  EXPECT_EQ(states_[1], "homed");
  EXPECT_EQ(session_->state(), haptic::SessionState::armed);
  states_.clear();
  session_->pause();
  run(100);
  session_->play();
  run(100);
  session_->release();
  session_->arm();
  session_->loop().hold(haptic::kHoldOverspeed);
  run(10);
  session_->arm();
  run(10);
  session_->close();
  EXPECT_EQ(states_, (std::vector<std::string>{"held: paused", "armed", "homed: released", "armed",
                                               "faulted: overspeed", "homed", "armed", "closed"}));
  EXPECT_EQ(device_, "");
}

// ---- the pointer --------------------------------------------------------------------------------

// `arm` waits until another thread has reported a state; meanwhile the force is released.
TEST_F(Session, AReportThatHadToWaitIsNotOutOfDate) {
  begin();
  run(100);
  std::jthread arms;
  while_reporting_ = [&] {
    arms = std::jthread([&] { session_->arm(); });
    test::wait_for_other_threads(); // it waits by now
    EXPECT_FALSE(session_->loop().reasons() & haptic::kHoldReleased);
    session_->loop().hold(haptic::kHoldReleased);
  };
  session_->release();
  arms.join();
  EXPECT_EQ(session_->state(), haptic::SessionState::homed);
  EXPECT_EQ(states_.back(), "homed: released");
}

TEST_F(Session, ARestingHandIsSentFiveTimesASecondAndAMovingOneAtOnce) {
  begin();
  run(1000, 0);
  EXPECT_NEAR(static_cast<double>(points_.size()), 5, 1);
  points_.clear();
  for (int i = 0; i < 20; ++i) {
    bench_.hand.x() += 0.0002; // 0.005 of the frame
    run(10, 0);
  }
  EXPECT_EQ(points_.size(), 20U);
  EXPECT_NEAR(points_.back().x, 0.6, 1e-9);
  EXPECT_EQ(points_.back().device, "a fake");
}

TEST_F(Session, ThePointHasTheMeanForceAndTheRunningTime) {
  begin();
  run(1000);
  ASSERT_TRUE(points_.back().force);
  EXPECT_NEAR((*points_.back().force)[0], 0.5, 1e-6);
  EXPECT_LE(points_.back().timestamp, static_cast<std::uint64_t>(now_ - 1000 * kMs));
  session_->pause();
  points_.clear();
  run(300);
  ASSERT_FALSE(points_.empty());
  EXPECT_EQ(points_.back().timestamp, haptic::kNoTimestamp);
}

TEST_F(Session, WhileThePoseIsUnknownNothingIsSent) {
  begin();
  run(100, 0);
  bench_.answers = false;
  run(10, 0);
  points_.clear();
  run(1000, 0);
  EXPECT_TRUE(points_.empty());
}

// ---- the threads --------------------------------------------------------------------------------

class SessionThreads : public Session {
protected:
  void SetUp() override {
    Session::SetUp();
    session_->set_clock(clock_);
  }
  std::optional<haptic::ClockReading> read_clocks() override {
    return haptic::ClockReading{clock_.now(), clock_.now()};
  }

  test::VirtualClock clock_;
};

TEST_F(SessionThreads, TickAThousandTimesAndSendARestingHandFiveTimesASecondUntilTheyEnd) {
  begin();
  session_->loop().start_thread();
  haptic::CallbackThread rounds(
      {}, [this](haptic::CallbackThread::Self &self) { session_->run_rounds(self); });
  clock_.advance(2s);
  EXPECT_EQ(session_->statistics().ticks, 2000U);
  EXPECT_EQ(session_->statistics().late_ticks, 0U);
  EXPECT_NEAR(static_cast<double>(points_.size()), 10, 1);
  const std::int64_t before = clock_.now();
  rounds.end();
  EXPECT_EQ(clock_.now(), before); // without waiting for the next round
  clock_.run([&] { session_->stop_loop(); });
  EXPECT_EQ(clock_.now(), before + kMs); // with the tick that was next
  session_->end_run();
}

// ---- samples ------------------------------------------------------------------------------------

TEST_F(Session, TheFirstDamagedSampleOfEachRunIsReported) {
  for (std::size_t run_number = 1; run_number <= 2; ++run_number) {
    begin();
    const std::vector<std::uint8_t> damaged(7, 0x55);
    for (int i = 0; i < 10; ++i)
      session_->accept(damaged, false, {});
    EXPECT_EQ(session_->intake().bad_samples(), 10U);
    EXPECT_EQ(texts(), std::vector<std::string>(run_number, haptic::messages::kSampleDamaged));
    session_->end_run();
  }
}

TEST_F(Session, SamplesThatALoopThatStandsStillLosesAreCountedAndReportedOnce) {
  begin();
  run(10);
  const auto bytes = haptic::pack_motion_sample(test::moving(100, 0));
  for (int i = 0; i < 300; ++i)
    session_->accept(bytes, false, {});
  EXPECT_EQ(session_->statistics().samples_lost, 300U - 256U);
  run(100);
  EXPECT_EQ(texts(), std::vector<std::string>{haptic::messages::kSamplesLost});
}

TEST_F(Session, FieldsThatALoopThatStandsStillLosesAreCountedToo) {
  begin();
  session_->intake().set_layout(true);
  haptic::MotionField field;
  field.frame_width = field.frame_height = 64;
  field.columns = field.rows = 4;
  field.interval = 33 * static_cast<std::uint64_t>(kMs);
  field.cells.assign(16, {100, 0, 1});
  std::vector<std::uint8_t> bytes(haptic::packed_size(field));
  haptic::pack_motion_field(field, bytes);
  for (int i = 0; i < 300; ++i)
    session_->accept(bytes, false, {});
  EXPECT_GE(session_->statistics().samples_lost, 300U - 256U);
  session_->intake().set_layout(false);
  run(100);
  EXPECT_EQ(texts(), std::vector<std::string>{haptic::messages::kSamplesLost});
}

TEST_F(Session, AFlushDiscardsSamplesAndFades) {
  begin();
  run(500);
  session_->begin_flush();
  run(60);
  EXPECT_TRUE(session_->silent());
  session_->end_flush();
  run(400);
  EXPECT_NEAR(force(), 0.5, 1e-6);
}

} // namespace haptic_session_test
