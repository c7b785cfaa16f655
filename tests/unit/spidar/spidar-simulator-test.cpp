// SPDX-License-Identifier: LGPL-2.1-or-later
#include "spidar/error.hpp"
#include "spidar/pose-solver.hpp"
#include "spidar/simulator.hpp"
#include "temporary-folder.hpp"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <numbers>
#include <sys/stat.h>

namespace spidar_simulator_test {

using namespace spidar;

constexpr double kHalf = 0.025; // m, of the built-in workspace

std::int16_t word(const Geometry &geometry, double tension) {
  return static_cast<std::int16_t>(
      std::lround(tension * geometry.digits_per_volt * geometry.volts_per_newton[0]));
}

DacWords all_strings(const Geometry &geometry, double tension) {
  DacWords words;
  words.fill(word(geometry, tension));
  return words;
}

Vector3 target(const std::string &script, double time) {
  Vector3 result = Vector3::Constant(-1);
  EXPECT_TRUE(parse_hand_script(script)->target(time, Vector3::Constant(kHalf), result));
  return result;
}

std::string refusal(const std::string &script) {
  try {
    parse_hand_script(script);
  } catch (const Error &error) {
    return error.what();
  }
  return "accepted";
}

/// A hand script file that goes with the test.
class HandFile {
public:
  explicit HandFile(const std::string &text) {
    std::string pattern = (std::filesystem::temp_directory_path() / "spidar-hand-XXXXXX").string();
    directory_ = mkdtemp(pattern.data());
    std::ofstream(directory_ / "hand.csv") << text;
  }
  ~HandFile() { std::filesystem::remove_all(directory_); }
  HandFile(const HandFile &) = delete;
  HandFile &operator=(const HandFile &) = delete;
  std::string script() const { return "file:" + (directory_ / "hand.csv").string(); }

private:
  std::filesystem::path directory_;
};

TEST(HandScript, HoldStaysAtItsPlace) {
  EXPECT_EQ(target("hold:0.5,-1,0", 0), Vector3(0.5 * kHalf, -kHalf, 0));
  EXPECT_EQ(target("hold: 0.5 , -1 , 0", 1e6), Vector3(0.5 * kHalf, -kHalf, 0));
}

TEST(HandScript, CircleRunsCounterClockwiseAsTheUserSeesIt) {
  constexpr double kRound = 1e-12;
  EXPECT_LT((target("circle:0.8,4", 0) - Vector3(0.8 * kHalf, 0, 0)).norm(), kRound);
  EXPECT_LT((target("circle:0.8,4", 1) - Vector3(0, 0.8 * kHalf, 0)).norm(), kRound);
  EXPECT_LT((target("circle:0.8,4", 2) - Vector3(-0.8 * kHalf, 0, 0)).norm(), kRound);
  EXPECT_LT((target("circle:0.8,4", 400) - Vector3(0.8 * kHalf, 0, 0)).norm(), kRound);
}

TEST(HandScript, FileIsInterpolatedAndStaysAtItsLastLine) {
  const HandFile file("# t,x,y,z\n0.5, 0,0,0\r\n\n1.5,1,-1,0.5"); // no line end at its end
  EXPECT_EQ(target(file.script(), 0), Vector3::Zero());
  EXPECT_EQ(target(file.script(), 1), Vector3(0.5, -0.5, 0.25) * kHalf);
  EXPECT_EQ(target(file.script(), 99), Vector3(1, -1, 0.5) * kHalf);
}

TEST(HandScript, FreeMeansThatNobodyHoldsTheGrip) {
  Vector3 unused;
  EXPECT_FALSE(parse_hand_script("free")->target(0, Vector3::Ones(), unused));
}

TEST(HandScript, WhatIsNotUnderstoodIsRefusedWithWhatIsAccepted) {
  for (const char *script :
       {"", "hold", "hold:", "hold:1,2", "hold:0,0,1.01", "hold:0,0,nan", "hold:0,0,0,0",
        "hold:0;0;0", "hold:0,0,inf", "circle:0.5", "circle:2,1", "circle:0.5,0", "circle:0.5,-1",
        "circle:0.5,nan", "free:1", "file:", "wave:1", "hold:0x1,0,0"}) {
    const std::string message = refusal(script);
    EXPECT_NE(message.find("hold:X,Y,Z"), std::string::npos) << script << " -> " << message;
    EXPECT_NE(message.find("circle:RADIUS,PERIOD"), std::string::npos) << script;
  }
}

TEST(HandScript, AFileMayPressTheButton) {
  const HandFile file("0,0,0,0\n1,0,0,0,1\n2,0,0,0,0\n");
  const auto hand = parse_hand_script(file.script());
  for (const auto &[time, presses] : {std::pair{-1.0, false},
                                      {0.5, false},
                                      {1.0, true},
                                      {1.999, true},
                                      {2.0, false},
                                      {100.0, false}})
    EXPECT_EQ(hand->presses(time), presses) << time;
  EXPECT_FALSE(parse_hand_script("hold:0,0,0")->presses(1));
}

TEST(HandScript, FileErrorsNameTheLine) {
  EXPECT_NE(refusal(HandFile("0,0,0,0,1\n1,0,0,0,2\n").script()).find("line 2"), std::string::npos);
  EXPECT_NE(refusal(HandFile("0,0,0,0\n1,0,0\n").script()).find("line 2"), std::string::npos);
  EXPECT_NE(refusal(HandFile("0,0,0,0\n\n0,0,0,0\n").script()).find("line 3"), std::string::npos);
  EXPECT_NE(refusal(HandFile("# far\n0,0,0,2\n").script()).find("line 2"), std::string::npos);
  EXPECT_NE(refusal(HandFile("0,0,0,0\n1,0,0," + std::string(1000, '0')).script()).find("line 2"),
            std::string::npos);
  EXPECT_NE(refusal("file:/dev/zero").find("line 1"), std::string::npos);
  EXPECT_NE(refusal(HandFile("").script()).find("no readable line"), std::string::npos);
  EXPECT_NE(refusal("file:/nowhere/hand.csv").find("/nowhere/hand.csv"), std::string::npos);
  EXPECT_NE(refusal("file:/").find("no readable line"), std::string::npos);
}

TEST(HandScript, AFifoIsRefusedAndNotWaitedFor) {
  const test::TemporaryFolder folder;
  const std::string fifo = folder.path_of("fifo");
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  EXPECT_NE(refusal("file:" + fifo).find(fifo), std::string::npos);
}

TEST(Simulator, ASteadyHandStaysWhereItsScriptSays) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Simulator simulator(geometry, parse_hand_script("hold:0.5,0,0"));
  Counts counts{};
  for (int tick = 0; tick < 5000; ++tick) {
    ASSERT_TRUE(simulator.exchange(all_strings(geometry, 0.3), counts));
    ASSERT_LT((simulator.pose().position - Vector3(0.0125, 0, 0)).norm(), 0.0003) << tick;
  }
}

