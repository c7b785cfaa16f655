// SPDX-License-Identifier: LGPL-2.1-or-later
#include "share/sample-ring.hpp"

#include <gtest/gtest.h>
#include <thread>

namespace sample_ring_test {

TEST(SampleRing, KeepsTheOrderAndRefusesWhatIsTooMuch) {
  haptic::SampleRing<int, 4> ring;
  int value = 0;
  EXPECT_FALSE(ring.pop(value));
  for (int i = 0; i < 4; ++i)
    EXPECT_TRUE(ring.push(i));
  EXPECT_FALSE(ring.push(4));
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(ring.pop(value));
    EXPECT_EQ(value, i);
  }
  EXPECT_FALSE(ring.pop(value));
}

TEST(SampleRing, NothingIsLostOrTornBetweenTwoThreads) {
  struct Pair {
    int a = 0;
    int b = 0;
  };
  constexpr int kCount = 10'000;
  haptic::SampleRing<Pair, 16> ring;
  std::jthread writer([&] {
    for (int i = 0; i < kCount;)
      i += ring.push({i, -i});
  });
  Pair pair;
  for (int i = 0; i < kCount;)
    if (ring.pop(pair)) {
      ASSERT_EQ(pair.a, i);
      ASSERT_EQ(pair.b, -i);
      ++i;
    }
}

} // namespace sample_ring_test
