// SPDX-License-Identifier: LGPL-2.1-or-later
#include "loop/tick-log.hpp"

#include "share/running-time.hpp"

#include <cerrno>
#include <clocale>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <sstream>
#include <sys/resource.h>
#include <system_error>

namespace tick_log_test {

using haptic::RunningTime;
using haptic::TickLog;
using haptic::TickRow;

class TickLogFile : public ::testing::Test {
protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "tick-log-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    directory_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string path() const { return (directory_ / "log.csv").string(); }
  std::vector<std::string> lines() const {
    std::ifstream file(path());
    std::vector<std::string> all;
    for (std::string line; std::getline(file, line);)
      all.push_back(line);
    return all;
  }

  std::filesystem::path directory_;
};

TickRow numbered_row() {
  TickRow row;
  row.time = 1;
  row.position = {2, 3, 4};
  row.velocity = {5, 6};
  row.spin = 7;
  row.commanded = {{8, 9, 10}, {11, 12, 13}};
  row.confidence = 14;
  row.tension = {15, 16, 17, 18, 19, 20, 21, 22};
  row.mono = 23;
  row.hold = 24;
  row.orientation = {25, 26, 27, 28};
  row.energy = 29;
  row.turning = {30, 31, 32};
  row.realised = {{33, 34, 35}, {36, 37, 38}};
  row.proxy = {39, 40, 41};
  row.touches = true;
  row.limits = 43;
  return row;
}

TEST_F(TickLogFile, HasTheHeaderAndTheColumnsInTheirOrder) {
  {
    TickLog log(path());
    EXPECT_TRUE(log.write(numbered_row()));
  }
  const auto all = lines();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0],
            "time,x,y,z,vx,vy,spin,fx,fy,fz,tx,ty,tz,confidence,t0,t1,t2,t3,t4,t5,t6,t7,mono,hold"
            ",qx,qy,qz,qw,energy,wx,wy,wz,rfx,rfy,rfz,rtx,rty,rtz,px,py,pz,touch,limits");
  EXPECT_EQ(all[1], "1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16,17,18,19,20,21,22,23,24,25,26,27,28,"
                    "29,30,31,32,33,34,35,36,37,38,39,40,41,1,43");
}

TEST_F(TickLogFile, IsCompleteWhenItIsClosed) {
  constexpr int kRows = 5000;
  {
    TickLog log(path());
    for (int i = 0; i < kRows; ++i) {
      TickRow row;
      row.time = i;
      ASSERT_TRUE(log.write(row));
    }
  }
  const auto all = lines();
  ASSERT_EQ(all.size(), kRows + 1U);
  for (int i = 0; i < kRows; ++i)
    ASSERT_EQ(std::stod(all[static_cast<std::size_t>(i) + 1]), i);
}

TEST_F(TickLogFile, RowsThatDoNotFitAreRefusedAndTheOthersAreKept) {
  std::size_t kept = 0;
  {
    TickLog log(path());
    for (int i = 0; i < 100'000; ++i) // faster than any writer
      kept += log.write(numbered_row());
  }
  EXPECT_EQ(lines().size(), kept + 1);
}

TEST_F(TickLogFile, ThatCannotBeCreatedIsAnErrorThatNamesIt) {
  try {
    TickLog log((directory_ / "missing" / "log.csv").string());
    FAIL() << "created";
  } catch (const std::system_error &error) {
    EXPECT_EQ(error.code().value(), ENOENT);
    EXPECT_NE(std::string(error.what()).find("missing/log.csv"), std::string::npos);
  }
}

// The disk becomes full while the last rows wait to be written.
TEST_F(TickLogFile, ThatFailsAtItsEndSaysSoOnceItHasFinished) {
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit usual{};
  getrlimit(RLIMIT_FSIZE, &usual);
  TickLog log(path());
  const rlimit full{std::filesystem::file_size(path()), usual.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  EXPECT_TRUE(log.write(numbered_row()));
  log.finish();
  setrlimit(RLIMIT_FSIZE, &usual);
  std::signal(SIGXFSZ, before);
  EXPECT_EQ(log.error(), EFBIG);
}

TEST(TickLogDisk, ThatIsFullIsAnErrorAtTheStart) {
  if (!std::filesystem::exists("/dev/full"))
    GTEST_SKIP() << "no /dev/full";
  EXPECT_THROW(TickLog("/dev/full"), std::system_error);
}

TEST(TickRow, KeepsNineDigitsWithAPointInEveryLocale) {
  const char *before = std::setlocale(LC_NUMERIC, "de_DE.UTF-8"); // where it exists
  TickRow row;
  row.time = 12345.6789;
  row.commanded.force[0] = -1.0 / 3;
  std::string text;
  haptic::append_row(text, row);
  if (before)
    std::setlocale(LC_NUMERIC, "C");
  EXPECT_EQ(text.substr(0, text.find(',')), "12345.6789");
  EXPECT_NE(text.find(",-0.333333333,"), std::string::npos) << text;
}

TEST(TickRow, TellsTicksOfAQuarterOfAMillisecondApartAfterADay) {
  const auto mono = [](double seconds) {
    TickRow row;
    row.mono = seconds;
    std::string text;
    haptic::append_row(text, row);
    std::istringstream columns(text);
    std::string value;
    for (int column = 0; column <= 22; ++column)
      std::getline(columns, value, ',');
    return std::stod(value);
  };
  EXPECT_NEAR(mono(86400.0005) - mono(86400.00025), 0.00025, 1e-6);
}

TEST(TickRow, HoldsNoNanNoInfinityAndNoMinusZero) {
  TickRow row;
  row.velocity = {std::nan(""), std::numeric_limits<double>::infinity()};
  row.commanded.force[1] = -0.0;
  std::string text;
  haptic::append_row(text, row);
  EXPECT_EQ(text, "0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1,0,0,0,0,0,0,0,0,0,0,"
                  "0,0,0,0,0\n");
}

constexpr std::int64_t kMs = 1'000'000; // ns

TEST(RunningTimeTest, FollowsTheMonotonicClock) {
  RunningTime time;
  time.set(5000 * kMs, 100 * kMs);
  EXPECT_NEAR(time.advance(5001 * kMs), 0.101, 1e-12);
  EXPECT_NEAR(time.advance(5010 * kMs), 0.110, 1e-12);
  EXPECT_EQ(time.last(), time.advance(5010 * kMs));
}

TEST(RunningTimeTest, NeverGoesBackWhenTheClocksAreReadAgain) {
  RunningTime time;
  time.set(0, 1000 * kMs);
  const double before = time.advance(10 * kMs);
  time.set(10 * kMs, 1005 * kMs); // 5 ms behind
  EXPECT_EQ(time.advance(11 * kMs), before);
  EXPECT_NEAR(time.advance(30 * kMs), 1.025, 1e-12);
}

TEST(RunningTimeTest, GoesOnWhereASeekStartsItAnew) {
  RunningTime time;
  time.set(0, 5000 * kMs);
  EXPECT_NEAR(time.advance(kMs), 5.001, 1e-12);
  time.set(kMs, 0);
  EXPECT_NEAR(time.advance(kMs), 5.001, 1e-12);
  EXPECT_NEAR(time.advance(3 * kMs), 5.003, 1e-12);
}

TEST(RunningTimeTest, IsZeroBeforeItsStart) {
  RunningTime time;
  time.set(0, -500 * kMs);
  EXPECT_EQ(time.advance(0), 0);
  EXPECT_NEAR(time.advance(600 * kMs), 0.1, 1e-12);
}

} // namespace tick_log_test