TEST(Simulator, TheHandFollowsACircle) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Simulator simulator(geometry, parse_hand_script("circle:1,2"));
  Counts counts{};
  for (int tick = 0; tick < 4000; ++tick) {
    simulator.exchange(all_strings(geometry, 0.3), counts);
    const double angle = 2 * std::numbers::pi * tick * 0.001 / 2;
    const Vector3 wanted = kHalf * Vector3(std::cos(angle), std::sin(angle), 0);
    ASSERT_LT((simulator.pose().position - wanted).norm(), 0.0005) << tick;
  }
}

TEST(Simulator, CountsHaveTheResolutionOfTheEncoders) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Simulator simulator(geometry, parse_hand_script("circle:0.5,1"));
  Counts home{};
  ASSERT_TRUE(simulator.home(home));
  const StringLengths at_home = string_lengths(geometry, {});
  for (std::size_t i = 0; i < kStrings; ++i)
    EXPECT_NE(home[i], std::lround(at_home[i] / geometry.metres_per_count[i])) << "no offset";
  Counts counts{};
  for (int tick = 0; tick < 1000; ++tick) {
    simulator.exchange(all_strings(geometry, 0.3), counts);
    const StringLengths lengths = string_lengths(geometry, simulator.pose());
    for (std::size_t i = 0; i < kStrings; ++i) {
      const double measured = at_home[i] + (counts[i] - home[i]) * geometry.metres_per_count[i];
      ASSERT_NEAR(measured, lengths[i], 1.001 * std::abs(geometry.metres_per_count[i]));
    }
  }
}

