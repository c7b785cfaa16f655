// SPDX-License-Identifier: LGPL-2.1-or-later
// What spidar-check finds out about a good device, and about one for each way to break a promise.
#include "check-guardian.hpp"
#include "check-machine.hpp"
#include "check-report.hpp"
#include "promises.hpp"

#include <csignal>
#include <cstdlib>
#include <gtest/gtest.h>
#include <map>
#include <spidar/error.hpp>
#include <spidar/simulator.hpp>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

namespace {

using namespace spidar_check;
using namespace std::chrono_literals;
using spidar::Counts;
using spidar::DacWords;

constexpr double kForce = 0.2; // N
constexpr auto kNever = 1h;

/// What is wrong with a device and its guardian.
struct Wrong {
  bool silent = false;
  bool mirrored = false;        ///< counts the wrong way
  bool lost = false;            ///< counts that fit no pose
  bool slips = false;           ///< each reply comes one exchange late
  Clock::duration rests = 10ms; ///< after which silence the guardian sets minimum tension
  Clock::duration noticed_stopped = 8ms;
  Clock::duration noticed_killed = 3ms;
  bool returns = true; ///< the force, when the guardian goes on
};

/// A simulated device with a guardian, on the time of the check.
class Device final : public spidar::Controller {
public:
  Device(const spidar::Geometry &geometry, Wrong wrong)
      : simulator_(geometry, spidar::parse_hand_script("hold:0,0,0")), wrong_(wrong) {
    simulator_.home(home_);
  }

  bool exchange(const DacWords &words, Counts &counts) noexcept override {
    const auto before = std::exchange(exchanged_, now_);
    if (wrong_.silent || !connected())
      return false;
    Counts measured{};
    const bool rested = is_force(words_) && now_ - before > wrong_.rests;
    if (rested) {
      move_to(before + wrong_.rests, rest_, measured);
      interrupted_ = true;
    }
    if (stopped_ && now_ - *stopped_ >= wrong_.noticed_stopped)
      interrupted_ = interrupted_while_stopped_ = true;
    words_ = rested || interrupted_while_stopped_ ? rest_ : words;
    move_to(now_, words_, measured);
    counts = wrong_.slips ? std::exchange(last_, measured) : measured;
    break_counts(counts);
    return true;
  }
  void set_time(std::int64_t now) noexcept override {
    now_ = Clock::time_point(std::chrono::nanoseconds(now));
  }
  bool home(Counts &counts) const noexcept override { return simulator_.home(counts); }
  void guard(const DacWords &rest) override { rest_ = words_ = rest; }
  bool connected() const noexcept override {
    return !killed_ || now_ - *killed_ < wrong_.noticed_killed;
  }
  bool interrupted() noexcept override { return std::exchange(interrupted_, false); }
  std::string description() const override { return "broken on purpose"; }
  std::string remark() const override { return "its guardian is a helper"; }

  bool signal_guardian(int number) {
    if (number == SIGSTOP)
      stopped_ = now_;
    if (number == SIGKILL)
      killed_ = now_;
    if (number == SIGCONT && wrong_.returns) {
      interrupted_ = interrupted_while_stopped_;
      interrupted_while_stopped_ = false;
      stopped_.reset();
    }
    return true;
  }
  void lose_pose() { wrong_.lost = true; }
  void unplug() {
    wrong_.silent = true;
    killed_ = now_;
  }

private:
  bool is_force(const DacWords &words) const { return words != rest_; }
  void move_to(Clock::time_point time, const DacWords &words, Counts &counts) noexcept {
    simulator_.set_time(std::chrono::nanoseconds(time.time_since_epoch()).count());
    simulator_.exchange(words, counts);
  }
  void break_counts(Counts &counts) noexcept {
    for (std::size_t i = 0; i < spidar::kStrings; ++i) {
      if (wrong_.mirrored)
        counts[i] = 2 * home_[i] - counts[i];
      if (wrong_.lost)
        counts[i] += i % 2 == 0 ? 5000 : -3000;
    }
  }

