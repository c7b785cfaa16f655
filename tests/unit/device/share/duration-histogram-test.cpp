// SPDX-License-Identifier: LGPL-2.1-or-later
#include "share/duration-histogram.hpp"

#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <vector>

namespace duration_histogram_test {

using haptic::DurationHistogram;

class Histogram : public ::testing::Test {
protected:
  std::unique_ptr<DurationHistogram> histogram_ = std::make_unique<DurationHistogram>();
};

TEST_F(Histogram, IsZeroWithoutRecords) {
  EXPECT_EQ(histogram_->percentile_us(0.99), 0);
  EXPECT_EQ(histogram_->max_us(), 0);
}

TEST_F(Histogram, PercentilesAreAtMostSixPercentHighAndNeverLow) {
  std::mt19937 random(4);
  std::lognormal_distribution<double> duration(9, 2); // around 8 us, widely spread
  std::vector<double> exact;
  for (int i = 0; i < 100'000; ++i) {
    const auto ns = static_cast<std::int64_t>(duration(random));
    histogram_->record(ns);
    exact.push_back(static_cast<double>(ns) * 1e-3);
  }
  std::sort(exact.begin(), exact.end());
  for (double p : {0.01, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const double wanted = exact[static_cast<std::size_t>(std::ceil(p * 100'000)) - 1];
    EXPECT_GE(histogram_->percentile_us(p), wanted - 1e-9) << p;
    EXPECT_LE(histogram_->percentile_us(p), wanted * 1.0626 + 1e-3) << p;
  }
  EXPECT_EQ(histogram_->max_us(), exact.back());
}

TEST_F(Histogram, TakesDurationsOfEverySize) {
  for (std::int64_t ns : {std::int64_t{-5}, std::int64_t{0}, std::int64_t{1}, std::int64_t{15},
                          std::int64_t{16}, std::int64_t{17}, INT64_MAX})
    histogram_->record(ns);
  EXPECT_EQ(histogram_->percentile_us(2.0 / 7), 0);
  EXPECT_NEAR(histogram_->percentile_us(4.0 / 7), 0.015, 1e-12);
  EXPECT_NEAR(histogram_->percentile_us(6.0 / 7), 0.017, 1e-12);
  EXPECT_GT(histogram_->max_us(), 1e15);
}

TEST_F(Histogram, LeavesOutWhatItHadCountedBefore) {
  for (int i = 0; i < 100; ++i)
    histogram_->record(9000);
  const auto before = histogram_->counts();
  EXPECT_EQ(histogram_->percentile_us(1, before), 0);
  histogram_->record(15);
  histogram_->record(17);
  EXPECT_NEAR(histogram_->percentile_us(0.5, before), 0.015, 1e-12);
  EXPECT_NEAR(histogram_->percentile_us(1, before), 0.017, 1e-12);
}

TEST_F(Histogram, ForgetsOnReset) {
  histogram_->record(1000);
  *histogram_ = {};
  EXPECT_EQ(histogram_->percentile_us(1), 0);
  EXPECT_EQ(histogram_->max_us(), 0);
}

} // namespace duration_histogram_test