TEST(Simulator, WordsAreAtTheMotorsOneExchangeLater) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Simulator simulator(geometry, parse_hand_script("free"));
  Counts counts{};
  DacWords words{};
  words[5] = words[4] = words[6] = words[7] = word(geometry, 2);
  simulator.exchange(words, counts);
  EXPECT_EQ(simulator.pose().position, Vector3::Zero());
  simulator.exchange(words, counts);
  EXPECT_GT(simulator.pose().position.y(), 0);
}

// Hooke: the hand gives way by force over stiffness.
TEST(Simulator, AForceMovesTheHandAgainstItsSpring) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Simulator simulator(geometry, parse_hand_script("hold:0,0,0"));
  Counts counts{};
  DacWords words = all_strings(geometry, 0.3);
  for (std::size_t upper = 4; upper < kStrings; ++upper)
    words[upper] = word(geometry, 1.3);
  for (int tick = 0; tick < 2000; ++tick)
    simulator.exchange(words, counts);
  double force = 0;
  for (std::size_t i = 0; i < kStrings; ++i) {
    const Vector3 string = geometry.motors[i] - geometry.attachments[i] - simulator.pose().position;
    force += (i < 4 ? 0.3 : 1.3) * string.normalized().y();
  }
  EXPECT_NEAR(simulator.pose().position.y(), force / 1000, 0.00002);
  EXPECT_GT(force, 2);
}

TEST(Simulator, AStringNeverPushes) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Simulator slack(geometry, parse_hand_script("free"));
  Simulator pushing(geometry, parse_hand_script("free"));
  Counts counts{};
  for (int tick = 0; tick < 200; ++tick) {
    slack.exchange(all_strings(geometry, 0), counts);
    pushing.exchange(all_strings(geometry, -5), counts);
  }
  EXPECT_EQ(slack.pose().position, Vector3::Zero());
  EXPECT_EQ(pushing.pose().position, Vector3::Zero());
}

TEST(Simulator, AFreeGripComesToRestUnderMinimumTension) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  Simulator simulator(geometry, parse_hand_script("free"));
  Counts counts{};
  for (int tick = 0; tick < 20000; ++tick)
    simulator.exchange(all_strings(geometry, 0.3), counts);
  const Vector3 before = simulator.pose().position;
  for (int tick = 0; tick < 100; ++tick)
    simulator.exchange(all_strings(geometry, 0.3), counts);
  EXPECT_LT((simulator.pose().position - before).norm(), 1e-5);
  EXPECT_LT(before.norm(), 0.03);
}

TEST(Simulator, WhateverTheWordsTheGripStaysInTheFrame) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  for (const char *script : {"free", "hold:1,1,1", "circle:1,0.1"}) {
    for (const double period : {0.00025, 0.001, 0.01}) {
      Simulator simulator(geometry, parse_hand_script(script), period);
      Counts counts{};
      for (int tick = 0; tick < 3000; ++tick) {
        DacWords words;
        for (std::size_t i = 0; i < kStrings; ++i)
          words[i] = static_cast<std::int16_t>((tick / 50 + static_cast<int>(i)) % 3 == 0 ? 32767
                                                                                          : -32768);
        simulator.exchange(words, counts);
        const Pose &pose = simulator.pose();
        ASSERT_TRUE(pose.position.allFinite() && pose.rotation.allFinite());
        ASSERT_LT(pose.position.norm(), 0.06);
        ASSERT_LT((pose.rotation.transpose() * pose.rotation - Matrix3::Identity()).norm(), 1e-9);
      }
    }
  }
}

TEST(Simulator, RefusesAPeriodThatMakesNoSense) {
  const Geometry geometry = load_geometry(kDefaultGeometry);
  for (const double period : {0.0, -1.0, 5.0, std::nan("")})
    EXPECT_THROW(Simulator(geometry, parse_hand_script("free"), period), Error) << period;
}

} // namespace spidar_simulator_test