  spidar::Simulator simulator_;
  Wrong wrong_;
  Counts home_{};
  Counts last_{};
  DacWords rest_{};
  DacWords words_{}; ///< at the motors
  Clock::time_point now_{};
  Clock::time_point exchanged_{};
  std::optional<Clock::time_point> stopped_;
  std::optional<Clock::time_point> killed_;
  bool interrupted_ = false;
  bool interrupted_while_stopped_ = false;
};

/// A unit with that device, and what is reported about it.
class Checked {
public:
  explicit Checked(Wrong wrong = {}, const spidar::Geometry &geometry =
                                         spidar::load_geometry(spidar::kDefaultGeometry))
      : device_(new Device(geometry, wrong)), unit_(std::unique_ptr<spidar::Controller>(device_),
                                                    geometry, std::make_shared<SimulatedTime>()) {}

  Unit &unit() { return unit_; }
  Device &device() { return *device_; }
  Report report() {
    return [this](const Finding &finding) { findings_[finding.promise] = finding; };
  }
  SignalGuardian guardian() {
    return [this](int number) { return device_->signal_guardian(number); };
  }
  /// Expects that verdict on `promise`, and `words` in its figure.
  void expect(const char *promise, Verdict wanted, const char *words = "") {
    ASSERT_TRUE(findings_.contains(promise)) << promise;
    const Finding &finding = findings_.at(promise);
    EXPECT_EQ(finding.verdict, wanted) << promise << ": " << finding.figure;
    EXPECT_NE(finding.figure.find(words), std::string::npos) << finding.figure;
  }
  void expect_pass(const char *promise) { expect(promise, Verdict::pass); }
  void expect_fail(const char *promise, const char *words) {
    expect(promise, Verdict::fail, words);
  }

private:
  Device *device_; ///< belongs to unit_
  std::map<std::string, Finding> findings_;
  Unit unit_;
};

TEST(Checks, AGoodDeviceKeepsEveryPromise) {
  Checked checked;
  EXPECT_TRUE(check_answers(checked.unit(), checked.report()));
  check_force(checked.unit(), kForce, checked.report());
  check_hang(checked.unit(), kForce, checked.report());
  check_guardian_hangs(checked.unit(), kForce, checked.guardian(), checked.report());
  check_guardian_dies(checked.unit(), kForce, checked.guardian(), checked.report());
  for (const char *promise :
       {"the device answers", "the pose is known", "the force is the commanded one",
        "the grip goes where the force points", "a number that is not finite counts as zero",
        "the tension of each string is within the limits of the geometry",
        "the program hangs or is stopped under a force",
        "a reply belongs to the exchange that asked for it",
        "the guardian hangs, or takes no more commands", "the guardian is killed"})
    checked.expect_pass(promise);
}

TEST(Checks, TheReportHasTheRemarkOfTheDevice) {
  Checked checked;
  Output output;
  testing::internal::CaptureStdout();
  output.describe_unit(checked.unit());
  EXPECT_NE(testing::internal::GetCapturedStdout().find("\nits guardian is a helper\n"),
            std::string::npos);
}

TEST(Checks, ASilentDeviceFailsAndMustNotPull) {
  Checked checked({.silent = true});
  EXPECT_FALSE(check_answers(checked.unit(), checked.report()));
  checked.expect_fail("the device answers", "0 of ");
}

TEST(Checks, ADeviceWithoutAPoseFailsAndMustNotPull) {
  Checked checked({.lost = true});
  EXPECT_FALSE(check_answers(checked.unit(), checked.report()));
  checked.expect_pass("the device answers");
  checked.expect_fail("the pose is known", "spidar-calibrate");
}

TEST(Checks, TheForceEndsWithThePose) {
  Checked checked;
  checked.unit().run(0.3, {kForce, 0, 0});
  EXPECT_NEAR(checked.unit().force(), kForce, 1e-6);
  checked.device().lose_pose();
  checked.unit().run(0.3, {kForce, 0, 0});
  EXPECT_EQ(checked.unit().force(), 0);
}

TEST(Checks, NoForceOfBeforeFollowsAnInterruption) {
  Checked checked;
  Unit &unit = checked.unit();
  unit.run(0.3, spidar::Vector3::Zero());
  const DacWords zero = unit.record().last;
  const auto largest_difference = [&] {
    int largest = 0;
    for (std::size_t i = 0; i < zero.size(); ++i)
      largest = std::max(largest, std::abs(unit.record().last[i] - zero[i]));
    return largest;
  };
  unit.run(0.3, {kForce, 0, 0});
  const int under_force = largest_difference();
  ASSERT_GT(under_force, 5);
  unit.pause(100ms);
  unit.exchange();
  ASSERT_EQ(unit.interruptions(), 1);
  unit.exchange();
  EXPECT_LE(largest_difference(), under_force / 5);
}

TEST(Checks, ADeviceThatPullsTheOtherWayFails) {
  Checked checked({.mirrored = true});
  check_force(checked.unit(), kForce, checked.report());
  checked.expect_fail("the grip goes where the force points", "the opposite direction");
}

TEST(Checks, StringsThatCannotGiveTheForceFail) {
  spidar::Geometry weak = spidar::load_geometry(spidar::kDefaultGeometry);
  weak.tension_max = weak.tension_min + 0.02;
  Checked checked({}, weak);
  check_force(checked.unit(), kForce, checked.report());
  checked.expect_fail("the force is the commanded one", "cannot give that force");
}

TEST(Checks, AGuardianThatDoesNothingFails) {
  Checked checked({.rests = kNever});
  check_hang(checked.unit(), kForce, checked.report());
  checked.expect_fail("the program hangs or is stopped under a force", "nothing for 100 ms");
}

TEST(Checks, AGuardianMayWaitForALongExchange) {
  setenv("SPIDAR_USB_TIMEOUT", "100", 1);
  Checked checked({.rests = 108ms});
  check_hang(checked.unit(), kForce, checked.report());
  unsetenv("SPIDAR_USB_TIMEOUT");
  checked.expect_pass("the program hangs or is stopped under a force");
}

TEST(Checks, AMachineThatCannotKeepAForceIsNotTested) {
  Checked checked({.rests = 500us}); // within every tick
  check_hang(checked.unit(), kForce, checked.report());
  check_guardian_hangs(checked.unit(), kForce, checked.guardian(), checked.report());
  checked.expect("the program hangs or is stopped under a force", Verdict::not_testable,
                 "too late");
  checked.expect("the guardian hangs, or takes no more commands", Verdict::not_testable,
                 "too late");
}

TEST(Checks, AGuardianThatIsLateFails) {
  Checked checked({.rests = 40ms});
  check_hang(checked.unit(), kForce, checked.report());
  checked.expect_fail("the program hangs or is stopped under a force", "15 ms promised");
}

TEST(Checks, RepliesOutOfStepFail) {
  Checked checked({.slips = true});
  check_hang(checked.unit(), kForce, checked.report());
  checked.expect_fail("a reply belongs to the exchange that asked for it", "one reply later");
}

TEST(Checks, AStoppedGuardianThatNobodyNoticesFails) {
  Checked checked({.noticed_stopped = kNever});
  check_guardian_hangs(checked.unit(), kForce, checked.guardian(), checked.report());
  checked.expect_fail("the guardian hangs, or takes no more commands", "went on for 1 s");
}

TEST(Checks, AStoppedGuardianThatIsNoticedLateFails) {
  Checked checked({.noticed_stopped = 20ms});
  check_guardian_hangs(checked.unit(), kForce, checked.guardian(), checked.report());
  checked.expect_fail("the guardian hangs, or takes no more commands", "10 ms promised");
}

TEST(Checks, AForceThatDoesNotReturnFails) {
  Checked checked({.returns = false});
  check_guardian_hangs(checked.unit(), kForce, checked.guardian(), checked.report());
  checked.expect_fail("the guardian hangs, or takes no more commands", "did not return");
}

TEST(Checks, AKilledGuardianThatNobodyNoticesFails) {
  Checked checked({.noticed_killed = kNever});
  check_guardian_dies(checked.unit(), kForce, checked.guardian(), checked.report());
  checked.expect_fail("the guardian is killed", "went on for 1 s");
}

TEST(Checks, AKilledGuardianThatIsNoticedLateFails) {
  Checked checked({.noticed_killed = 20ms});
  check_guardian_dies(checked.unit(), kForce, checked.guardian(), checked.report());
  checked.expect_fail("the guardian is killed", "10 ms promised");
}

TEST(Checks, AGuardianOfAnotherProgramIsLeftAlone) {
  Checked checked;
  const SignalGuardian none = [](int) { return false; };
  check_guardian_hangs(checked.unit(), kForce, none, checked.report());
  check_guardian_dies(checked.unit(), kForce, none, checked.report());
  checked.expect("the guardian hangs, or takes no more commands", Verdict::not_testable,
                 "user service");
  checked.expect("the guardian is killed", Verdict::not_testable, "user service");
}

TEST(Checks, APulledCableMustBeNoticedInTime) {
  for (const auto &[noticed, wanted] : {std::pair<Clock::duration, Verdict>{3ms, Verdict::pass},
                                        {20ms, Verdict::fail},
                                        {kNever, Verdict::fail}}) {
    Checked checked({.noticed_killed = noticed});
    const Ask pull = [&checked](const std::string &) {
      checked.device().unplug();
      return true;
    };
    check_answers(checked.unit(), checked.report());
    check_unplug(checked.unit(), pull, checked.report());
    checked.expect("the USB cable is pulled", wanted);
  }
}

TEST(Checks, ACableThatNobodyPullsIsNotTestable) {
  Checked checked;
  const auto agree = [](const std::string &) { return true; };
  check_unplug(checked.unit(), agree, checked.report());
  checked.expect("the USB cable is pulled", Verdict::not_testable);
}

TEST(Checks, TheLastWordsMustBeThoseOfMinimumTension) {
  Record record;
  record.rest = {46, 46, 46, 46, 46, 46, 46, 46};
  const auto verdict_of = [&record] {
    Verdict verdict{};
    check_close(record, [&verdict](const Finding &finding) { verdict = finding.verdict; });
    return verdict;
  };
  record.last = record.rest;
  record.last_answered = true;
  EXPECT_EQ(verdict_of(), Verdict::pass);
  record.last_answered = false;
  EXPECT_EQ(verdict_of(), Verdict::not_testable) << "only its guardian can know";
  record.last_answered = true;
  record.last[3] = 900;
  EXPECT_EQ(verdict_of(), Verdict::fail);
}

TEST(Checks, ATimeCountsOnlyWhereItCanBeMeasured) {
  const auto judge = [](Clock::duration taken, Clock::duration exchange, Clock::duration gap) {
    return in_time("", taken, 10ms, exchange, gap).verdict;
  };
  EXPECT_EQ(judge(9ms, 300us, 1ms), Verdict::pass);
  EXPECT_EQ(judge(12ms, 300us, 1ms), Verdict::fail);
  EXPECT_EQ(judge(12ms, 4ms, 1ms), Verdict::not_testable) << "an emulated machine";
  EXPECT_EQ(judge(9ms, 4ms, 1ms), Verdict::pass) << "in time even there";
  EXPECT_EQ(judge(12ms, 300us, 8ms), Verdict::not_testable) << "the program itself was late";
}

// ---- Another process, whose guardian behaves as the test says

/// What a guardian does once its program has ended.
enum class Afterwards { ends, ends_late, crashes, stays };

/// Starts a "guardian" as libspidar does: a process whose parent has ended.
void start_guardian(Afterwards afterwards) {
  int program[2];
  ASSERT_EQ(pipe(program), 0);
  const pid_t starting = fork();
  if (starting == 0) {
    prctl(PR_SET_NAME, "spidar-guardian");
    setsid(); // before this function returns: the program's process group is killed then
    if (fork() != 0)
      _exit(0);
    close(program[1]);
    char word = 0;
    if (read(program[0], &word, 1) == 0 && afterwards == Afterwards::crashes)
      raise(SIGKILL);
    if (afterwards == Afterwards::ends_late)
      usleep(20'000);
    if (afterwards == Afterwards::stays)
      sleep(60);
    _exit(0);
  }
  close(program[0]);
  waitpid(starting, nullptr, 0);
}

class Killed : public ::testing::Test {
protected:
  Killed() {
    adopt_guardians();
    program_.drive = [](const std::function<void()> &pulls) {
      start_guardian(Afterwards::ends);
      pulls();
      sleep(60);
    };
    program_.open = [] {};
    program_.patience = 60s; // with what does happen
    program_.felt = 1ms;
    program_.mean_exchange = 4ms; // this machine may be busy: its times do not count
  }
  ~Killed() override {
    for (const pid_t child : children()) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
    }
  }
  void drive_with(Afterwards afterwards) {
    program_.drive = [afterwards](const std::function<void()> &pulls) {
      start_guardian(afterwards);
      pulls();
      sleep(60);
    };
  }
  Finding finding(const Ask &ask = {}) {
    Finding result{};
    check_kill(program_, ask, [&result](const Finding &finding) {
      if (finding.promise == std::string("the program is killed or crashes"))
        result = finding;
    });
    return result;
  }
  OtherProgram program_;
};

TEST_F(Killed, AGuardianThatFinishesPasses) {
  const Finding found = finding();
  const bool judged = found.figure.find("not judged") == std::string::npos;
  EXPECT_EQ(found.verdict, judged ? Verdict::pass : Verdict::not_testable) << found.figure;
  EXPECT_NE(found.figure.find("5 ms promised"), std::string::npos) << found.figure;
}

TEST_F(Killed, AGuardianThatIsLateEachTimeIsNotJudgedWhereExchangesAreSlow) {
  drive_with(Afterwards::ends_late);
  const Finding found = finding();
  EXPECT_EQ(found.verdict, Verdict::not_testable) << found.figure;
  EXPECT_NE(found.figure.find("best of 3 kills"), std::string::npos) << found.figure;
}

TEST_F(Killed, AGuardianThatIsLateEachTimeFails) {
  drive_with(Afterwards::ends_late);
  program_.mean_exchange = 300us;
  const Finding found = finding();
  EXPECT_EQ(found.verdict, Verdict::fail) << found.figure;
  EXPECT_NE(found.figure.find("best of 3 kills"), std::string::npos) << found.figure;
}

TEST_F(Killed, APersonIsAskedEvenWhereTheTimeIsNotJudged) {
  drive_with(Afterwards::ends_late);
  EXPECT_EQ(finding([](const std::string &) { return false; }).verdict, Verdict::fail);
  EXPECT_EQ(finding([](const std::string &) { return true; }).verdict, Verdict::not_testable);
}

TEST_F(Killed, AGuardianThatCrashesFails) {
  drive_with(Afterwards::crashes);
  const Finding found = finding();
  EXPECT_EQ(found.verdict, Verdict::fail);
  EXPECT_NE(found.figure.find("crashed"), std::string::npos) << found.figure;
}

TEST_F(Killed, AGuardianThatNeverFinishesFails) {
  drive_with(Afterwards::stays);
  program_.patience = 300ms;
  const Finding found = finding();
  EXPECT_EQ(found.verdict, Verdict::fail);
  EXPECT_NE(found.figure.find("not finished"), std::string::npos) << found.figure;
}

TEST_F(Killed, ADeviceThatCannotBeOpenedAgainFails) {
  program_.open = [] { throw spidar::Error(spidar::Cause::busy, "still held"); };
  program_.patience = 1s; // enough for the guardian, too
  const Finding found = finding();
  EXPECT_EQ(found.verdict, Verdict::fail);
  EXPECT_EQ(found.figure, "still held");
}

TEST_F(Killed, APersonWhoStillFeelsThePullMakesItFail) {
  const Finding found = finding([](const std::string &) { return false; });
  EXPECT_EQ(found.verdict, Verdict::fail);
  EXPECT_NE(found.figure.find("has not taken the force off"), std::string::npos) << found.figure;
}

TEST(TimedTicks, TimeAnExchangeInEachTick) {
  int exchanges = 0;
  const TimedTicks ticks = time_ticks(0.05, [&] {
    if (exchanges++ % 2 != 0)
      return false; // one that fails at once is not fast
    std::this_thread::sleep_for(300us);
    return true;
  });
  EXPECT_GE(exchanges, 1);
  EXPECT_LE(exchanges, 50);
  ASSERT_TRUE(ticks.round_trip);
  EXPECT_GE(*ticks.round_trip, 300e-6);
  EXPECT_GE(ticks.lateness.worst, ticks.lateness.usual);
  EXPECT_FALSE(time_ticks(0.01, nullptr).round_trip);
  EXPECT_FALSE(time_ticks(0.01, [] { return false; }).round_trip);
}

TEST_F(Killed, AProgramThatCannotDriveIsNotTestable) {
  program_.drive = [](const auto &) { throw spidar::Error(spidar::Cause::busy, "held"); };
  EXPECT_EQ(finding().verdict, Verdict::not_testable);
}

} // namespace
