// SPDX-License-Identifier: LGPL-2.1-or-later
#include "loop/suspend-detector.hpp"

#include <gtest/gtest.h>

namespace suspend_detector_test {

constexpr std::int64_t kSecond = 1'000'000'000; // ns

TEST(SuspendDetector, TellsASleepOnceAndNotTheSleepsOfBefore) {
  haptic::SuspendDetector detector;
  const std::int64_t slept_before = 3600 * kSecond;
  EXPECT_FALSE(detector.has_slept(10 * kSecond, 10 * kSecond + slept_before));
  EXPECT_FALSE(detector.has_slept(11 * kSecond, 11 * kSecond + slept_before));
  EXPECT_TRUE(detector.has_slept(12 * kSecond, 72 * kSecond + slept_before));
  EXPECT_FALSE(detector.has_slept(13 * kSecond, 73 * kSecond + slept_before));
}

TEST(SuspendDetector, BeingHeldUpBetweenTheTwoClocksIsNoSleep) {
  haptic::SuspendDetector detector;
  for (int i = 0; i < 1000; ++i)
    EXPECT_FALSE(detector.has_slept(i * kSecond, i * kSecond + (i % 7) * 40'000'000));
}

} // namespace suspend_detector_test
