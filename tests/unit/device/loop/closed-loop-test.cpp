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

constexpr std::array kRowsKept = {
    Sample{"still-frame", "", 110},
    Sample{"surface", "hand=simulator", 30},
    Sample{"surface+law", "hand=simulator", 30},
    Sample{"let-go", "max-force=1", 50},
    Sample{"work", "", 80},
    Sample{"off", "", 100},
};
// The other points of surface, surface+law and let-go, and these rows as a whole, wait for the
// account of the energy.
constexpr std::array kRowsNotKeptYet = {"closed-way", "closed-way-law",    "late-tick", "paid-back",
                                        "through",    "through-calibrate", "calibrate"};

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

INSTANTIATE_TEST_SUITE_P(Rows, ClosedLoop, testing::ValuesIn(kRowsKept), [](const auto &of) {
  std::string name = of.param.row;
  std::ranges::replace_if(
      name, [](char c) { return !std::isalnum(c); }, '_');
  return name;
});

TEST(ClosedLoopTable, EachRowIsKeptOrListedAsNotKeptYet) {
  std::set<std::string> named(kRowsNotKeptYet.begin(), kRowsNotKeptYet.end());
  for (const Sample &sample : kRowsKept)
    named.insert(sample.row);
  std::set<std::string> rows;
  for (const test::LoopRow &row : test::closed_loop_table())
    rows.insert(row.name);
  EXPECT_EQ(named, rows);
}

TEST(ClosedLoopTable, TheWordsOfAPointSelectThisPointAlone) {
  for (const test::LoopRow &row : test::closed_loop_table()) {
    const std::size_t point = row.size() / 3;
    EXPECT_EQ(row.select(row.words(point)), std::vector<std::size_t>{point}) << row.name;
  }
}

} // namespace
