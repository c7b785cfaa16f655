// SPDX-License-Identifier: LGPL-2.1-or-later
// A fixed sample of the table of the closed loop: whatever the hand does, the force stays calm.
// tests/measure/force/closed-loop runs all of it.
#include "closed-loop.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <iterator>
#include <ostream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace closed_loop_test {

struct Sample {
  const char *row;
  const char *only; // words that each point has; empty: any
  std::size_t points;
  const char *on_arm; // the same of the points on the arm

  friend void PrintTo(const Sample &sample, std::ostream *out) {
    *out << sample.row << " " << sample.only;
  }
};

// Of the ways those of a hand that does not jump to its speed; with a late tick, none of 0.9 m/s.
// The arm pushes with 12 N and is 15 times as stiff: on it, what a late tick gives is kept for slow
// hands, and the rest for ticks on time. Its own damping lets no spring carry a hand at 1 Hz.
constexpr std::array kRows = {
    Sample{"still-frame", "", 80, ""},
    Sample{"surface", "", 30, "pace=1000Hz"},
    Sample{"surface+law", "", 30, "pace=1000Hz"},
    Sample{"closed-way", "acceleration=100", 60, "acceleration=100 pace=1000Hz"},
    Sample{"closed-way-law", "acceleration=100", 40, "acceleration=100 pace=1000Hz"},
    Sample{"late-tick", "acceleration=100 out=0.3", 40, "acceleration=100 out=0.05"},
    Sample{"paid-back", "acceleration=100 out=0.3", 30, "acceleration=100 out=0.05"},
    Sample{"let-go", "", 40, ""},
    Sample{"through", "acceleration=100 out=0.05", 60, "acceleration=100 out=0.05"},
    Sample{"through-calibrate", "out=0.3", 40, "acceleration=100 out=0.05 pace=4000Hz"},
    Sample{"calibrate", "", 40, ""},
    Sample{"carried", "", 40, "sway=0.2"},
    Sample{"still-thing", "", 40, "pace=1000Hz"},
    Sample{"closed-way-thing", "acceleration=100 pace=1000Hz", 60, "acceleration=100 pace=1000Hz"},
    Sample{"late-tick-thing", "acceleration=100 out=0.3", 30, "acceleration=100 out=0.05"},
    Sample{"paid-back-thing", "acceleration=100 out=0.3", 20, "acceleration=100 out=0.05"},
    Sample{"through-thing", "acceleration=100 out=0.05", 40, "acceleration=100 out=0.05"},
    Sample{"let-go-thing", "", 30, ""},
    Sample{"off-thing", "", 60, ""},
    Sample{"work", "", 40, ""},
    Sample{"off", "", 60, ""},
};

class ClosedLoop : public ::testing::TestWithParam<Sample> {
protected:
  static void expect_kept(test::Bench bench, const char *only, std::size_t count) {
    const test::LoopRow &row = test::closed_loop_row(GetParam().row, bench);
    const auto points = row.select(only, count);
    EXPECT_EQ(points.size(), count);
    for (const std::size_t point : points) {
      const test::Outcome outcome = row.run(row.at(point));
      EXPECT_TRUE(outcome.kept()) << outcome.figure << " of " << outcome.most << " " << row.figure
                                  << " " << outcome.idle << "\nclosed-loop "
                                  << (bench == test::Bench::arm ? "--arm " : "") << "--row "
                                  << row.name << " --only '" << row.words(point) << "'";
    }
  }
};

TEST_P(ClosedLoop, KeepsWhatIsWanted) {
  expect_kept(test::Bench::strings, GetParam().only, GetParam().points);
}

TEST_P(ClosedLoop, KeepsItOnADeviceOfThreeDegreesOfFreedom) {
  expect_kept(test::Bench::arm, GetParam().on_arm, GetParam().points / 2);
}

INSTANTIATE_TEST_SUITE_P(Rows, ClosedLoop, testing::ValuesIn(kRows), [](const auto &of) {
  std::string name = of.param.row;
  std::ranges::replace_if(
      name, [](char c) { return !std::isalnum(c); }, '_');
  return name;
});

// What no software prevents: the force that acts when the hand jumps acts until the loop has seen
// it.
TEST(ClosedLoopTable, AHandThatJumpsGetsNoMoreThanBeforeTheLoopKnows) {
  constexpr std::size_t kPoints = 12; // a row
  for (const test::LoopRow &row : test::closed_loop_table())
    for (const std::size_t point : row.select("out=0.9 acceleration=inf", kPoints)) {
      const test::Outcome outcome = row.run(row.at(point));
      EXPECT_TRUE(outcome.kept() || outcome.lost_to_jump())
          << outcome.figure << " of " << outcome.of_jump << " " << row.figure << " " << outcome.idle
          << "\nclosed-loop --row " << row.name << " --only '" << row.words(point) << "'";
    }
}

// It needs less than a step of the motors, and leaps by 35 um.
TEST(ClosedLoopTable, TheLightestHandIsCarriedOnTheCoarsestEncodersToo) {
  const test::LoopRow &row = test::closed_loop_row("carried", test::Bench::strings);
  const auto points = row.select("geometry=spidar-g6x4 hand=0.1kg,0.5Ns/m,0N/m max-force=1");
  EXPECT_EQ(points.size(), 6);
  for (const std::size_t point : points) {
    const test::Outcome outcome = row.run(row.at(point));
    EXPECT_TRUE(outcome.kept()) << outcome.figure << " % of the sway at " << row.words(point);
  }
}

TEST(ClosedLoopTable, FewPointsHaveAnyThreeValuesTogether) {
  for (const test::LoopRow &row : test::closed_loop_table()) {
    const auto points = row.threes();
    EXPECT_LT(points.size(), 3000U) << row.name;
    std::set<std::array<std::string, 3>> found;
    for (const std::size_t point : points) {
      std::istringstream words(row.words(point));
      const std::vector<std::string> of{std::istream_iterator<std::string>(words), {}};
      for (std::size_t a = 0; a < of.size(); ++a)
        for (std::size_t b = a + 1; b < of.size(); ++b)
          for (std::size_t c = b + 1; c < of.size(); ++c)
            found.insert({of[a], of[b], of[c]});
    }
    std::size_t all = 0;
    const auto values = [&](std::size_t axis) { return row.axes[axis].names.size(); };
    for (std::size_t a = 0; a < row.axes.size(); ++a)
      for (std::size_t b = a + 1; b < row.axes.size(); ++b)
        for (std::size_t c = b + 1; c < row.axes.size(); ++c)
          all += values(a) * values(b) * values(c);
    EXPECT_EQ(found.size(), all) << row.name;
  }
}

TEST(ClosedLoopTable, EachRowHasASample) {
  std::set<std::string> sampled;
  for (const Sample &sample : kRows)
    sampled.insert(sample.row);
  std::set<std::string> rows;
  for (const test::LoopRow &row : test::closed_loop_table())
    rows.insert(row.name);
  EXPECT_EQ(sampled, rows);
}

TEST(ClosedLoopTable, TheWordsOfAPointSelectThisPointAlone) {
  for (const test::LoopRow &row : test::closed_loop_table()) {
    const std::size_t point = row.size() / 3;
    EXPECT_EQ(row.select(row.words(point)), std::vector<std::size_t>{point}) << row.name;
  }
}

} // namespace closed_loop_test
