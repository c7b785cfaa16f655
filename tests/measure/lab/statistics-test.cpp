// SPDX-License-Identifier: LGPL-2.1-or-later
#include "results/statistics.hpp"

#include <gtest/gtest.h>

namespace {

using namespace lab;

TEST(Statistics, PercentilesLieBetweenTheRanks) {
  EXPECT_DOUBLE_EQ(percentile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(percentile({4, 1, 3, 2}, 1), 4);
  EXPECT_DOUBLE_EQ(percentile({}, 0.5), 0);
}

TEST(Statistics, TheIntervalOfManyValuesIsThatOfTheNormalDistribution) {
  std::vector<double> values;
  std::vector<int> blocks;
  for (int i = 0; i < 400; ++i) {
    values.push_back(i % 2); // standard error of the mean 0.025
    blocks.push_back(i);
  }
  const Interval interval = bootstrap(values, blocks, 1);
  EXPECT_NEAR(interval.low, 0.451, 0.005);
  EXPECT_NEAR(interval.high, 0.549, 0.005);
}

TEST(Statistics, TheIntervalOfAShareIsThatOfWilson) {
  const Interval half = wilson(5, 10);
  EXPECT_NEAR(half.low, 0.2366, 1e-4);
  EXPECT_NEAR(half.high, 0.7634, 1e-4);
  const Interval none = wilson(0, 10);
  EXPECT_NEAR(none.low, 0, 1e-9);
  EXPECT_NEAR(none.high, 0.2775, 1e-4);
}

TEST(Statistics, RepeatingAMeasurementInItsBlockMakesNothingMoreCertain) {
  std::vector<double> values;
  std::vector<int> blocks;
  for (int i = 0; i < 400; ++i) {
    values.push_back(i / 10 % 2);
    blocks.push_back(i / 10);
  }
  const Interval interval = bootstrap(values, blocks, 1);
  EXPECT_GT(interval.high - interval.low, 0.25);
}

TEST(Statistics, TheFrontHoldsWhatNothingBeatsInBoth) {
  const std::vector<SpeedAndError> all{{1, 3}, {2, 2}, {2, 3}, {3, 1}, {4, 4}};
  EXPECT_EQ(pareto_front(all), (std::vector{true, true, false, true, false}));
  EXPECT_FALSE(dominates({1, 1}, {1, 1}));
}

TEST(Statistics, TheAreaIsTheChanceThatABadAnswerHasLessConfidence) {
  EXPECT_DOUBLE_EQ(area_under(roc(std::vector{0.1, 0.2, 0.8, 0.9}, {true, true, false, false})), 1);
  EXPECT_DOUBLE_EQ(area_under(roc(std::vector{0.5, 0.5, 0.5, 0.5}, {true, true, false, false})),
                   0.5);
  EXPECT_DOUBLE_EQ(area_under(roc(std::vector{0.1, 0.3, 0.2, 0.9}, {true, true, false, false})),
                   0.75);
}

} // namespace
