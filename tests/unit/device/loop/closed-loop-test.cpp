// SPDX-License-Identifier: LGPL-2.1-or-later
// A fixed sample of the table of the closed loop: whatever the hand does, the force stays calm.
// tests/measure/force/closed-loop runs all of it.
#include "closed-loop.hpp"

#include <algorithm>
#include <array>
#include <gtest/gtest.h>
#include <ostream>
#include <set>

namespace {

struct Sample {
  const char *row;
  const char *only; // words that each point has; empty: any
  std::size_t points;

  friend void PrintTo(const Sample &sample, std::ostream *out) {
    *out << sample.row << " " << sample.only;
  }
};

// Of the ways those with a hand that does not jump to 0.9 m/s within a tick.
constexpr std::array kRows = {
    Sample{"still-frame", "", 80},
    Sample{"surface", "tap=0.01 pace=2000Hz", 30},
    Sample{"surface+law", "tap=0.01 pace=1000Hz", 30},
    Sample{"closed-way", "out=0.3", 60},
    Sample{"closed-way-law", "out=0.3", 40},
    Sample{"late-tick", "out=0.05", 40},
    Sample{"paid-back", "out=0.05", 30},
    Sample{"let-go", "max-force=1", 40},
    Sample{"through", "out=0.05", 60},
    Sample{"through-calibrate", "out=0.05 pace=4000Hz", 20},
    Sample{"calibrate", "", 40},
    Sample{"work", "", 40},
    Sample{"off", "pace=1000Hz", 60},
};

class ClosedLoop : public ::testing::TestWithParam<Sample> {};

TEST_P(ClosedLoop, KeepsWhatIsWanted) {
  const test::LoopRow &row = test::closed_loop_row(GetParam().row);
  const auto points = row.select(GetParam().only, GetParam().points);
  EXPECT_EQ(points.size(), GetParam().points);
  for (const std::size_t point : points) {
    const test::Outcome outcome = row.run(row.at(point));
    EXPECT_TRUE(outcome.kept()) << outcome.figure << " of " << outcome.most << " " << row.figure
                                << " " << outcome.idle << "\nclosed-loop --row " << row.name
                                << " --only '" << row.words(point) << "'";
  }
}

INSTANTIATE_TEST_SUITE_P(Rows, ClosedLoop, testing::ValuesIn(kRows), [](const auto &of) {
  std::string name = of.param.row;
  std::ranges::replace_if(
      name, [](char c) { return !std::isalnum(c); }, '_');
  return name;
});

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

} // namespace
